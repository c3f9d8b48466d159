"""Directive ``criteria``: every criterion that comes with tracer, written from the documentation of its file."""

import importlib
import inspect
import re

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

from tracer.criteria import registry


def as_rst(text: str) -> list[str]:
    """Return lines of a docstring whose formulas are indented as lines of reStructuredText."""
    lines: list[str] = []
    for line in text.splitlines():
        is_formula, was_formula = line.startswith("    "), bool(lines) and lines[-1].startswith("    ")
        if is_formula and not was_formula:
            lines += ["::", ""]
        if not is_formula:
            line = re.sub(r"^([A-Z])\. ", r"\\\1. ", line).replace("|", r"\|")  # an author is no item of a list
        lines.append(line)
    return lines


class Criteria(SphinxDirective):
    """Write a section for each file of criteria."""

    def run(self) -> list[nodes.Node]:
        """Return the sections: the names that a file registers, and what it says of them."""
        registry.import_all()
        names_by_module: dict[str, list[str]] = {}
        for name, entry in sorted(registry.registered.items()):
            if entry.is_built_in:
                names_by_module.setdefault(entry.importance.__module__, []).append(name)
        lines: list[str] = []
        for module, names in sorted(names_by_module.items()):
            title = ", ".join(names)
            about = inspect.getdoc(importlib.import_module(module)) or ""
            lines += [title, "-" * len(title), "", *as_rst(about), ""]
        return self.parse_text_to_nodes("\n".join(lines), allow_section_headings=True)


def setup(app: Sphinx) -> dict[str, bool]:
    """Make the directive known."""
    app.add_directive("criteria", Criteria)
    return {"parallel_read_safe": True}

"""Directive ``plugins``: every plugin, written from the documentation at the top of its file.

That documentation is written as Mitsuba's is: ``pluginparameters`` is a list of names, types and meanings, and ``tabs``
hold the same example in XML and in Python.
"""

import ast
from pathlib import Path

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.directives.code import CodeBlock
from sphinx.util.docutils import SphinxDirective

FOLDER = Path(__file__).parents[2] / "plugins"
TYPES = ["string", "float", "int", "bool", "integrator", "sampler", "texture", "spectrum"]


def names() -> list[str]:
    """Return the names of all plugins, from the list of them; to import it, Mitsuba would have to be ready."""
    for statement in ast.parse((FOLDER / "__init__.py").read_text()).body:
        if isinstance(statement, ast.Assign) and ast.unparse(statement.targets[0]) == "PLUGINS":
            return sorted(ast.literal_eval(statement.value))
    raise RuntimeError("plugins/__init__.py has no list PLUGINS.")


class PluginParameters(SphinxDirective):
    """Parameters of a plugin, as definitions."""

    has_content = True

    def run(self) -> list[nodes.Node]:
        """Return a list of definitions made of the rows, each of which is a list of name, type and meaning."""
        container = nodes.container()
        self.state.nested_parse(self.content, self.content_offset, container)
        definitions = nodes.definition_list()
        for row in container[0].children:
            name, kind, *meaning = row[0].children
            title = nodes.literal("", name.astext())
            term = nodes.term("", "", title, nodes.Text(" : "), nodes.emphasis("", kind.astext().strip("|")))
            definitions += nodes.definition_list_item("", term, nodes.definition("", *meaning[0].children))
        return [definitions]


class Tabs(SphinxDirective):
    """A container of examples."""

    has_content = True

    def run(self) -> list[nodes.Node]:
        """Return the examples one after the other."""
        container = nodes.container()
        self.state.nested_parse(self.content, self.content_offset, container)
        return container.children


class Plugins(SphinxDirective):
    """Write a section for each plugin."""

    def run(self) -> list[nodes.Node]:
        """Return the sections."""
        lines: list[str] = [line for kind in TYPES for line in (f".. |{kind}| replace:: {kind}",)] + [""]
        for name in names():
            documentation = ast.get_docstring(ast.parse((FOLDER / f"{name}.py").read_text())) or ""
            lines += [name, "-" * len(name), "", *documentation.splitlines(), ""]
        return self.parse_text_to_nodes("\n".join(lines), allow_section_headings=True)


def setup(app: Sphinx) -> dict[str, bool]:
    """Make the directives known."""
    for name, directive in {
        "pluginparameters": PluginParameters,
        "tabs": Tabs,
        "code-tab": CodeBlock,
        "plugins": Plugins,
    }.items():
        app.add_directive(name, directive)
    return {"parallel_read_safe": True}

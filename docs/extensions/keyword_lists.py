"""Lists of keywords in docstrings: a line that ends with a colon, and below it ``name: meaning``, indented."""

import re
from typing import Any

from sphinx.application import Sphinx

ENTRY = re.compile(r"^    ([a-z_]+(?:, [a-z_]+)*): (.*)$")
"""Pattern of the first line of an entry; its groups are the names and what is said of them."""


def as_list(app: Sphinx, what: str, name: str, documented: Any, options: Any, lines: list[str]) -> None:
    """Turn the lists of keywords in the lines of a docstring into lists of reStructuredText, in place."""
    written: list[str] = []
    is_in_list = False
    for number, line in enumerate(lines):
        following = lines[number + 1] if number + 1 < len(lines) else ""
        entry = ENTRY.match(line)
        if re.match(r"^\S.*[^:]:$", line) and ENTRY.match(following):
            is_in_list = True
            written += [f"**{line.removesuffix(':')}**", ""]
        elif is_in_list and entry is not None:
            written.append(f"- ``{entry[1]}``: {entry[2]}")
        elif is_in_list and line.startswith("        "):
            written.append(f"  {line.strip()}")
        else:
            is_in_list = is_in_list and not line.strip()
            written.append(line)
    lines[:] = written


def setup(app: Sphinx) -> dict[str, bool]:
    """Let docstrings be changed before they are shown."""
    app.connect("autodoc-process-docstring", as_list)
    return {"parallel_read_safe": True}

"""Keep tables that a Markdown file quotes up to date: ``python -m tracer.study.quote README.md``.

A table stands between ``<!-- table: FILE -->`` or ``<!-- table: FILE # HEADING -->`` and ``<!-- end -->``. FILE is a
path from the folder of the Markdown file; its first table is quoted, or the first below the heading.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path

from tracer.errors import OutputError
from tracer.io.atomic import write_text
from tracer.study.each_file import exit_code_of_each

BLOCK = re.compile(r"(<!-- table: (\S+)(?: # ([^\n]+?))? -->\n)(.*?)(<!-- end -->)", re.DOTALL)
"""Pattern of a quoted table with its marks; its groups are the first mark, FILE, HEADING, the table and the end."""
TABLE = re.compile(r"(?:^\|.*\n)+", re.MULTILINE)
"""Pattern of a table in Markdown."""


def quote(text: str, folder: Path) -> str:
    """Return ``text`` with every quoted table as it stands in its file now. Raises OutputError for a missing table."""

    def renewed(block: re.Match[str]) -> str:
        return block[1] + find_table(folder / block[2], block[3]) + block[5]

    return BLOCK.sub(renewed, text)


def find_table(path: Path, heading: str | None) -> str:
    """Return the first table of a Markdown file, or the first below ``heading``. Raises OutputError without one."""
    if not path.is_file():
        raise OutputError(f"There is no file '{path}' to take a table from.")
    text = path.read_text(encoding="utf-8")
    if heading is not None:
        _, separator, text = text.partition(f"# {heading}\n")
        if not separator:
            raise OutputError(f"'{path}' has no heading '{heading}'.")
    table = TABLE.search(text)
    if table is None:
        raise OutputError(f"'{path}' has no table{f' below {heading!r}' if heading else ''}.")
    return table[0]


def main(arguments: list[str]) -> int:
    """Renew the tables in the Markdown files that ``arguments`` name; return an exit code."""
    return exit_code_of_each(arguments, renew_tables)


def renew_tables(path: Path) -> None:
    """Renew the tables in a Markdown file. Raises OutputError if a file has no such table."""
    write_text(path, quote(path.read_text(encoding="utf-8"), path.parent))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

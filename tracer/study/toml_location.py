"""Where a study's settings come from, so that an error names the line of the mistake."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass

from tracer.errors import SettingsError

Location = tuple[str | int, ...]
"""Keys and indices that lead to a value, for example ("scenes", 0, "path")."""

TABLE = re.compile(r"\s*(\[{1,2})\s*([^\[\]]+?)\s*\]{1,2}\s*(#.*)?$")
"""Pattern of the header of a table; its groups are the opening brackets, the dotted key, and a comment."""
ENTRY = re.compile(r"""\s*((?:[\w-]+|"[^"]*"|'[^']*')(?:\s*\.\s*(?:[\w-]+|"[^"]*"|'[^']*'))*)\s*=""")
"""Pattern of the start of a line that sets a key; its group is the dotted key."""


@dataclass(frozen=True)
class Origin:
    """A TOML file; or a command, which has just a name; or settings from Python, which have neither name nor text."""

    name: str = ""
    """Name in messages: that of the file, study or command."""
    text: str = ""
    """The TOML text."""

    def fault(self, message: str, location: Location = (), value: object = None) -> SettingsError:
        """Return an error that says where the mistake is, and then ``message``; ``value``: as in ``find_line``."""
        sentence = message if message.endswith(("?", ".")) else message + "."
        line = find_line(self.text, location, value)
        if line is not None:
            return SettingsError(f"{self.name}, line {line}: {sentence}")
        return SettingsError(f"{self.name or '.'.join(map(str, location)) or 'study'}: {sentence}")


def find_line(text: str, location: Location, value: object = None) -> int | None:
    """Return the line, from 1, that sets the value at ``location``, or else that of the innermost table around it.

    ``value``: the value, or an entry of a list; of a list over many lines, the line of this entry is returned. Returns
    None if the text has no such table either.
    """
    places = list(entries(text))
    line_of = dict(reversed(places))
    start = next((line_of[location[:size]] for size in range(len(location), 0, -1) if location[:size] in line_of), None)
    if start is None or value is None:
        return start
    end = min((line for _, line in places if line > start), default=start + 1 + text.count("\n"))
    spelling = re.compile(rf"""(?<![\w.])["']?{re.escape(str(value))}["']?(?![\w.])""")
    lines = text.splitlines()
    return next((line for line in range(start, min(end, len(lines) + 1)) if spelling.search(lines[line - 1])), start)


def entries(text: str) -> Iterator[tuple[Location, int]]:
    """Yield the location of every table and key of a TOML text, with its line from 1."""
    table: Location = ()
    counts: dict[Location, int] = {}
    for line, content in enumerate(text.splitlines(), start=1):
        if header := TABLE.match(content):
            table = keys(header[2])
            if header[1] == "[[":
                counts[table] = counts.get(table, -1) + 1
                table = (*table, counts[table])
            yield table, line
        elif entry := ENTRY.match(content):
            yield (*table, *keys(entry[1])), line


def keys(dotted: str) -> Location:
    """Return the parts of a dotted key, each without quotes."""
    return tuple(part.strip().strip("\"'") for part in re.findall(r"""[\w-]+|"[^"]*"|'[^']*'""", dotted))

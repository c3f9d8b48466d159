"""Where a study's settings come from, so that a mistake is told with its line."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass

from tracer.errors import SettingsError

Location = tuple[str | int, ...]
"""Way to a value, for example ("scenes", 0, "path")."""

TABLE = re.compile(r"\s*(\[{1,2})\s*([^\[\]]+?)\s*\]{1,2}\s*(#.*)?$")
ENTRY = re.compile(r"""\s*((?:[\w-]+|"[^"]*"|'[^']*')(?:\s*\.\s*(?:[\w-]+|"[^"]*"|'[^']*'))*)\s*=""")


@dataclass(frozen=True)
class Origin:
    """A TOML file; or settings made in Python, which have neither name nor text; or a command, which has a name."""

    name: str = ""
    """What a message calls it: the path of the file."""
    text: str = ""

    def fault(self, message: str, location: Location = (), value: object = None) -> SettingsError:
        """Return an error: where, then ``message``. ``value`` helps to find the line within a list of many lines."""
        said = message if message.endswith(("?", ".")) else message + "."
        line = find_line(self.text, location, value)
        if line is not None:
            return SettingsError(f"{self.name}, line {line}: {said}")
        return SettingsError(f"{self.name or '.'.join(map(str, location)) or 'study'}: {said}")


def find_line(text: str, location: Location, value: object = None) -> int | None:
    """Return the line, from 1, on which the value at ``location`` is set; that of the table around it if it is not.

    ``value``: what stands there; of a list over several lines, the line of this entry is found.
    """
    places = list(entries(text))
    known = dict(reversed(places))
    found = next((known[location[:size]] for size in range(len(location), 0, -1) if location[:size] in known), None)
    if found is None or value is None:
        return found
    end = min((line for _, line in places if line > found), default=found + 1 + text.count("\n"))
    spelt = re.compile(rf"""(?<![\w.])["']?{re.escape(str(value))}["']?(?![\w.])""")
    lines = text.splitlines()
    return next((line for line in range(found, min(end, len(lines) + 1)) if spelt.search(lines[line - 1])), found)


def entries(text: str) -> Iterator[tuple[Location, int]]:
    """Yield every table and key of a TOML text with its line."""
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
    """Return the parts of a dotted key, without quotes."""
    return tuple(part.strip().strip("\"'") for part in re.findall(r"""[\w-]+|"[^"]*"|'[^']*'""", dotted))

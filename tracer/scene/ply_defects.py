"""Find out what is wrong with a PLY file that Mitsuba does not load."""

from __future__ import annotations

import re
import struct
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

SCALARS = {
    **dict.fromkeys(("char", "int8"), "b"),
    **dict.fromkeys(("uchar", "uint8"), "B"),
    **dict.fromkeys(("short", "int16"), "h"),
    **dict.fromkeys(("ushort", "uint16"), "H"),
    **dict.fromkeys(("int", "int32"), "i"),
    **dict.fromkeys(("uint", "uint32"), "I"),
    **dict.fromkeys(("float", "float32"), "f"),
    **dict.fromkeys(("double", "float64"), "d"),
}
"""Format of the module ``struct``, by type of a PLY property."""
CORNERS = ("vertex_indices", "vertex_index")
"""Names that the list of a face's corners may have."""
ANEW = "export it anew"
"""What to do about most defects, as the end of a message."""


@dataclass(frozen=True)
class Element:
    """A kind of entry in a PLY file, such as "vertex" or "face", as the header describes it."""

    name: str
    """Name that the header gives it."""
    count: int
    """Number of entries of this kind."""
    properties: list[list[str]]
    """Words of the header for each property: type and name; or "list", types of length and entries, and name."""

    @property
    def scalars(self) -> str | None:
        """Format of one entry for ``struct``; None if it has lists."""
        kinds = [SCALARS.get(words[0]) for words in self.properties]
        return None if None in kinds else "".join(kind for kind in kinds if kind)

    @property
    def names(self) -> list[str]:
        """Names of the element's properties."""
        return [words[-1] for words in self.properties]


def ply_defect(data: bytes) -> str | None:
    """Return what is wrong with the content of a PLY file and what to do, as a predicate; None if nothing is found."""
    if not data.startswith(b"ply"):
        return "is no PLY file; name the plugin of its format"
    head, end, body = re.sub(rb"\r\n?", b"\n", data[: data.find(b"end_header") + 12]).partition(b"end_header\n")
    if not end:
        return f"has no whole PLY header; {ANEW}"
    try:
        order, elements = ply_header(head.decode("latin-1"))
    except (ValueError, IndexError):
        return None
    body = data[data.find(b"end_header") :].split(b"\n", 1)[1]
    counts = {element.name: element.count for element in elements}
    missing_axes = [
        axis for element in elements if element.name == "vertex" for axis in "xyz" if axis not in element.names
    ]
    if missing_axes:
        return f"has vertices without {' and '.join(missing_axes)}; {ANEW}"
    if "tristrips" in counts and not counts.get("face"):
        return "has strips of triangles, which Mitsuba does not read; export it as single triangles"
    if not counts.get("face"):
        points = counts.get("vertex", 0)
        return f"holds {points} points and no faces; make a surface of them, or place a small sphere at each"
    lists = [
        words[-1] for element in elements if element.name == "face" for words in element.properties if len(words) > 2
    ]
    if len(lists) > 1:
        return f"has faces with more than one list ({' and '.join(lists)}); export it with the corners alone"
    take: Take = tokens(body) if order is None else binary(body, order)
    try:
        corners = next((count for count in corner_counts(elements, take) if count != 3), 3)
    except IndexError:
        return f"ends before its {counts['face']} faces do; {ANEW}"
    except (ValueError, KeyError):
        return None
    if corners == 3:
        return None
    return (
        f"has a face of {corners} corners, and of PLY files Mitsuba reads only triangles; triangulate the mesh when "
        "you export it, or save it as OBJ, whose polygons are cut as they are read"
    )


def ply_header(text: str) -> tuple[str | None, list[Element]]:
    """Return the byte order for ``struct`` (None for text) and the elements. Raises ValueError or IndexError."""
    order: str | None = None
    elements: list[Element] = []
    for line in text.split("\n"):
        words = line.split()
        if words[:1] == ["format"]:
            order = {"ascii": None, "binary_little_endian": "<", "binary_big_endian": ">"}.get(words[1])
        elif words[:1] == ["element"]:
            elements.append(Element(words[1], int(words[2]), []))
        elif words[:1] == ["property"]:
            elements[-1].properties.append(words[1:])
    return order, elements


Take = Callable[[str, int], Any]
"""Function of a ``struct`` format and a number of times: reads that much of a file, and returns the last number that it
read, from a file in text as it is written."""


def tokens(body: bytes) -> Take:
    """Return the function that reads the body of a PLY file in text, from the first word on."""
    words, place = body.split(), 0

    def take(formats: str, times: int) -> bytes:
        nonlocal place
        place += len(formats) * times
        return words[place - 1]

    return take


def binary(body: bytes, order: str) -> Take:
    """Return the function that reads the body of a binary PLY file, from the first byte on; ``order``: byte order."""
    place = 0

    def take(formats: str, times: int) -> float:
        nonlocal place
        place += struct.calcsize(order + formats) * times
        if place > len(body):
            raise IndexError
        return (
            struct.unpack_from(order + formats[-1:], body, place - struct.calcsize(order + formats[-1:]))[0]
            if times
            else 0
        )

    return take


def corner_counts(elements: list[Element], take: Take) -> Iterator[int]:
    """Yield how many corners each face of a PLY file has. Raises IndexError where the file ends too early."""
    for element in elements:
        if element.scalars is not None:
            take(element.scalars, element.count)
            continue
        for _ in range(element.count):
            for words in element.properties:
                if words[0] != "list":
                    take(SCALARS[words[0]], 1)
                    continue
                count = int(take(SCALARS[words[1]], 1))
                if element.name == "face" and words[-1] in CORNERS:
                    yield count
                take(SCALARS[words[2]], count)

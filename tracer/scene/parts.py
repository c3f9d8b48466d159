"""The parts of a mesh file, whatever its format."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from tracer.core.arrays import Floats, Integers, Singles

Colour = tuple[float, float, float]
"""Red, green and blue, linear sRGB."""
GREY: Colour = (0.5, 0.5, 0.5)
"""Colour of a part whose file tells none, linear sRGB."""
DIGITS = 1e-4
"""Lengths of this share of the distance from the origin must be told apart in single precision."""


@dataclass(frozen=True, eq=False)
class Material:
    """What the file tells of a material."""

    name: str = ""
    colour: Colour = GREY
    """Multiplies the texture, if there is one."""
    texture: Singles | None = None
    """(rows, columns, 3): encoded as sRGB, 0 to 1."""
    metallic: float = 0.0
    roughness: float = 1.0


@dataclass(frozen=True, eq=False)
class Part:
    """Triangles of one material."""

    name: str
    vertices: Floats
    """(N, 3): in world coordinates."""
    faces: Integers
    """(F, 3): vertices of each triangle."""
    normals: Floats | None
    """(N, 3): unit vectors; of the file, or the mean of the faces around each vertex. None: triangles look flat."""
    places: Floats | None
    """(N, 2): places in the texture, from the lower left; None if there are none."""
    material: Material
    attributes: Mapping[str, Floats] = field(default_factory=dict)
    """(N, D) or (F, D): values by vertex or by triangle; names begin with vertex_ or face_."""


def own_names(parts: list[Part]) -> list[str]:
    """Return a name for each part that no other part has."""
    seen: dict[str, int] = {}
    names = []
    for part in parts:
        seen[part.name] = seen.get(part.name, 0) + 1
        names.append(part.name if seen[part.name] == 1 else f"{part.name} {seen[part.name]}")
    return names


def recentred(parts: list[Part]) -> tuple[list[Part], Floats]:
    """Return parts near enough to the origin for single precision, and where their origin was (3,)."""
    low = np.min([part.vertices.min(axis=0) for part in parts], axis=0)
    high = np.max([part.vertices.max(axis=0) for part in parts], axis=0)
    middle: Floats = (low + high) / 2
    if np.abs(middle).max() * DIGITS <= np.linalg.norm(high - low):
        return parts, np.zeros(3)
    return [replace(part, vertices=part.vertices - middle) for part in parts], middle


def content_of(parts: list[Part]) -> Iterator[bytes]:
    """Yield all that decides what pictures of parts show, piece by piece."""
    for part in parts:
        material = part.material
        yield repr((part.name, material.name, material.colour, material.metallic, material.roughness)).encode()
        for array in (part.vertices, part.faces, part.normals, part.places, material.texture):
            yield b"" if array is None else array.tobytes()

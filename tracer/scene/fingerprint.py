"""A hash that identifies the content of a scene, however it is given: it covers everything that decides its pictures.

Contents are hashed, not printed forms alone: things that print the same may differ in their last digits, or within
arrays that are too long to be printed.
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from tracer.scene.load import parse, properties

ADDRESS = re.compile(rb"0x[0-9a-f]+")
"""Pattern of an object's address in memory, which some objects print of themselves and which no hash may cover."""
DIGITS = 16
"""Hexadecimal digits of a fingerprint: 64 bits."""


def fingerprint(source: Any, define: dict[str, str] | None = None) -> str:
    """Return a hash (hexadecimal, 16 digits) of the content of a scene. Raises SceneError.

    For a path it covers the XML, all files that it includes, and the content of every file that it names (meshes,
    textures, volumes); for a dictionary, the same after parsing, with the content of all arrays and objects in it; for
    a loaded scene, what the scene prints of itself and the content of all its parameters (meshes, textures,
    transforms).
    """
    if not isinstance(source, str | Path | dict):
        return digest(*content(source))
    parsed = parse(source, define)
    pieces = [repr(sorted(define.items())).encode() if define else b""]
    pieces += [Path(str(file)).read_bytes() for file in parsed.state.files]
    for node in parsed.state.nodes:
        for name, value in properties(source, node):
            if isinstance(source, dict):
                pieces += [f"{node.props.plugin_name()} {name}".encode(), *content(value)]
            elif hasattr(value, "wavelengths"):  # a spectrum from a file, which was read with the scene
                pieces += content(value)
            if isinstance(value, str) and (file := parsed.find(value)):
                pieces.append(file.read_bytes())
    return digest(*pieces)


def digest(*pieces: bytes) -> str:
    """Return a hash of 16 hexadecimal digits, which depends on where one piece ends and the next begins."""
    total = hashlib.sha256()
    for piece in pieces:
        total.update(len(piece).to_bytes(8, "little") + piece)
    return total.hexdigest()[:DIGITS]


def content(value: Any) -> Iterator[bytes]:
    """Yield the content of a property, an array or a Mitsuba object, piece by piece."""
    yield type(value).__name__.encode()
    if isinstance(value, mi.Bitmap):
        yield f"{value.pixel_format()} {value.srgb_gamma()} {value.premultiplied_alpha()}".encode()
        yield from content(np.array(value))
    elif isinstance(value, mi.VolumeGrid):
        yield from content(np.array(value))
    elif isinstance(value, mi.Object):
        yield ADDRESS.sub(b"", str(value).encode())
        for name, parameter in sorted(mi.traverse(value), key=lambda entry: entry[0]):
            yield name.encode()
            yield from content(parameter)
    elif hasattr(value, "wavelengths"):
        yield from content(np.array([list(value.wavelengths), list(value.values)]))
    elif hasattr(value, "matrix"):
        yield from content(value.matrix)
    elif isinstance(value, np.ndarray):
        yield f"{value.dtype} {value.shape}".encode()
        yield np.ascontiguousarray(value).tobytes()
    elif dr.is_array_v(value) or dr.is_tensor_v(value):
        yield from content(np.array(value))
    else:
        yield ADDRESS.sub(b"", repr(value).encode())

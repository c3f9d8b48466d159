"""Files of illuminance: false colours, numbers by pixel, and a table by surface."""

from __future__ import annotations

import csv
import io
from pathlib import Path
from typing import Any

import numpy as np

from tracer.core.arrays import Floats, Mask
from tracer.io import atomic
from tracer.io.exr import Window, write_exr
from tracer.radiosity.false_colours import Scale, write_false_colours
from tracer.radiosity.photometry import LitSurface

SUFFIXES = (".png", ".exr", ".csv")
"""Suffixes of files of illuminance."""
TABLE = ".csv"
"""Suffix of a table by surface; the others are of pictures."""


def write_picture(path: Path, lux: Floats, lit: Mask, scale: Scale, window: Window, metadata: dict[str, Any]) -> None:
    """Write illuminance (H, W) in lux: a PNG in false colours, or an EXR with the channel Y. Raises WriteError.

    ``lit`` (H, W): where a surface is seen; ``scale``: that of false colours; ``window`` and ``metadata``:
    for the EXR, see ``write_exr``.
    """
    if path.suffix.lower() == ".png":
        write_false_colours(path, lux, lit, scale)
    else:
        values = np.where(lit, lux, 0)[..., None].astype(np.float32)
        write_exr(path, ["Y"], values, {"unit": "lux", **metadata}, window)


def write_table(path: Path, surfaces: list[LitSurface]) -> None:
    """Write the illuminance of surfaces as CSV, in lux; areas are in square units of the scene. Raises WriteError."""
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(["surface", "material", "area", "mean", "least", "greatest", "uniformity"])
    for surface in surfaces:
        numbers = (surface.area, surface.mean, surface.least, surface.greatest, surface.uniformity)
        writer.writerow([surface.name, surface.material, *(f"{number:.6g}" for number in numbers)])
    atomic.write_text(path, stream.getvalue())

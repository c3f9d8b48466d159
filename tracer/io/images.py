"""Read pictures by any renderer as linear sRGB."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tracer.core.suggest import did_you_mean
from tracer.errors import LayerError, ScoreError
from tracer.image.colour import decode_srgb
from tracer.image.metrics import SSIM_WINDOW, comparable, require_finite
from tracer.io.exr import opened, said

COMBINED = "Combined"
"""What Blender calls the layer of the finished picture."""


def read_picture(path: Path, layer: str | None = None) -> NDArray[np.float32]:
    """Return the colours (H, W, 3), or (H, W, 1) of a grey picture, in linear sRGB.

    Whole numbers (PNG, JPEG) are taken to be encoded with the sRGB curve, floating-point numbers to be linear.
    ``layer``: what stands before ".R" in the names of the channels; None takes the picture without a layer, else
    Blender's "Combined", else the only one there is. Raises ScoreError; LayerError where ``layer`` is not there.
    """
    if not path.is_file():
        raise ScoreError(f"There is no picture '{path}'.")
    with opened(path) as source:
        found: dict[str, tuple[int, list[int]]] = {}
        part = 0
        while source.seek_subimage(part, 0):
            for name, channels in layers(list(source.spec().channelnames)).items():
                found.setdefault(name, (part, channels))
            part += 1
        part, channels = found[choose(path, found, layer)]
        source.seek_subimage(part, 0)
        values = read_channels(path, source, channels)
        encoded = str(source.spec().format) not in FLOATING
    require_finite(values, f"'{path}'")
    return decode_srgb(values).astype(np.float32) if encoded else values


def read_values(path: Path) -> NDArray[np.float64]:
    """Return the values of a picture (H, W) as they are in the file, not decoded: mean of its colours, without alpha.

    Whole numbers are scaled to [0, 1]. Raises ScoreError.
    """
    if not path.is_file():
        raise ScoreError(f"There is no picture '{path}'.")
    with opened(path) as source:
        names = list(source.spec().channelnames)
        colours = [k for k, name in enumerate(names) if name.rpartition(".")[2] in ("R", "G", "B")]
        return read_channels(path, source, colours or [0]).mean(axis=-1, dtype=np.float64)


def read_channels(path: Path, source: Any, channels: list[int]) -> NDArray[np.float32]:
    """Return some channels of the part that ``source`` is at, (H, W, N)."""
    specification = source.spec()
    values = source.read_image("float")
    if values is None:
        raise ScoreError(f"Cannot read '{path}': {said(source)}.")
    shape = specification.height, specification.width, specification.nchannels
    return np.asarray(values, np.float32).reshape(shape)[..., channels]


FLOATING = ("half", "float", "double")


def layers(names: list[str]) -> dict[str, list[int]]:
    """Return layers by name, "" for channels without one: the places of R, G, B, or of Y alone."""
    places = {name: k for k, name in enumerate(names)}
    found = {}
    for name in names:
        prefix, dot, last = name.rpartition(".")
        if last == "R" and f"{prefix}{dot}G" in places and f"{prefix}{dot}B" in places:
            found[prefix] = [places[f"{prefix}{dot}{channel}"] for channel in "RGB"]
        elif last == "Y" and f"{prefix}{dot}X" not in places:
            found[prefix] = [places[name]]
    return found


def choose(path: Path, found: dict[str, Any], layer: str | None) -> str:
    """Return which layer to take."""
    listed = ", ".join(sorted(name for name in found if name)) or "none"
    if layer is not None:
        if layer in found:
            return layer
        hint = did_you_mean(layer, list(found), otherwise=f"; it has: {listed}.")
        raise LayerError(f"'{path}' has no layer '{layer}'{hint}")
    combined = [name for name in found if name.split(".")[-1] == COMBINED]
    for names in ([""] if "" in found else [], combined, list(found)):
        if len(names) == 1:
            return names[0]
    if not found:
        raise ScoreError(f"'{path}' has no channels R, G and B, and no Y: there is no picture in it to score.")
    raise ScoreError(f"'{path}' has several layers; choose one with --layer: {listed}.")


def score_pair(path: Path, image: NDArray, reference_path: Path, reference: NDArray) -> tuple[NDArray, NDArray]:
    """Return both pictures (H, W, 3), large enough for every error. Raises ScoreError if they cannot be compared."""
    return comparable(image, reference, (f"'{path}'", f"'{reference_path}'"), SSIM_WINDOW)


def read_reference(path: Path, layer: str | None) -> tuple[NDArray[np.float32], str | None]:
    """Return a reference of pictures of which ``layer`` is scored, as ``read_picture`` does, and the layer taken.

    That is the layer of the same name, or where the reference has none, its own picture (None). Raises ScoreError.
    """
    if layer is not None:
        with suppress(LayerError):
            return read_picture(path, layer), layer
    return read_picture(path), None

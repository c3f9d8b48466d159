"""Read pictures of any renderer as linear sRGB."""

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
"""Name that Blender gives the layer of the finished picture."""


def read_picture(path: Path, layer: str | None = None) -> NDArray[np.float32]:
    """Return the colours (H, W, 3), or (H, W, 1) of a grey picture, in linear sRGB.

    Whole numbers (PNG, JPEG) are taken to be encoded with the sRGB curve, floating-point numbers to be linear.
    ``layer``: the text before ".R" in the names of the channels. None takes the picture outside of any layer, or else
    Blender's layer "Combined", or else the only layer. Raises ScoreError; LayerError if there is no such ``layer``.
    """
    if not path.is_file():
        raise ScoreError(f"There is no picture '{path}'.")
    with opened(path) as source:
        places: dict[str, tuple[int, list[int]]] = {}
        part = 0
        while source.seek_subimage(part, 0):
            for name, channels in layers(list(source.spec().channelnames)).items():
                places.setdefault(name, (part, channels))
            part += 1
        part, channels = places[choose(path, places, layer)]
        source.seek_subimage(part, 0)
        values = read_channels(path, source, channels)
        encoded = str(source.spec().format) not in FLOATING
    require_finite(values, f"'{path}'")
    return decode_srgb(values).astype(np.float32) if encoded else values


def read_values(path: Path) -> NDArray[np.float64]:
    """Return the values of a picture (H, W) as they are in the file, not decoded: the mean of R, G and B.

    Whole numbers are scaled to [0, 1]. Raises ScoreError.
    """
    if not path.is_file():
        raise ScoreError(f"There is no picture '{path}'.")
    with opened(path) as source:
        names = list(source.spec().channelnames)
        colours = [k for k, name in enumerate(names) if name.rpartition(".")[2] in ("R", "G", "B")]
        return read_channels(path, source, colours or [0]).mean(axis=-1, dtype=np.float64)


def read_channels(path: Path, source: Any, channels: list[int]) -> NDArray[np.float32]:
    """Return ``channels`` (H, W, N) of the part of an image file that ``source`` has selected. Raises ScoreError."""
    specification = source.spec()
    values = source.read_image("float")
    if values is None:
        raise ScoreError(f"Cannot read '{path}': {said(source)}.")
    shape = specification.height, specification.width, specification.nchannels
    return np.asarray(values, np.float32).reshape(shape)[..., channels]


FLOATING = ("half", "float", "double")
"""OpenImageIO's names of the floating-point types of channels."""


def layers(names: list[str]) -> dict[str, list[int]]:
    """Return layers by name, "" for channels outside of any: where in ``names`` their R, G, B are, or their Y."""
    places = {name: k for k, name in enumerate(names)}
    channels_of_layer = {}
    for name in names:
        prefix, dot, channel_name = name.rpartition(".")
        if channel_name == "R" and f"{prefix}{dot}G" in places and f"{prefix}{dot}B" in places:
            channels_of_layer[prefix] = [places[f"{prefix}{dot}{channel}"] for channel in "RGB"]
        elif channel_name == "Y" and f"{prefix}{dot}X" not in places:
            channels_of_layer[prefix] = [places[name]]
    return channels_of_layer


def choose(path: Path, layers_found: dict[str, Any], layer: str | None) -> str:
    """Return the name of the layer to take, for ``read_picture``. ``layers_found``: by name. Raises ScoreError."""
    listed = ", ".join(sorted(name for name in layers_found if name)) or "none"
    if layer is not None:
        if layer in layers_found:
            return layer
        hint = did_you_mean(layer, list(layers_found), otherwise=f"; it has: {listed}.")
        raise LayerError(f"'{path}' has no layer '{layer}'{hint}")
    combined = [name for name in layers_found if name.split(".")[-1] == COMBINED]
    for names in ([""] if "" in layers_found else [], combined, list(layers_found)):
        if len(names) == 1:
            return names[0]
    if not layers_found:
        raise ScoreError(f"'{path}' has no channels R, G and B, and no Y: there is no picture in it to score.")
    raise ScoreError(f"'{path}' has several layers; choose one with --layer: {listed}.")


def score_pair(path: Path, image: NDArray, reference_path: Path, reference: NDArray) -> tuple[NDArray, NDArray]:
    """Return image and reference as (H, W, 3). Raises ScoreError if they cannot be compared by every error measure."""
    return comparable(image, reference, (f"'{path}'", f"'{reference_path}'"), SSIM_WINDOW)


def read_reference(path: Path, layer: str | None) -> tuple[NDArray[np.float32], str | None]:
    """Return the reference for pictures whose ``layer`` is scored, as ``read_picture`` does, and the layer it is from.

    That is the layer of the same name or, where the reference has none, the picture that ``read_picture`` takes without
    a layer (None). Raises ScoreError.
    """
    if layer is not None:
        with suppress(LayerError):
            return read_picture(path, layer), layer
    return read_picture(path), None

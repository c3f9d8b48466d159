"""Write the picture of a render: its layers, their names, and the metadata with which it can be made again."""

from __future__ import annotations

from pathlib import Path
from typing import Any, get_args

import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from tracer.core.version import version
from tracer.errors import OutputError, WriteError
from tracer.image.colour import display
from tracer.io.exr import Chosen, layers_of, own_names, write_exr, write_png
from tracer.io.rescue import write_or_rescue
from tracer.result import Result
from tracer.session.keeper import Keeper
from tracer.session.request import PictureFile


def metadata(result: Result, scene_hash: str) -> dict[str, Any]:
    """Return version, scene, settings and outcome as plain values.

    ``spp`` is what was drawn, samples a pixel; ``spp_at_most`` what a noise target or a limit of time could have made
    of it, or what was asked for where there is neither.
    """
    settings = result.report.settings
    return {
        "version": version(),
        "mitsuba": mi.__version__,
        "variant": mi.variant(),
        "scene_hash": scene_hash,
        "spp": result.report.spp,
        "spp_at_most": settings.spp,
        "seed": settings.seed,
        "criterion": settings.criterion,
        "objective": settings.objective,
        "seconds": result.seconds,
        "complete": int(result.report.complete),
        "report": result.report.as_dict(),
        **({"shapes": result.seen.shape_names} if result.seen is not None else {}),
    }


def write_result(path: Path, result: Result, metadata: dict[str, Any], chosen: Chosen = "all") -> None:
    """Write a result as EXR with ``metadata``, or the picture alone, as a screen shows it, as PNG.

    ``chosen``: "all" layers, or "rgb", which is the picture in linear sRGB and nothing else, for programs that read no
    layers. Raises WriteError, which says where the picture is if it could be written in another place.
    """

    def write(place: Path) -> None:
        if path.suffix.lower() == ".png":
            write_png(place, display(result.rgb))
        elif chosen == "rgb":
            write_exr(place, ["R", "G", "B"], result.rgb, metadata, result.window)
        else:
            write_exr(place, *layers(result), metadata, result.window)

    write_or_rescue(path, write)


def write_picture(file: PictureFile, result: Result, scene_hash: str, keeper: Keeper | None) -> None:
    """Write the picture of a request. Raises WriteError, which says where its samples are if ``keeper`` has them."""
    if file.path.suffix.lower() == ".exr" and file.layers == "all" and (renamed := renamed_layers(result)):
        result.report.note(f"Layers of tracer have the names of AOVs, which are written as {', '.join(renamed)}.")
    try:
        origin = {"job": file.origin} if file.origin else {}
        write_result(file.path, result, metadata(result, scene_hash) | origin, file.layers)
    except WriteError as error:
        where_samples_are = keeper.all_is_kept() if keeper is not None else ""
        raise WriteError(f"{error} {where_samples_are}".rstrip()) from None


def chosen_layers(name: str | None) -> Chosen:
    """Return the choice of a person, "all" where there is none. Raises OutputError."""
    if name is not None and name not in get_args(Chosen):
        raise OutputError(f"layers: write all or rgb (was {name!r}).")
    return "rgb" if name == "rgb" else "all"


def layers(result: Result) -> tuple[list[str], NDArray[np.float32]]:
    """Return channel names and values (H, W, N) of the EXR of a result; every name is there once.

    The image under its own names, then ``stderr.`` with the names of the image, ``samples.Y``, ``complexity.Y``,
    ``importance.Y``, ``cost.Y``. Counts are exact up to 2^24, as float32 holds them. If it was denoised, ``noisy.``
    with the names of its colours; if features were asked for, ``albedo.R/G/B``, ``normal.X/Y/Z``, ``depth.Z`` and
    ``shape.Y``. AOVs that would come into these layers are named by ``own_names``.
    """
    after = single_channels(result)
    channels = own_names(result.channels, layers_of(after))
    names = [*channels, *(f"stderr.{name}" for name in channels), *after]
    values = [result.image, result.stderr, *(array[..., None] for array in after.values())]
    return names, np.concatenate([array.astype(np.float32) for array in values], axis=-1)


def single_channels(result: Result) -> dict[str, NDArray]:
    """Return the channels (H, W) of a result beside image and standard error, by name."""
    channels = {f"{name}.Y": getattr(result, name) for name in ("samples", "complexity", "importance", "cost")}
    if result.noisy is not None:
        colours = result.channels[: result.noisy.shape[-1]]
        channels |= {f"noisy.{name}": result.noisy[..., k] for k, name in enumerate(colours)}
    if result.seen is not None:
        features = result.seen.features
        channels |= {f"albedo.{name}": features.albedo[..., k] for k, name in enumerate("RGB")}
        channels |= {f"normal.{name}": features.normal[..., k] for k, name in enumerate("XYZ")}
        channels |= {"depth.Z": features.depth, "shape.Y": result.seen.shapes}
    return channels


def renamed_layers(result: Result) -> list[str]:
    """Return the layers of AOVs that have another name in the EXR of a result than in the scene."""
    written_names = own_names(result.channels, layers_of(single_channels(result)))
    changed_names = (new for new, old in zip(written_names, result.channels, strict=True) if new != old)
    return list(dict.fromkeys(name.rpartition(".")[0] or name for name in changed_names))

"""What a render returns, and the layers of the file that it is written to."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from tracer.core.quantities import mean_count, samples_in_words
from tracer.core.version import version
from tracer.denoising.postprocess import (
    Seen,  # imported at run time too: Dr.Jit looks up the type hints of objects that an integrator holds
)
from tracer.image.colour import as_png, display, heat
from tracer.io.atomic import check_output
from tracer.io.exr import Chosen, check_channels, chosen_layers, layers_of, own_names, write_exr, write_png
from tracer.io.rescue import write_or_rescue
from tracer.report import Report
from tracer.scene.frame import PlainFrame


@dataclass(frozen=True)
class Result:
    """A picture and all that is known about it: what ``tracer.render`` returns. Pixels are (rows H, columns W).

    Example::

        import tracer

        result = tracer.render("scene.xml", spp=64)
        result.rgb.mean(axis=(0, 1))  # the mean colour, linear
        result.samples.max()  # the most samples of a pixel
        abs(result.stderr).max()  # the largest standard error, in the unit of the picture
        print(result.report)  # what was decided, and why
        result.save("scene.exr")
    """

    image: NDArray[np.float32]
    """(H, W, C), linear, channels as ``channels`` names them."""
    samples: NDArray[np.uint32]
    """(H, W): samples of each pixel, without those that were left out because they were not finite."""
    stderr: NDArray[np.float32]
    """(H, W, C): estimated standard error of ``image``."""
    complexity: NDArray[np.float32]
    """(H, W): entropy in bits of the shape IDs that pilot rays hit; zeros if nothing was decided by pilot rays, as
    ``fused`` does not below 23 samples per pixel."""
    importance: NDArray[np.float32]
    """(H, W): importance by which the last round was allocated; zeros if all pixels were to have the same."""
    cost: NDArray[np.float32]
    """(H, W): what a sample costs; 1 is a ray that meets nothing. A sample pays for its own path and waits for the
    longest of the 16 that are traced together, see ``tracer.sampling.work``."""
    noisy: NDArray[np.float32] | None
    """(H, W, 1 or 3): the colours of ``image`` before it was denoised; None if it was not."""
    seen: Seen | None
    """What the camera's rays hit first; None if it was not asked for."""
    channels: list[str]
    """Names of the channels of ``image``."""
    window: tuple[int, int, int, int]
    """x and y of the picture within the film, and width and height of the film."""
    seconds: float
    """Wall-clock seconds from the first pilot ray to the developed image."""
    report: Report
    """What was decided in the render and why, and how long it took."""

    def __repr__(self) -> str:
        """Return size, samples and time: arrays of millions of numbers tell a person nothing."""
        height, width = self.image.shape[:2]
        return f"Result({width} x {height}, {samples_in_words(self.report.spp)}, {self.seconds:.1f} s)"

    @property
    def rgb(self) -> NDArray[np.float32]:
        """(H, W, 3): the colours of ``image`` in linear sRGB, whatever its channels are, without alpha and AOVs."""
        height, width = self.image.shape[:2]
        frame = PlainFrame((height, width), 0, self.channels, 0, self.window)
        return np.asarray(frame.rgb(self.image), np.float32)

    def save(self, path: str | Path, *, layers: Chosen = "all", overwrite: bool = False) -> None:
        """Write the picture to a file, whole or not at all.

        ``path``: its ending chooses the form. ".exr": every layer in linear float32, as ``layers`` of this module names
        them, and the settings and report as attributes ``tracer:...``. ".png": what a screen shows, sRGB in 8 bits.
        ``layers``: "all", or "rgb" for an EXR of the colours alone, for programs that read no layers. ``overwrite``:
        whether a file of that name is replaced. Raises OutputError, before anything is written, for a name that cannot
        be written to, and WriteError for a disk that is full.

        Example::

            import tracer

            result = tracer.render("scene.xml", spp=64)
            result.save("scene.exr")
            result.save("scene.png", overwrite=True)
        """
        target, chosen = check_output(Path(path), overwrite), chosen_layers(layers)
        check_channels(self.channels)
        write_result(target, self, metadata(self), chosen)

    def _repr_html_(self) -> str:
        """Return the picture and its sample counts side by side, as HTML for Jupyter."""
        pictures = "".join(
            f'<figure style="display:inline-block;margin:4px"><img src="data:image/png;base64,{data}">'
            f"<figcaption>{caption}</figcaption></figure>"
            for caption, data in (
                (f"{mean_count(self.report.spp)} spp, {self.seconds:.1f} s", as_png(display(self.rgb))),
                (f"samples per pixel, {self.samples.min()} to {self.samples.max()}", as_png(heat(self.samples))),
            )
        )
        return f"<div>{pictures}</div>"


def metadata(result: Result, scene_hash: str | None = None) -> dict[str, Any]:
    """Return version, scene, settings and outcome as plain values; the hash of the scene if it is known.

    ``spp`` is what was drawn, samples a pixel; ``spp_at_most`` what a noise target or a limit of time could have made
    of it, or what was asked for where there is neither.
    """
    settings = result.report.settings
    return {
        "version": version(),
        "mitsuba": mi.__version__,
        "variant": mi.variant(),
        **({} if scene_hash is None else {"scene_hash": scene_hash}),
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

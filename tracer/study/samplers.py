"""Our sampler beside Mitsuba's: the error of a uniform picture under plain ``mi.render``.

No reference is needed: every sampler gives the same expected picture, so the variance between seeds is the mean squared
error, apart from the bias that a filter's normalisation has at few samples, which all samplers share.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tracer.scene import open_scene
from tracer.source import load
from tracer.study.compare import STOCK_SAMPLERS, Method, interval, stock_method
from tracer.study.record import markdown_table
from tracer.study.run import StepCallback, scene_name
from tracer.study.table import bounds, ratio

OWN = "owen_sobol"
SAMPLERS = (OWN, *STOCK_SAMPLERS)


@dataclass(frozen=True)
class Error:
    """Error of one sampler on one scene at one budget, over seeds."""

    scene: str
    sampler: str
    spp: int
    mse: float
    """Mean over pixels and channels of the variance between seeds."""


def measure(
    scene: Path, width: int, spps: Sequence[int], seeds: int, progress: StepCallback | None = None
) -> list[Error]:
    """Render a scene, ``width`` pixels wide, with every sampler, budget and seed (two seeds at least).

    ``multijitter`` may take a few samples more than asked for; its errors are scaled to the samples it took. Raises
    KeyboardInterrupt if ``progress`` stops it.
    """
    errors: list[Error] = []
    for sampler in SAMPLERS:
        with ExitStack() as stack:
            source = load(scene, sampler=sampler, merge_meshes=True)
            view = stack.enter_context(open_scene(source, size=width))
            method = stock_method(view)
            for spp in spps:
                errors.append(measure_method(scene_name(scene), sampler, method, spp, range(seeds), view.pixel_count))
                done, total = len(errors), len(SAMPLERS) * len(spps)
                if progress and progress(f"{scene_name(scene)}: {sampler}, {spp} spp", done, total) is False:
                    raise KeyboardInterrupt
    return errors


def measure_method(scene: str, sampler: str, method: Method, spp: int, seeds: Sequence[int], pixel_count: int) -> Error:
    """Return the error of one sampler."""
    pictures = [method(spp, seed) for seed in seeds]
    images = np.stack([image for image, _ in pictures]).astype(np.float64)
    used = pictures[0][1] / (spp * pixel_count)
    return Error(scene, sampler, spp, float(images.var(axis=0, ddof=1).mean() * used))


def ratios(errors: Sequence[Error], other: str, spp: int) -> list[float]:
    """Return the error of our sampler over that of ``other``, one entry a scene."""
    found = {(e.scene, e.sampler): e.mse for e in errors if e.spp == spp}
    return [ratio(found[scene, OWN], found[scene, other]) for scene in dict.fromkeys(e.scene for e in errors)]


def markdown(errors: Sequence[Error]) -> str:
    """Return a table of ratios: a line a scene, and the geometric means."""
    columns = [(spp, other) for spp in dict.fromkeys(e.spp for e in errors) for other in STOCK_SAMPLERS]
    found = [ratios(errors, other, spp) for spp, other in columns]
    headings = ["MSE of owen_sobol over that of", *(f"{other}, {spp} spp" for spp, other in columns)]
    scenes = list(dict.fromkeys(e.scene for e in errors))
    lines = [[scene, *(f"{column[k]:.2f}" for column in found)] for k, scene in enumerate(scenes)]
    lines.append(["**geometric mean**", *(f"**{bounds(interval(column))}**" for column in found)])
    return markdown_table(headings, lines)

"""What an oracle knows of a scene: the error of every pixel after several numbers of samples, and what they cost.

Both are measured, with seeds that nothing else uses. The squared error of a pixel's mean after n samples is the
variance of that mean over seeds. For a low-discrepancy sequence it is less than the variance of one sample over n, by a
factor that depends on the pixel. Costs are seconds: squares of pixels are drawn one by one and timed; within a square,
the time is divided among the pixels in proportion to the work of their paths.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Any

import drjit as dr
import filelock
import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from tracer.core.arrays import Singles
from tracer.core.device import upload
from tracer.core.wording import Tell
from tracer.io import atomic
from tracer.sampling import samples
from tracer.sampling.samples import make_sampler
from tracer.scene.view import View
from tracer.study.methods import Setting
from tracer.study.reference import cache_key, prepare_cache
from tracer.study.source_hash import truth_hash
from tracer.study.uniform import render_uniform

FIRST_SEED = 3000017
"""First seed of the measurements, far from the seeds of cells and from those of references."""
SEEDS_OF = {16: 12, 64: 8, 256: 4}
"""Samples per pixel after which the error is measured, each with its number of seeds."""
SQUARE = 32
"""Side in pixels of the squares that are timed."""
TIMED_SPP = 32
"""Samples per pixel with which a square is timed."""
TIMINGS = 3
"""Number of times that a square is drawn; the shortest time counts."""


@dataclass(frozen=True)
class Truth:
    """What was measured of a scene, for the N entries of SEEDS_OF. Arrays leave out the border of the film."""

    counts: NDArray[np.int64]
    """(N,): samples per pixel after which the error was measured."""
    seeds: NDArray[np.int64]
    """(N,): number of seeds with which it was measured."""
    squared_error: Singles
    """(N, H, W): squared error of the mean of a pixel after ``counts`` samples, averaged over colour channels."""
    luminance: Singles
    """(H, W): mean over all samples, linear."""
    cost: Singles
    """(H, W): seconds that a sample of the pixel takes, relative to the mean of all pixels."""


def measure_truth(setting: Setting, view: View, tell: Tell) -> Truth:
    """Return what an oracle knows of a scene; it is measured only if it is not kept from before."""
    sampler = make_sampler()
    folder = prepare_cache() / cache_key(setting)
    folder.mkdir(exist_ok=True)
    path = folder / f"truth {truth_hash()}.npz"
    with filelock.FileLock(folder / "lock"):
        if path.exists():
            with np.load(path) as stored:
                return Truth(**stored)
        drawing = samples.Recorded(view, sampler)
        try:
            truth = Truth(**measure_errors(view, tell), cost=measure_cost(view, drawing, tell)[view.inner])
        finally:
            drawing.close()
        atomic.write_arrays(path, vars(truth))
    return truth


def measure_errors(view: View, tell: Tell) -> dict[str, Any]:
    """Return the fields of ``Truth`` other than the cost, by name."""
    errors, pictures = [], []
    for spp, seeds in SEEDS_OF.items():
        means = []
        for k in range(seeds):
            tell(f"what an oracle knows, {spp} spp, seed {k + 1} of {seeds}")
            statistics = render_uniform(view, spp, FIRST_SEED + 1000 * spp + k)[1]
            means.append(statistics.mean[view.inner])
        stack = np.stack(means).astype(np.float64)
        errors.append(stack[..., : view.colour_channels].var(axis=0, ddof=1).mean(axis=-1))
        pictures.append(stack.mean(axis=0))
    totals = [spp * seeds for spp, seeds in SEEDS_OF.items()]
    return {
        "counts": np.array(list(SEEDS_OF)),
        "seeds": np.array(list(SEEDS_OF.values())),
        "squared_error": np.stack(errors).astype(np.float32),
        "luminance": view.luminance(np.average(pictures, axis=0, weights=totals)).astype(np.float32),
    }


def measure_cost(view: View, drawing: samples.Recorded, tell: Tell) -> Singles:
    """Return the seconds of a sample of each pixel of the film's grid, relative to the mean."""
    work = render_uniform(view, 16, FIRST_SEED)[1].work.astype(np.float64)
    height, width = view.grid
    cost = np.zeros(view.grid)
    overhead = min(seconds_of(view, drawing, np.zeros(64, np.int64), 1) for _ in range(2 * TIMINGS))
    for top in range(0, height, SQUARE):
        tell(f"what an oracle knows, cost of row {top} of {height}")
        for left in range(0, width, SQUARE):
            square = slice(top, top + SQUARE), slice(left, left + SQUARE)
            pixels = np.arange(view.pixel_count).reshape(view.grid)[square].ravel()
            seconds = min(seconds_of(view, drawing, pixels, TIMED_SPP) for _ in range(TIMINGS)) - overhead
            cost[square] = work[square] * max(seconds, 0.0) / work[square].sum()
    cost = np.maximum(cost, 0.02 * cost.mean())
    return (cost / cost.mean()).astype(np.float32)


def seconds_of(view: View, drawing: samples.Recorded, pixels: NDArray[np.int64], spp: int) -> float:
    """Return the seconds in which ``spp`` samples of each of ``pixels``, indices into the film's grid, are drawn."""
    pixel = dr.repeat(upload(mi.UInt32, pixels), spp)
    index = dr.tile(dr.arange(mi.UInt32, spp), len(pixels))
    scale, seed = dr.opaque(mi.Float, spp**-0.5), dr.opaque(mi.UInt32, FIRST_SEED)
    dr.eval(pixel, index)
    dr.sync_thread()
    start = time.perf_counter()
    drawing(seed, pixel, index, scale)
    dr.sync_thread()
    return time.perf_counter() - start

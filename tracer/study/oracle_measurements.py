"""What an oracle knows of a scene: the error of every pixel after several numbers of samples, and what they cost.

Both are measured, with seeds that nothing else uses. The error of a pixel's mean after n samples is its variance over
seeds, which for a low-discrepancy sequence is less than that of one sample over n, by how much depends on the pixel.
Costs are seconds: squares of pixels are drawn one by one and timed, within a square the rays of a path decide.
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
"""Far from the seeds that are measured, and from those of references."""
SEEDS_OF = {16: 12, 64: 8, 256: 4}
"""Samples per pixel at which the error is measured, and with how many seeds."""
SQUARE = 32
"""Side in pixels of the squares that are timed."""
TIMED_SPP = 32
TIMINGS = 3
"""Times that a square is drawn; the shortest counts."""


@dataclass(frozen=True)
class Truth:
    """What was measured. Arrays are of the picture, without the border of the film."""

    counts: NDArray[np.int64]
    """(N,): samples per pixel."""
    seeds: NDArray[np.int64]
    """(N,): seeds for each."""
    squared_error: Singles
    """(N, H, W): squared error of the mean of a pixel after so many samples, averaged over colour channels."""
    luminance: Singles
    """(H, W)."""
    cost: Singles
    """(H, W): seconds a sample takes, relative to the mean."""


def measure_truth(setting: Setting, view: View, told: Tell) -> Truth:
    """Return what an oracle knows of a scene; what is kept from before is not measured again."""
    sampler = make_sampler()
    folder = prepare_cache() / cache_key(setting)
    folder.mkdir(exist_ok=True)
    path = folder / f"truth {truth_hash()}.npz"
    with filelock.FileLock(folder / "lock"):
        if path.exists():
            with np.load(path) as kept:
                return Truth(**kept)
        drawing = samples.Recorded(view, sampler)
        try:
            truth = Truth(**measure_errors(view, told), cost=measure_cost(view, drawing, told)[view.inner])
        finally:
            drawing.close()
        atomic.write_arrays(path, vars(truth))
    return truth


def measure_errors(view: View, told: Tell) -> dict[str, Any]:
    """Return the fields of ``Truth`` but for the cost."""
    errors, pictures = [], []
    for spp, seeds in SEEDS_OF.items():
        means = []
        for k in range(seeds):
            told(f"what an oracle knows, {spp} spp, seed {k + 1} of {seeds}")
            found = render_uniform(view, spp, FIRST_SEED + 1000 * spp + k)[1]
            means.append(found.mean[view.inner])
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


def measure_cost(view: View, drawing: samples.Recorded, told: Tell) -> Singles:
    """Return what a sample of each pixel costs (grid), relative to the mean."""
    rays = render_uniform(view, 16, FIRST_SEED)[1].rays.astype(np.float64)
    height, width = view.grid
    cost = np.zeros(view.grid)
    nothing = min(seconds_of(view, drawing, np.zeros(64, np.int64), 1) for _ in range(2 * TIMINGS))
    for top in range(0, height, SQUARE):
        told(f"what an oracle knows, cost of row {top} of {height}")
        for left in range(0, width, SQUARE):
            square = slice(top, top + SQUARE), slice(left, left + SQUARE)
            pixels = np.arange(view.pixel_count).reshape(view.grid)[square].ravel()
            seconds = min(seconds_of(view, drawing, pixels, TIMED_SPP) for _ in range(TIMINGS)) - nothing
            cost[square] = rays[square] * max(seconds, 0.0) / rays[square].sum()
    cost = np.maximum(cost, 0.02 * cost.mean())
    return (cost / cost.mean()).astype(np.float32)


def seconds_of(view: View, drawing: samples.Recorded, pixels: NDArray[np.int64], spp: int) -> float:
    """Return how long it takes to draw ``spp`` samples of ``pixels``."""
    pixel = dr.repeat(upload(mi.UInt32, pixels), spp)
    index = dr.tile(dr.arange(mi.UInt32, spp), len(pixels))
    scale, seed = dr.opaque(mi.Float, spp**-0.5), dr.opaque(mi.UInt32, FIRST_SEED)
    dr.eval(pixel, index)
    dr.sync_thread()
    start = time.perf_counter()
    drawing(seed, pixel, index, scale)
    dr.sync_thread()
    return time.perf_counter() - start

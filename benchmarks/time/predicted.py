"""Whether the work that is counted predicts the time: adaptive counts against uniform ones, drawn in turn."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from benchmarks.time.ways import open_ways
from tracer.core import stopwatch
from tracer.core.arrays import Counts
from tracer.sampling.passes import PASS_SIZES
from tracer.sampling.samples import Recorded, make_sampler
from tracer.sampling.wavefront import lane_pixels, line_of
from tracer.sampling.work import work_of
from tracer.scene.view import Size, View
from tracer.session.render import begun, complete
from tracer.session.request import Request
from tracer.settings import make_settings

TURNS = 3
"""Number of times that the samples of each allocation are drawn."""
SEED, COUNTS_SEED = 21, 22
"""Seeds of the samples that are timed, and of the picture whose counts are drawn."""


def predicted_rows(scene: str, path: Path, size: Size, spp: int) -> list[dict[str, Any]]:
    """Return one row: seconds of the processor and work of uniform and of adaptive counts, nothing else done."""
    with open_ways(path, size, ()) as (view, _):
        height, width = view.size
        uniform = np.full(view.pixel_count, spp, np.uint32)
        counts = {"uniform": uniform, "fused": adaptive_counts(view, spp)}
        recorded = Recorded(view, make_sampler())
        try:
            work = {name: draw(recorded, count, spp) for name, count in counts.items()}
            seconds: dict[str, list[float]] = {name: [] for name in counts}
            for _ in range(TURNS):
                for name, count in counts.items():
                    start = stopwatch.read()
                    draw(recorded, count, spp)
                    seconds[name].append((stopwatch.read() - start).cpu)
        finally:
            recorded.close()
    numbers = {"scene": scene, "width": width, "height": height, "spp": spp, "samples": int(uniform.sum())}
    return [{**numbers, "work": work, "drawing_seconds": seconds}]


def adaptive_counts(view: View, spp: int) -> Counts:
    """Return the samples of each pixel of the film's grid, row by row, of an adaptive picture."""
    request = Request(view, make_settings(spp=spp, seed=COUNTS_SEED, criterion="fused", guide=False))
    with begun(request, view) as rendering:
        complete(rendering, request)
        return rendering.state.drawn.ravel().copy()


def draw(recorded: Recorded, counts: Counts, spp: int) -> float:
    """Draw samples as a render does, but add them to nothing, and return their work."""
    seed, scale = dr.opaque(mi.UInt32, SEED), dr.opaque(mi.Float, spp**-0.5)
    works = []
    for window in line_of(counts).passes(PASS_SIZES[0]):
        samples = recorded(seed, *lane_pixels(window), scale)
        works.append(dr.sum(mi.Float64(work_of(samples.vertices))))
    dr.sync_thread()
    return float(sum(work[0] for work in works))

"""What is timed: which scenes, sizes, numbers of samples and threads, and what of each picture is kept."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import drjit as dr
import numpy as np

from benchmarks.harness import Announce
from benchmarks.time.ways import Timed, Way, in_turn, open_ways
from tracer.core.stopwatch import NO_TIME, Seconds
from tracer.scene.view import Size

MOST_SAMPLES = 3e8
"""Most samples of a picture that all ways render; beyond that only ours, adaptive, is timed, once."""
TURNS = 3
"""Number of pictures of every way."""


@dataclass(frozen=True)
class Case:
    """What is rendered in all ways."""

    scene: str
    path: Path
    size: Size
    spp: int
    threads: int


@dataclass(frozen=True)
class Row:
    """The times of one way in one case."""

    scene: str
    shapes: int
    width: int
    height: int
    spp: int
    threads: int
    way: str
    wall: list[float]
    """Seconds on the clock, one for each turn."""
    cpu: list[float]
    """Seconds of the processor, one for each turn."""
    parts: dict[str, tuple[float, float]]
    """Median seconds on the clock and of the processor of each part; empty for ``mi.render``."""

    @property
    def key(self) -> tuple[str, int, int, int, int]:
        """What rows of different ways have in common."""
        return self.scene, self.width, self.height, self.spp, self.threads


def measure(cases: Sequence[Case], announce: Announce) -> Iterator[Row]:
    """Yield the rows of all cases; the scene is opened anew when it or its size changes."""
    for case in cases:
        announce(f"{case.scene}, {case.size}, {case.spp} spp, {case.threads} threads")
        with limited_threads(case.threads), open_ways(case.path, case.size) as (view, ways):
            height, width = view.size
            whole = width * height * case.spp <= MOST_SAMPLES
            chosen: dict[str, Way] = ways if whole else {"fused": ways["fused"]}
            shapes = len(view.scene.shapes())
            for name, times in in_turn(chosen, case.spp, TURNS if whole else 1).items():
                walls, cpus = [time.whole.wall for time in times], [time.whole.cpu for time in times]
                yield Row(case.scene, shapes, width, height, case.spp, case.threads, name, walls, cpus, parts_of(times))


def parts_of(times: Sequence[Timed]) -> dict[str, tuple[float, float]]:
    """Return the medians of each part; ``seconds_rest`` is what no part counts."""
    names = sorted({name for time in times for name in time.parts})
    if not names:
        return {}
    parts = {name: medians([time.parts.get(name, NO_TIME) for time in times]) for name in names}
    rest = medians([time.whole - sum(time.parts.values(), NO_TIME) for time in times])
    return {**parts, "seconds_rest": rest}


def medians(seconds: Sequence[Seconds]) -> tuple[float, float]:
    """Return the medians of seconds on the clock and of the processor."""
    return float(np.median([part.wall for part in seconds])), float(np.median([part.cpu for part in seconds]))


@contextmanager
def limited_threads(count: int) -> Iterator[None]:
    """Render with ``count`` threads within the block."""
    own_count = dr.thread_count()
    dr.set_thread_count(count)
    try:
        yield
    finally:
        dr.sync_thread()
        dr.set_thread_count(own_count)

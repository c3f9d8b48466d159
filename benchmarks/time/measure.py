"""What is timed: which scenes, sizes, numbers of samples and threads, and what of each picture is kept."""

from __future__ import annotations

import resource
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import drjit as dr
import numpy as np

from benchmarks.time.ways import CRITERIA, SAMPLERS, Timed, Way, in_turn, open_ways, timed
from tracer.core.stopwatch import NO_TIME, Seconds
from tracer.scene.view import Size

MOST_SAMPLES = 2e7
"""Most samples of a picture that all ways render in turn; beyond that only ours, adaptive, is timed, once."""
ALL_WAYS = (*SAMPLERS, *CRITERIA)
WARM_SPP = 4
"""Samples per pixel of the picture that is rendered before that one, so that all kernels are compiled."""
TURNS, MOST_SECONDS = 3, 60.0
"""TURNS: number of pictures of every way; with fewer, no turn begins after MOST_SECONDS."""


@dataclass(frozen=True)
class Case:
    """What is rendered in all ways."""

    scene: str
    path: Path
    size: Size
    spp: int
    threads: int
    ways: tuple[str, ...] = ALL_WAYS

    def __str__(self) -> str:
        size = f"{self.size[0]} x {self.size[1]}" if isinstance(self.size, tuple) else self.size
        return f"{self.scene}, {size}, {self.spp} spp, {self.threads} threads"


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
    memory: float
    """Bytes of memory that the program has taken at most so far."""
    parts: dict[str, tuple[float, float]]
    """Median seconds on the clock and of the processor of each part; empty for ``mi.render``."""

    @property
    def key(self) -> tuple[str, int, int, int]:
        """What pictures have in common that are rendered in different ways, or with other numbers of threads."""
        return self.scene, self.width, self.height, self.spp


def measure(case: Case) -> list[Row]:
    """Return the rows of a case, one for each way."""
    rows = []
    with limited_threads(case.threads), open_ways(case.path, case.size, case.ways) as (view, ways):
        height, width = view.size
        is_large = width * height * case.spp > MOST_SAMPLES
        shapes = len(view.scene.shapes())
        timings = once(ways["fused"], case.spp) if is_large else in_turn(ways, case.spp, TURNS, MOST_SECONDS)
        for name, times in timings.items():
            walls, cpus = [time.whole.wall for time in times], [time.whole.cpu for time in times]
            setting = case.scene, shapes, width, height, case.spp, case.threads
            rows.append(Row(*setting, name, walls, cpus, most_resident(), parts_of(times)))
    return rows


def once(way: Way, spp: int) -> dict[str, list[Timed]]:
    """Return the time of one adaptive picture, after a smaller number of samples that is not counted."""
    way(WARM_SPP, 0)
    return {"fused": [timed(way, spp, 1)]}


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


def most_resident() -> float:
    """Return the most bytes of memory that this process has had so far, on Linux."""
    return 1024.0 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss

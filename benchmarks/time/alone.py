"""How long one thread works alone while a picture is made: the seconds in which nothing runs that cores share."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from unittest import mock

import drjit as dr

from benchmarks.time.ways import Way, open_ways
from tracer.core import parallel
from tracer.sampling import passes
from tracer.scene.view import Size

WARM_SPP = 16
"""Samples per pixel of the picture that is rendered before, enough to decide, so that all kernels are compiled."""


@dataclass
class Shared:
    """Seconds on the clock in which all threads have worked on one thing."""

    kernels: float = 0.0
    """Seconds in which kernels ran."""
    arrays: float = 0.0
    """Seconds of work on NumPy arrays by ``tracer.core.parallel``."""


def alone_rows(scene: str, path: Path, size: Size, spp: int) -> list[dict[str, Any]]:
    """Return one row with the seconds of an adaptive picture, and those of them that threads have shared."""
    with open_ways(path, size, ("fused",)) as (view, ways):
        height, width = view.size
        seconds, shared = seconds_shared(ways["fused"], spp)
    numbers = {"scene": scene, "width": width, "height": height, "spp": spp, "threads": dr.thread_count()}
    return [{**numbers, "seconds": seconds, "shared": shared}]


def seconds_shared(way: Way, spp: int) -> tuple[float, float]:
    """Return (seconds on the clock of a picture, seconds of them that threads have shared), once all is compiled."""
    with passes_of_many_cores():
        way(WARM_SPP, 0)
        with counted() as shared:
            start = time.perf_counter()
            way(spp, 1)
            seconds = time.perf_counter() - start
    return seconds, shared.kernels + shared.arrays


@contextmanager
def passes_of_many_cores() -> Iterator[None]:
    """Draw in passes as large as they are where many cores draw."""
    with mock.patch.object(passes, "PASS_SECONDS", float("inf")):
        yield


@contextmanager
def counted() -> Iterator[Shared]:
    """Count within the block, and yield what is complete when the block ends. Every kernel is waited for."""
    shared, fill = Shared(), parallel.fill

    def counted_fill(*arguments: Any) -> Any:
        start = time.perf_counter()
        try:
            return fill(*arguments)
        finally:
            shared.arrays += time.perf_counter() - start

    with dr.scoped_set_flag(dr.JitFlag.KernelHistory, True), mock.patch.object(parallel, "fill", counted_fill):
        dr.kernel_history_clear()
        yield shared
        dr.sync_thread()
        shared.kernels = sum(kernel.get("execution_time", 0.0) for kernel in dr.kernel_history()) / 1000

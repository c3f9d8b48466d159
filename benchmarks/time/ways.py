"""The ways to render that are timed: plain ``mi.render`` with three samplers, and ours, uniform and adaptive."""

from __future__ import annotations

import gc
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path

from tracer.core import stopwatch
from tracer.core.stopwatch import Seconds
from tracer.scene.view import Size, View
from tracer.session.render import begun, complete
from tracer.session.request import Request
from tracer.settings import make_settings
from tracer.study.methods import Setting, Studio

SAMPLERS = ("multijitter", "independent", "owen_sobol")
"""Samplers of plain ``mi.render``."""
CRITERIA = ("uniform", "fused")
"""Criteria of ours."""
Parts = Mapping[str, Seconds]
"""What each part of a render took, by the name of its field in the report."""
Way = Callable[[int, int], Parts]
"""Function of (spp, seed) that renders a picture; plain ``mi.render`` does not tell its parts."""


@dataclass(frozen=True)
class Timed:
    """How long a picture took, in all and by part."""

    whole: Seconds
    parts: Parts


@contextmanager
def open_ways(
    path: Path, size: Size, names: Sequence[str] = (*SAMPLERS, *CRITERIA)
) -> Iterator[tuple[View, dict[str, Way]]]:
    """Open a scene once for all ways with these names. Raises SceneError if it cannot be."""
    with ExitStack() as stack:
        studio = Studio(stack, Setting(path, size=size), [name for name in names if name in SAMPLERS])
        yield (
            studio.view,
            {name: (stock_way(studio, name) if name in SAMPLERS else own_way(studio.view, name)) for name in names},
        )


def stock_way(studio: Studio, sampler: str) -> Way:
    """Return the way of ``mi.render`` with a sampler."""
    method = studio.stock(sampler)

    def render(spp: int, seed: int) -> Parts:
        method(spp, seed)
        return {}

    return render


def own_way(view: View, criterion: str) -> Way:
    """Return our way with a criterion."""

    def render(spp: int, seed: int) -> Parts:
        request = Request(view, make_settings(spp=spp, seed=seed, criterion=criterion, guide=False))
        with begun(request, view) as rendering:
            complete(rendering, request)
            return rendering.recorder.taken

    return render


def timed(way: Way, spp: int, seed: int) -> Timed:
    """Return how long a picture takes."""
    gc.collect()  # what an earlier picture has left is not this one's business
    start = stopwatch.read()
    parts = way(spp, seed)
    return Timed(stopwatch.read() - start, parts)


def in_turn(ways: Mapping[str, Way], spp: int, turns: int, most_seconds: float) -> dict[str, list[Timed]]:
    """Return the times of all ways, one after the other in each turn, after one that is not counted.

    There are ``turns`` turns, or fewer if these have taken more than ``most_seconds``.
    """
    for way in ways.values():
        way(spp, 0)
    times: dict[str, list[Timed]] = {name: [] for name in ways}
    start = stopwatch.read()
    for turn in range(turns):
        for name, way in ways.items():
            times[name].append(timed(way, spp, 1 + turn))
        if (stopwatch.read() - start).wall > most_seconds:
            break
    return times

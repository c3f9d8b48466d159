"""What a worker does: draw a unit. These functions run on workers, called by Dask."""

from __future__ import annotations

import time
from typing import Any, TypedDict

import drjit as dr
import numpy as np
from distributed import get_worker

from tracer.cluster.sums import TRASH, Sums
from tracer.cluster.worker_scene import DEVICE, Place, open_worker_scene, place_of
from tracer.cluster.worker_setup import RoundSettings, Setup, require_same, software
from tracer.sampling.wavefront import Line, Stretch
from tracer.session.local_drawer import Pass
from tracer.session.memory import SMALLEST_PASS


class UnitReport(TypedDict):
    """What a unit took."""

    samples: int
    opening: float
    """Seconds for a scene that was not open yet."""
    drawing: float
    seconds: float
    """In all."""
    worker: str


def draw_unit(
    before: dict[str, Any] | None,
    skip: int,
    first_pixel: int,
    size: int,
    stretches: list[Stretch],
    *,
    setup: Setup,
    settings: RoundSettings,
) -> dict[str, Any]:
    """Draw what ``size`` pixels from ``first_pixel`` lack of one or several rounds, and add it to the sums there are.

    ``before``: what an earlier unit returned for these pixels and others, ``skip`` pixels before them; None: there are
    no sums yet. ``stretches``: of each round, these pixels and those that share packets with them.

    Returns ``sums`` (Sums), ``statistics`` (Statistics of a grid of one row) and ``report`` (UnitReport). Raises
    ClusterError if this worker is not made of the same as the client.
    """
    worker = get_worker()
    require_same(software(), settings.made_of, worker.address)
    place = place_of(worker)
    pixels = first_pixel, size
    return DEVICE.submit(
        draw_on_device, worker.address, setup, place, settings, before, skip, pixels, stretches
    ).result()


def draw_on_device(
    address: str,
    setup: Setup,
    place: Place,
    settings: RoundSettings,
    before: dict[str, Any] | None,
    skip: int,
    pixels: tuple[int, int],
    stretches: list[Stretch],
) -> dict[str, Any]:
    """Do the work of ``draw_unit``; ``place``: folder and threads of the worker, ``pixels``: the first, how many."""
    start = time.perf_counter()
    TRASH.clear()
    scene = open_worker_scene(setup, *place)
    opening = time.perf_counter() - start
    drawer = scene.drawer(settings.criterion)
    drawer.largest_pass = settings.largest_pass
    with dr.suspend_grad():
        first, size = pixels
        strip = scene.strip(size, drawer.kinds)
        if before is not None:
            before["sums"].fill(strip, skip)
        passes: list[Pass] = []
        for stretch in stretches:
            drawn = stretch.after.copy()  # of its neighbours nothing is to be drawn
            drawn[first - stretch.first_pixel :][:size] = strip.drawn().ravel()
            line = Line(stretch, drawn, first)
            passes += drawer.draw_line(strip, line, settings.seed, settings.scale, first)
        statistics = strip.statistics()
        dr.sync_thread()
    report = UnitReport(
        samples=sum(one.samples for one in passes),
        opening=opening,
        drawing=sum(one.seconds_drawing for one in passes),
        seconds=time.perf_counter() - start,
        worker=address,
    )
    return {"sums": Sums(strip), "statistics": statistics, "report": report}


def reported(drawn: dict[str, Any]) -> tuple[Any, UnitReport]:
    """Return what the client hears of a unit: statistics, and what it took."""
    return drawn["statistics"], drawn["report"]


def prepare(setup: Setup) -> None:
    """Open the scene, and compile what units need, before the first does. Raises whatever that raises."""
    worker = get_worker()
    place = place_of(worker)
    settings = RoundSettings(software(), None, SMALLEST_PASS, 0, 1.0)
    one = np.ones(1, np.uint32)

    def compile_all() -> None:
        drawn = draw_on_device(worker.address, setup, place, settings, None, 0, (0, 1), [Stretch(0, 0 * one, one)])
        draw_on_device(worker.address, setup, place, settings, drawn, 0, (0, 1), [Stretch(0, one, 2 * one)])

    DEVICE.submit(compile_all).result()

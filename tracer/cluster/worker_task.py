"""What a worker does: it draws a unit. Dask calls these functions on workers."""

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
    """How many samples a unit had, and how long it took."""

    samples: int
    """Number of samples that were drawn."""
    opening: float
    """Seconds of opening the scene, if it was not open yet."""
    drawing: float
    """Seconds of drawing the samples."""
    seconds: float
    """Seconds in all."""
    worker: str
    """Address of the worker."""


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
    """Draw the samples that ``size`` pixels from ``first_pixel`` on lack of one or more rounds, and add them to sums.

    ``before``: what an earlier unit returned for these pixels and perhaps others, of which ``skip`` come before them;
    None: there are no sums yet. ``stretches``: for each round, these pixels and the pixels that share packets with
    them.

    Returns ``sums`` (Sums), ``statistics`` (Statistics of a grid of one row) and ``report`` (UnitReport). Raises
    ClusterError if this worker does not have the software of the client.
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
    """Do the work of ``draw_unit`` in the thread DEVICE.

    ``place``: local folder and threads of the worker; ``pixels``: number of the first pixel, and how many there are.
    """
    start = time.perf_counter()
    TRASH.clear()
    scene = open_worker_scene(setup, *place)
    opening = time.perf_counter() - start
    scene.guide(settings.guided, settings.guide)
    drawer = scene.drawer(settings.criterion)
    drawer.largest_pass = settings.largest_pass
    with dr.suspend_grad():
        first, size = pixels
        strip = scene.strip(size, drawer.kinds)
        if before is not None:
            before["sums"].fill(strip, skip)
        passes: list[Pass] = []
        for stretch in stretches:
            drawn = stretch.after.copy()  # as if neighbouring pixels had all samples: none of theirs is to be added
            drawn[first - stretch.first_pixel :][:size] = strip.drawn().ravel()
            line = Line(stretch, drawn, first)
            passes += drawer.draw_line(strip, line, settings.seed, settings.scale, first)
        statistics = strip.statistics()
        dr.sync_thread()
    report = UnitReport(
        samples=sum(drawn_pass.samples for drawn_pass in passes),
        opening=opening,
        drawing=sum(drawn_pass.drawing.wall for drawn_pass in passes),
        seconds=time.perf_counter() - start,
        worker=address,
    )
    return {"sums": Sums(strip), "statistics": statistics, "report": report}


def reported(drawn: dict[str, Any]) -> tuple[Any, UnitReport]:
    """Return what the client receives of a unit that is drawn: its statistics, and its report."""
    return drawn["statistics"], drawn["report"]


def prepare(setup: Setup) -> None:
    """Open the scene and compile the kernels that units need, before the first unit comes.

    Raises the errors of ``WorkerScene`` and of drawing.
    """
    worker = get_worker()
    place = place_of(worker)
    settings = RoundSettings(software(), None, SMALLEST_PASS, 0, 1.0)
    counts = np.ones(1, np.uint32)

    def compile_all() -> None:
        drawn = draw_on_device(
            worker.address, setup, place, settings, None, 0, (0, 1), [Stretch(0, 0 * counts, counts)]
        )
        draw_on_device(worker.address, setup, place, settings, drawn, 0, (0, 1), [Stretch(0, counts, 2 * counts)])

    DEVICE.submit(compile_all).result()

"""What is compared: our loop with a criterion or plain ``mi.render`` with a sampler, as functions of spp and seed."""

from __future__ import annotations

import gc
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, replace
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from tracer.core.arrays import Singles
from tracer.progress import ProgressCallback
from tracer.scene.load import load
from tracer.scene.view import Size, open_scene, pick_sensor, resize_film
from tracer.session.render import render_request
from tracer.session.request import Request
from tracer.settings import make_settings


@dataclass(frozen=True)
class Shot:
    """One picture and what it took."""

    image: Singles
    """(H, W, 3), linear sRGB."""
    counts: Singles
    """(H, W): samples per pixel."""
    samples: int
    """Radiance samples in all, those of the film's border included."""
    seconds: float
    seconds_drawing: float
    """Of these, drawing radiance samples: all of them, for ``mi.render``."""


Foretold = Callable[[int], NDArray[np.float64]]
"""From samples per pixel of a uniform picture to the samples (H, W) that each pixel is to have instead."""

Method = Callable[[int, int], Shot]
"""Function of (spp, seed). Raises KeyboardInterrupt if it was stopped."""


@dataclass(frozen=True)
class Setting:
    """What a scene is rendered with, whatever the method."""

    source: Any
    """Path of a scene file, or a dictionary."""
    sensor: int = 0
    integrator: str | None = None
    size: Size = None


class Studio:
    """One scene, open for all methods.

    They share shapes, emitters and integrator: every copy of a scene that is loaded slows down all others, as Dr.Jit
    calls a method of any shape through a table of all shapes there are. A sampler belongs to a sensor, so each sampler
    has a sensor of its own, taken from a copy that is let go.
    """

    def __init__(self, stack: ExitStack, setting: Setting, samplers: Iterable[str] = ()) -> None:
        """Open ``setting`` until ``stack`` closes. Raises SceneError or SettingsError."""
        sensors = {sampler: borrow_sensor(setting, sampler) for sampler in samplers}
        gc.collect()  # the copies, which hold on to one another
        self.view = stack.enter_context(open_scene(setting.source, setting.sensor, setting.integrator, setting.size))
        self.views = {sampler: replace(self.view, sensor=sensor) for sampler, sensor in sensors.items()}

    def own(
        self,
        progress: ProgressCallback | None = None,
        foretold: Foretold | None = None,
        denoise: bool = False,
        **settings: Any,
    ) -> Method:
        """Return a rendering by our loop with these ``settings``, of an allocation that is ``foretold`` if it is."""
        view = self.view

        def render(spp: int, seed: int) -> Shot:
            chosen = None if foretold is None else foretold(spp)
            spp = spp if chosen is None else max(1, round(float(chosen.mean())))
            start = time.perf_counter()
            whole = make_settings(spp=spp, seed=seed, **settings)
            result = render_request(Request(view, whole, importance=chosen, denoise=denoise, progress=progress))
            seconds = time.perf_counter() - start
            if not result.report.complete:
                raise KeyboardInterrupt
            samples = sum(one.samples for one in result.report.rounds)
            counts = result.samples.astype(np.float32)
            return Shot(view.rgb(result.image), counts, samples, seconds, result.report.seconds_drawing)

        return render

    def stock(self, sampler: str | None) -> Method:
        """Return a rendering by ``mi.render`` with one of the samplers given, or with the scene's own."""
        view = self.view if sampler is None else self.views[sampler]
        inside, film = view.sensor.sampler(), view.sensor.film()

        def render(spp: int, seed: int) -> Shot:
            start = time.perf_counter()
            with dr.suspend_grad(), quiet():
                image = np.array(view.integrator.render(view.scene, sensor=view.sensor, seed=seed, spp=spp))
            seconds = time.perf_counter() - start
            used = inside.sample_count()
            # Mitsuba leaves the sampler's last state scheduled: the next evaluation, in another method's time, would
            # trace the whole picture again to know it. With a new state it is forgotten.
            inside.seed(0, 1)
            # And the film keeps its sums, four numbers a pixel: a recording takes that for the width of a pass of four
            # samples a pixel, and would be made once more for the next pass.
            film.clear()
            counts = np.full(view.size, used, np.float32)
            return Shot(view.rgb(image), counts, used * view.pixel_count, seconds, seconds)

        return render


def borrow_sensor(setting: Setting, sampler: str) -> Any:
    """Return a sensor like that of ``setting`` with another sampler. Raises SceneError if there is none to replace, or
    SettingsError if there is no such sensor.
    """
    sensor = pick_sensor(load(setting.source, sampler=sampler), setting.sensor, setting.source)
    resize_film(sensor, setting.size)
    return sensor


@contextmanager
def quiet() -> Iterator[None]:
    """Keep Mitsuba from saying that a sampler rounds the number of samples: what it takes is counted."""
    before = mi.log_level()
    mi.set_log_level(mi.LogLevel.Error)
    try:
        yield
    finally:
        mi.set_log_level(before)

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
from tracer.denoising.oidn import load as load_denoiser
from tracer.progress import ProgressCallback
from tracer.scene.load import load
from tracer.scene.view import Size, View, open_scene, pick_sensor, resize_film
from tracer.session.render import render_request
from tracer.session.request import Request
from tracer.settings import make_settings


@dataclass(frozen=True)
class TimedPicture:
    """One picture, with the samples and seconds that it took."""

    image: Singles
    """(H, W, 3), linear sRGB."""
    counts: Singles
    """(H, W): samples per pixel."""
    samples: int
    """Number of radiance samples, those of the film's border included."""
    seconds: float
    """Seconds that the whole picture took."""
    seconds_drawing: float
    """The part of ``seconds`` in which radiance samples were drawn; for ``mi.render``, all but denoising."""


Foretold = Callable[[int], NDArray[np.float64]]
"""Function from the samples per pixel of a uniform picture to the allocation (H, W) that takes their place."""

Method = Callable[[int, int], TimedPicture]
"""Function of (spp, seed) that renders a picture. Raises KeyboardInterrupt if it was stopped."""


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

    The methods share its shapes, emitters and integrator: every further copy of a scene in memory slows down all
    others, as Dr.Jit calls a method of any shape through a table of all shapes that exist. A sampler belongs to a
    sensor, so each sampler has a sensor of its own, taken from a copy of the scene that is then released.
    """

    def __init__(self, stack: ExitStack, setting: Setting, samplers: Iterable[str] = ()) -> None:
        """Open ``setting`` until ``stack`` closes, for the plugins ``samplers``. Raises SceneError or SettingsError."""
        sensors = {sampler: borrow_sensor(setting, sampler) for sampler in samplers}
        gc.collect()  # releases the copies, whose objects refer to one another
        self.view = stack.enter_context(open_scene(setting.source, setting.sensor, setting.integrator, setting.size))
        self.views = {sampler: replace(self.view, sensor=sensor) for sampler, sensor in sensors.items()}

    def own(
        self,
        progress: ProgressCallback | None = None,
        foretold: Foretold | None = None,
        denoise: bool = False,
        **settings: Any,
    ) -> Method:
        """Return the method that renders by our loop with ``settings``, on the allocation of ``foretold`` if given."""
        view = self.view

        def render(spp: int, seed: int) -> TimedPicture:
            allocation = None if foretold is None else foretold(spp)
            spp = spp if allocation is None else max(1, round(float(allocation.mean())))
            start = time.perf_counter()
            all_settings = make_settings(spp=spp, seed=seed, **settings)
            result = render_request(
                Request(view, all_settings, importance=allocation, denoise=denoise, progress=progress)
            )
            seconds = time.perf_counter() - start
            if not result.report.complete:
                raise KeyboardInterrupt
            samples = sum(finished.samples for finished in result.report.rounds)
            counts = result.samples.astype(np.float32)
            return TimedPicture(view.rgb(result.image), counts, samples, seconds, result.report.seconds_drawing)

        return render

    def stock(self, sampler: str | None, denoise: bool = False) -> Method:
        """Return the method that renders by ``mi.render``, with the scene's own sampler if ``sampler`` is None.

        ``denoise``: whether Open Image Denoise takes out the noise, with albedo and normal as ``aov`` gives them.
        Raises DenoiseError if it is not installed.
        """
        view = self.view if sampler is None else self.views[sampler]
        sensor_sampler, film = view.sensor.sampler(), view.sensor.film()
        denoiser = StockDenoiser(view) if denoise else None

        def render(spp: int, seed: int) -> TimedPicture:
            start = time.perf_counter()
            with dr.suspend_grad(), quiet():
                image = view.rgb(np.array(view.integrator.render(view.scene, sensor=view.sensor, seed=seed, spp=spp)))
                drawing, used_spp = time.perf_counter() - start, sensor_sampler.sample_count()
                if denoiser is not None:
                    image = denoiser.denoise(image, seed, spp)
            seconds = time.perf_counter() - start
            # Mitsuba leaves the sampler's last state scheduled: the next evaluation, in another method's time, would
            # trace the whole picture again to compute that state. Seeding replaces it.
            sensor_sampler.seed(0, 1)
            # The film keeps its sums, some numbers per pixel: a recording would take them for the width of a pass of
            # four samples per pixel, and would be made once more for the next pass.
            film.clear()
            counts = np.full(view.size, used_spp, np.float32)
            return TimedPicture(image, counts, used_spp * view.pixel_count, seconds, drawing)

        return render


class StockDenoiser:
    """Takes the noise out of pictures of ``mi.render`` as a script would do it, with Mitsuba's own plugins."""

    MOST_SPP = 16
    """Most samples per pixel of albedo and normal: they are nearly free of noise then. With as many as the picture has,
    in one pass with it, rendering takes two to three times as long."""

    def __init__(self, view: View) -> None:
        """Raises DenoiseError if there is no denoiser."""
        self.view, self.oidn = view, load_denoiser()
        self.device = self.oidn.Device(self.oidn.DeviceType.CPU)  # as ours
        self.features = mi.load_dict({"type": "aov", "aovs": "albedo:albedo,normal:sh_normal"})

    def denoise(self, image: Singles, seed: int, spp: int) -> Singles:
        """Return a picture (H, W, 3) without noise. The package's own function keeps device and filter in between."""
        view, spp = self.view, min(spp, self.MOST_SPP)
        features = np.array(self.features.render(view.scene, sensor=view.sensor, seed=seed, spp=spp))[..., -6:]
        albedo, normal = (np.ascontiguousarray(part) for part in (features[..., :3], features[..., 3:]))
        colour = np.ascontiguousarray(image, np.float32)
        return np.asarray(self.oidn.denoise(colour, albedo, normal, hdr=True, device=self.device), np.float32)


def borrow_sensor(setting: Setting, sampler: str) -> Any:
    """Return a sensor like that of ``setting`` with another sampler.

    Raises SceneError if the scene has no sampler to replace, or SettingsError if it has no such sensor.
    """
    sensor = pick_sensor(load(setting.source, sampler=sampler), setting.sensor, setting.source)
    resize_film(sensor, setting.size)
    return sensor


@contextmanager
def quiet() -> Iterator[None]:
    """Keep Mitsuba from warning that a sampler rounds the number of samples: those that it takes are counted."""
    previous_level = mi.log_level()
    mi.set_log_level(mi.LogLevel.Error)
    try:
        yield
    finally:
        mi.set_log_level(previous_level)

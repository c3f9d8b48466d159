"""Methods side by side: error and seconds of each against a reference, over seeds."""

from __future__ import annotations

import itertools
import time
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from typing import Any

import drjit as dr
import numpy as np
from numpy.typing import NDArray
from scipy import stats

from tracer import score
from tracer.loop import render_view
from tracer.scene import Size, View, open_scene
from tracer.settings import make_settings
from tracer.source import load

Method = Callable[[int, int], tuple[NDArray[np.float32], int]]
"""Function of (spp, seed) that returns the image and how many radiance samples it took."""

BASELINE = "uniform"
"""Every pixel the same, with our sampler and estimator."""
STOCK_SAMPLERS = ("independent", "multijitter")
"""Samplers of Mitsuba that plain ``mi.render`` is measured with."""


@dataclass(frozen=True)
class Measurement:
    """One picture measured."""

    scene: str
    method: str
    spp: int
    seed: int
    mse: float
    relative_mse: float
    psnr: float
    ssim: float
    samples: int
    """Radiance samples used."""
    seconds: float


@dataclass(frozen=True)
class Interval:
    """A mean over seeds and its 95 % interval."""

    mean: float
    low: float
    high: float


def measure(
    source: Any,
    name: str,
    reference: NDArray[np.float32],
    spps: Sequence[int],
    seeds: Sequence[int],
    criteria: Sequence[str],
    *,
    integrator: str | None = None,
    sensor: int = 0,
    size: Size = None,
    objective: str = "relative",
    done: Callable[[Measurement, NDArray[np.float32]], bool | None] | None = None,
) -> list[Measurement]:
    """Render every method at every budget and seed and score it against ``reference``.

    The methods: uniform with our sampler, ``mi.render`` with each of STOCK_SAMPLERS, and each of ``criteria``. They
    take turns within a seed, so that a machine that changes speed does so for all of them; a first small render of
    each, not counted, compiles the kernels. ``done`` is told of every picture; return False to stop.
    """
    measurements: list[Measurement] = []
    with ExitStack() as stack:
        methods = open_methods(stack, source, criteria, integrator, sensor, size, objective)
        for method in methods.values():
            method(4, 0)
        for spp, seed in itertools.product(spps, seeds):
            for method_name, method in methods.items():
                start = time.perf_counter()
                image, samples = method(spp, seed)
                seconds = time.perf_counter() - start
                one = judge(name, method_name, spp, seed, image, reference, samples, seconds)
                measurements.append(one)
                if done is not None and done(one, image) is False:
                    raise KeyboardInterrupt
    return measurements


def open_methods(
    stack: ExitStack,
    source: Any,
    criteria: Sequence[str],
    integrator: str | None,
    sensor: int,
    size: Size,
    objective: str,
) -> dict[str, Method]:
    """Return the methods by name; the scenes they hold open are closed with ``stack``."""
    view = stack.enter_context(open_scene(source, sensor, integrator, size))
    methods = {name: own_method(view, name, objective) for name in dict.fromkeys([BASELINE, *criteria])}
    for sampler in STOCK_SAMPLERS:
        stock = load(source, sampler=sampler, merge_meshes=True)
        methods[sampler] = stock_method(stack.enter_context(open_scene(stock, sensor, integrator, size)))
    return methods


def own_method(view: View, criterion: str, objective: str) -> Method:
    """Render with one of our criteria."""

    def run(spp: int, seed: int) -> tuple[NDArray[np.float32], int]:
        result = render_view(view, make_settings(spp=spp, seed=seed, criterion=criterion, objective=objective))
        return result.image[..., : view.colour_channels], sum(one.samples for one in result.report.rounds)

    return run


def stock_method(view: View) -> Method:
    """Render as ``mi.render`` does, with the sampler that the scene has."""

    def run(spp: int, seed: int) -> tuple[NDArray[np.float32], int]:
        sampler = view.sensor.sampler()
        with dr.suspend_grad():
            image = np.array(view.integrator.render(view.scene, sensor=view.sensor, seed=seed, spp=spp))
        used = sampler.sample_count() * view.pixel_count
        # Mitsuba leaves the sampler's last state scheduled: the next evaluation, in another method's time, would trace
        # the whole picture again to know it. With a new state it is forgotten.
        sampler.seed(0, 1)
        return image[..., : view.colour_channels], used

    return run


def judge(
    scene: str,
    method: str,
    spp: int,
    seed: int,
    image: NDArray[np.float32],
    reference: NDArray[np.float32],
    samples: int,
    seconds: float,
) -> Measurement:
    """Score the colour channels ``image`` (H, W, 1 or 3); ``reference`` may have alpha and AOVs after them."""
    picture, truth = image, reference[..., : image.shape[-1]]
    return Measurement(
        scene,
        method,
        spp,
        seed,
        score.mse(picture, truth),
        score.relative_mse(picture, truth),
        score.psnr(picture, truth),
        score.ssim(picture, truth),
        samples,
        seconds,
    )


def interval(values: Sequence[float]) -> Interval:
    """Return the geometric mean of positive values and its 95 % interval (Student's t on the logarithms)."""
    logarithms = np.log(np.asarray(values, np.float64))
    mean = float(logarithms.mean())
    if len(logarithms) < 2:
        return Interval(float(np.exp(mean)), float("nan"), float("nan"))
    half = float(stats.t.ppf(0.975, len(logarithms) - 1) * logarithms.std(ddof=1) / np.sqrt(len(logarithms)))
    return Interval(*(float(np.exp(x)) for x in (mean, mean - half, mean + half)))

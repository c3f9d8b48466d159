"""Noise targets: the error that is predicted when a render stops against the true one, and the samples it took."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks import harness
from benchmarks.harness import Announce
from tracer.image import objective
from tracer.scene.view import View, open_scene
from tracer.session.render import render_request
from tracer.session.request import Request
from tracer.settings import Settings, make_settings
from tracer.study.methods import Setting
from tracer.study.reference import make_reference

TARGETS = (0.2, 0.1, 0.05)
CRITERIA = ("fused", "uniform")
SEEDS = (0, 1, 2)
WIDTH = 192
MOST_SPP = 1024
REFERENCE_SPP = 4096
FACTOR = 1.3
"""Predicted and true error should be within it."""


@dataclass(frozen=True)
class Stop:
    """One render to a noise target."""

    scene: str
    criterion: str
    target: float
    seed: int
    stopped_by: str
    predicted: float
    true: float
    """Error that as many pixels in fact keep within."""
    within: float
    """Share of the pixels that in fact are within the target."""
    spp: float
    seconds: float


def step_count() -> int:
    """Return how many steps a scene has: its reference, and a render each."""
    return 1 + len(TARGETS) * len(CRITERIA) * len(SEEDS)


def true_errors(view: View, settings: Settings, image: NDArray, reference: NDArray) -> NDArray[np.float64]:
    """Return the error of each pixel (H, W) against a reference (H, W, 3), as a noise target counts it."""
    weights = objective.weights(settings.objective, view.luminance(reference), settings.exposure)
    return np.sqrt(weights * np.mean((view.rgb(image) - reference) ** 2, axis=-1))


def stops(name: str, path: Path, announce: Announce) -> list[Stop]:
    """Render a scene to every target."""
    setting = Setting(path, size=WIDTH)
    announce(f"{name}: reference")
    reference = make_reference(setting, REFERENCE_SPP).image
    with open_scene(path, size=WIDTH) as view:
        return [
            stop(view, name, reference, target, criterion, seed, announce)
            for target in TARGETS
            for criterion in CRITERIA
            for seed in SEEDS
        ]


def stop(
    view: View, scene: str, reference: NDArray, target: float, criterion: str, seed: int, announce: Announce
) -> Stop:
    """Render to a target."""
    announce(f"{scene}: to {target}, {criterion}, seed {seed}")
    settings = make_settings(spp=MOST_SPP, noise=target, criterion=criterion, seed=seed)
    result = render_request(Request(view, settings))
    errors = true_errors(view, settings, result.image, reference)
    return Stop(
        scene=scene,
        criterion=criterion,
        target=target,
        seed=seed,
        stopped_by=str(result.report.stopped_by),
        predicted=float(result.report.noise or 0.0),
        true=float(np.quantile(errors, settings.noise_share)),
        within=float(np.mean(errors <= target)),
        spp=float(result.samples.mean()),
        seconds=result.seconds,
    )


def select(stops: list[Stop], **wanted: Any) -> list[Stop]:
    """Return the renders whose fields have these values."""
    return [stop for stop in stops if all(getattr(stop, name) == value for name, value in wanted.items())]


def scenes_of(stops: list[Stop]) -> list[str]:
    """Return the scenes in the order of the renders."""
    return list(dict.fromkeys(stop.scene for stop in stops))


def accuracy_rows(stops: list[Stop]) -> list[list[str]]:
    """Return a row for each scene and criterion: predicted over true error for each target, and pixels within it."""
    rows = []
    for scene in scenes_of(stops):
        for criterion in CRITERIA:
            seeds = [select(stops, scene=scene, criterion=criterion, target=target) for target in TARGETS]
            shares = [f"{100 * np.mean([stop.within for stop in same]):.1f}" for same in seeds]
            rows.append([scene, criterion, *(ratio(same) for same in seeds), *shares])
    return rows


def ratio(stops: list[Stop]) -> str:
    """Return predicted over true error: geometric mean, and least and most over seeds; bold beyond FACTOR."""
    if not stops:
        return "-"
    ratios = [stop.predicted / stop.true for stop in stops]
    mean = float(np.exp(np.mean(np.log(ratios))))
    text = harness.middle_and_range(mean, ratios)
    return text if 1 / FACTOR <= mean <= FACTOR else f"**{text}**"


def cost_rows(stops: list[Stop]) -> list[list[str]]:
    """Return a row for each scene: samples per pixel, and seconds, until each target is met, of both criteria."""
    rows = []
    for scene in scenes_of(stops):
        both = [
            [select(stops, scene=scene, criterion=criterion, target=target) for criterion in CRITERIA]
            for target in TARGETS
        ]
        rows.append([scene, *(pair(amount, seeds) for seeds in both), *(pair(duration, seeds) for seeds in both)])
    return rows


def pair(show: Callable[[list[Stop]], str], seeds: list[list[Stop]]) -> str:
    """Return what is shown of each criterion, side by side."""
    return " / ".join(show(stops) for stops in seeds)


def amount(stops: list[Stop]) -> str:
    """Return the mean samples per pixel; with a mark where the budget ended a render before its target was met."""
    mark = ">" if any(stop.stopped_by != "noise" for stop in stops) else ""
    return f"{mark}{np.mean([stop.spp for stop in stops]):.0f}"


def duration(stops: list[Stop]) -> str:
    """Return the mean seconds."""
    return f"{np.mean([stop.seconds for stop in stops]):.1f}"


def draw(stops: list[Stop], path: Path) -> None:
    """Draw predicted against true errors."""
    with harness.figure(path, 5.6, 5) as figure:
        axis = figure.subplots()
        for number, scene in enumerate(scenes_of(stops)):
            for criterion, marker in zip(CRITERIA, "ox", strict=True):
                seeds = select(stops, scene=scene, criterion=criterion)
                true, predicted = [stop.true for stop in seeds], [stop.predicted for stop in seeds]
                label = scene if marker == "o" else None
                axis.plot(true, predicted, marker, ms=4, color=f"C{number}", label=label)
        ends = np.array([min(stop.true for stop in stops) * 0.8, max(stop.true for stop in stops) * 1.25])
        axis.loglog(ends, ends, color="black", lw=1)
        axis.fill_between(ends, ends / FACTOR, ends * FACTOR, color="black", alpha=0.1, lw=0)
        axis.set_xlabel("true error that 95 % of the pixels keep within")
        axis.set_ylabel("predicted when the render stopped")
        axis.set_title(f"o fused, x uniform; grey: a factor of {FACTOR}", fontsize=10)
        axis.legend(fontsize=7)

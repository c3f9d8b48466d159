"""Noise targets: the error predicted when a render stops, against the true error, and the samples that it took."""

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
"""Noise targets."""
CRITERIA = ("fused", "uniform")
"""Criteria that are compared."""
SEEDS = (0, 1, 2)
"""Seeds of the renders."""
WIDTH = 192
"""Width of the pictures in pixels."""
MOST_SPP = 1024
"""Largest mean number of samples per pixel of a render."""
REFERENCE_SPP = 4096
"""Smallest number of samples per pixel of a reference."""
FACTOR = 1.3
"""Largest factor by which predicted and true error should differ."""


@dataclass(frozen=True)
class Stop:
    """Result of a render to a noise target."""

    scene: str
    criterion: str
    target: float
    seed: int
    stopped_by: str
    predicted: float
    true: float
    """True error that the share of pixels of the noise target keeps within."""
    within: float
    """Share of the pixels whose true error is within the target."""
    spp: float
    """Mean samples per pixel."""
    seconds: float
    """Duration of the render."""


def step_count() -> int:
    """Return the number of steps of a scene: one for its reference, and one for each render."""
    return 1 + len(TARGETS) * len(CRITERIA) * len(SEEDS)


def true_errors(view: View, settings: Settings, image: NDArray, reference: NDArray) -> NDArray[np.float64]:
    """Return the error of each pixel (H, W) against a reference (H, W, 3), as noise targets define it."""
    weights = objective.weights(settings.objective, view.luminance(reference), settings.exposure)
    return np.sqrt(weights * np.mean((view.rgb(image) - reference) ** 2, axis=-1))


def stops(name: str, path: Path, announce: Announce) -> list[Stop]:
    """Return the results of all renders of a scene: to every target, by every criterion and seed."""
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
    """Return the result of a render to a target."""
    announce(f"{scene}: to {target}, {criterion}, seed {seed}")
    settings = make_settings(spp=MOST_SPP, noise=target, criterion=criterion, guide=False, seed=seed)
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


def select(stops: list[Stop], **values: Any) -> list[Stop]:
    """Return the results whose fields have the given values."""
    return [stop for stop in stops if all(getattr(stop, name) == value for name, value in values.items())]


def scenes_of(stops: list[Stop]) -> list[str]:
    """Return the names of the scenes in the order of the renders."""
    return list(dict.fromkeys(stop.scene for stop in stops))


def accuracy_rows(stops: list[Stop]) -> list[list[str]]:
    """Return a row for each scene and criterion: for each target, predicted over true error, and pixels within it."""
    rows = []
    for scene in scenes_of(stops):
        for criterion in CRITERIA:
            stops_by_target = [select(stops, scene=scene, criterion=criterion, target=target) for target in TARGETS]
            shares = [
                f"{100 * np.mean([stop.within for stop in stops_of_seeds]):.1f}" for stops_of_seeds in stops_by_target
            ]
            rows.append([scene, criterion, *(ratio(stops_of_seeds) for stops_of_seeds in stops_by_target), *shares])
    return rows


def ratio(stops: list[Stop]) -> str:
    """Return predicted over true error as text: geometric mean, smallest and largest over seeds; bold beyond FACTOR."""
    if not stops:
        return "-"
    ratios = [stop.predicted / stop.true for stop in stops]
    mean = float(np.exp(np.mean(np.log(ratios))))
    text = harness.middle_and_range(mean, ratios)
    return text if 1 / FACTOR <= mean <= FACTOR else f"**{text}**"


def cost_rows(stops: list[Stop]) -> list[list[str]]:
    """Return a row for each scene: samples per pixel, and seconds, until each target is met, for both criteria."""
    rows = []
    for scene in scenes_of(stops):
        stops_by_criterion = [
            [select(stops, scene=scene, criterion=criterion, target=target) for criterion in CRITERIA]
            for target in TARGETS
        ]
        rows.append(
            [
                scene,
                *(pair(amount, seeds) for seeds in stops_by_criterion),
                *(pair(duration, seeds) for seeds in stops_by_criterion),
            ]
        )
    return rows


def pair(show: Callable[[list[Stop]], str], stops_by_criterion: list[list[Stop]]) -> str:
    """Return the texts that ``show`` makes for each criterion, side by side."""
    return " / ".join(show(stops) for stops in stops_by_criterion)


def amount(stops: list[Stop]) -> str:
    """Return the mean samples per pixel as text, with a mark if the budget ended a render before its target was met."""
    mark = ">" if any(stop.stopped_by != "noise" for stop in stops) else ""
    return f"{mark}{np.mean([stop.spp for stop in stops]):.0f}"


def duration(stops: list[Stop]) -> str:
    """Return the mean duration in seconds as text."""
    return f"{np.mean([stop.seconds for stop in stops]):.1f}"


def draw(stops: list[Stop], path: Path) -> None:
    """Draw predicted against true errors."""
    with harness.figure(path, 5.6, 5) as figure:
        axis = figure.subplots()
        for index, scene in enumerate(scenes_of(stops)):
            for criterion, marker in zip(CRITERIA, "ox", strict=True):
                selected_stops = select(stops, scene=scene, criterion=criterion)
                true, predicted = [stop.true for stop in selected_stops], [stop.predicted for stop in selected_stops]
                label = scene if marker == "o" else None
                axis.plot(true, predicted, marker, ms=4, color=f"C{index}", label=label)
        ends = np.array([min(stop.true for stop in stops) * 0.8, max(stop.true for stop in stops) * 1.25])
        axis.loglog(ends, ends, color="black", lw=1)
        axis.fill_between(ends, ends / FACTOR, ends * FACTOR, color="black", alpha=0.1, lw=0)
        axis.set_xlabel("true error that 95 % of the pixels keep within")
        axis.set_ylabel("predicted when the render stopped")
        axis.set_title(f"o fused, x uniform; grey: a factor of {FACTOR}", fontsize=10)
        axis.legend(fontsize=7)

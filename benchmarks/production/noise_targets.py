"""Noise targets: the error that is predicted when a render stops against the true one, and the samples it took."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from tracer.image import objective
from tracer.scene.view import View, open_scene
from tracer.session.render_loop import render_view
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

Told = Callable[[str], None]


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


def true_errors(view: View, settings: Settings, image: NDArray, reference: NDArray) -> NDArray[np.float64]:
    """Return the error of each pixel (H, W) against a reference (H, W, 3), as a noise target counts it."""
    weights = objective.weights(settings.objective, view.luminance(reference), settings.exposure)
    return np.sqrt(weights * np.mean((view.rgb(image) - reference) ** 2, axis=-1))


def stops(name: str, path: Path, told: Told) -> list[Stop]:
    """Render a scene to every target."""
    setting = Setting(path, size=WIDTH)
    told(f"{name}: reference")
    reference = make_reference(setting, REFERENCE_SPP).image
    found = []
    with open_scene(path, size=WIDTH) as view:
        for target in TARGETS:
            for criterion in CRITERIA:
                for seed in SEEDS:
                    told(f"{name}: to {target}, {criterion}, seed {seed}")
                    settings = make_settings(spp=MOST_SPP, noise=target, criterion=criterion, seed=seed)
                    result = render_view(view, settings)
                    errors = true_errors(view, settings, result.image, reference)
                    report = result.report
                    found.append(
                        Stop(
                            scene=name,
                            criterion=criterion,
                            target=target,
                            seed=seed,
                            stopped_by=str(report.stopped_by),
                            predicted=float(report.noise or 0.0),
                            true=float(np.quantile(errors, settings.noise_share)),
                            within=float(np.mean(errors <= target)),
                            spp=float(result.samples.mean()),
                            seconds=result.seconds,
                        )
                    )
    return found


def some(found: list[Stop], **wanted: Any) -> list[Stop]:
    """Return the renders whose fields have these values."""
    return [one for one in found if all(getattr(one, name) == value for name, value in wanted.items())]


def ratio(those: list[Stop]) -> str:
    """Return predicted over true error: geometric mean, and least and most over seeds; bold beyond FACTOR."""
    if not those:
        return "-"
    ratios = [one.predicted / one.true for one in those]
    mean = float(np.exp(np.mean(np.log(ratios))))
    text = f"{mean:.2f} [{min(ratios):.2f}, {max(ratios):.2f}]"
    return text if 1 / FACTOR <= mean <= FACTOR else f"**{text}**"


def accuracy_rows(found: list[Stop]) -> list[list[str]]:
    """Return a row for each scene and criterion: predicted over true error for each target."""
    rows = []
    for scene in dict.fromkeys(one.scene for one in found):
        for criterion in CRITERIA:
            those = some(found, scene=scene, criterion=criterion)
            rows.append(
                [scene, criterion]
                + [ratio(some(those, target=target)) for target in TARGETS]
                + [f"{100 * np.mean([one.within for one in some(those, target=target)]):.1f}" for target in TARGETS]
            )
    return rows


def cost_rows(found: list[Stop]) -> list[list[str]]:
    """Return a row for each scene: samples per pixel, and seconds, until each target is met, of both criteria."""
    rows = []
    for scene in dict.fromkeys(one.scene for one in found):
        row = [scene]
        for target in TARGETS:
            both = [some(found, scene=scene, criterion=criterion, target=target) for criterion in CRITERIA]
            row.append(" / ".join(amount(those) for those in both))
        for target in TARGETS:
            both = [some(found, scene=scene, criterion=criterion, target=target) for criterion in CRITERIA]
            row.append(" / ".join(f"{np.mean([one.seconds for one in those]):.1f}" for those in both))
        rows.append(row)
    return rows


def amount(those: list[Stop]) -> str:
    """Return the mean samples per pixel; with a mark where the budget ended a render before its target was met."""
    mark = ">" if any(one.stopped_by != "noise" for one in those) else ""
    return f"{mark}{np.mean([one.spp for one in those]):.0f}"


def draw(found: list[Stop], path: Path) -> None:
    """Draw predicted against true errors."""
    figure = Figure(figsize=(5.6, 5), layout="constrained")
    axis = figure.subplots()
    for scene in dict.fromkeys(one.scene for one in found):
        for criterion, marker in zip(CRITERIA, "ox", strict=True):
            those = some(found, scene=scene, criterion=criterion)
            label = scene if marker == "o" else None
            colour = f"C{list(dict.fromkeys(one.scene for one in found)).index(scene)}"
            axis.plot(
                [one.true for one in those], [one.predicted for one in those], marker, ms=4, color=colour, label=label
            )
    ends = np.array([min(one.true for one in found) * 0.8, max(one.true for one in found) * 1.25])
    axis.loglog(ends, ends, color="black", lw=1)
    axis.fill_between(ends, ends / FACTOR, ends * FACTOR, color="black", alpha=0.1, lw=0)
    axis.set_xlabel("true error that 95 % of the pixels keep within")
    axis.set_ylabel("predicted when the render stopped")
    axis.set_title(f"o fused, x uniform; grey: a factor of {FACTOR}", fontsize=10)
    axis.legend(fontsize=7)
    figure.savefig(path, dpi=110)


def plain(found: list[Stop]) -> list[dict[str, Any]]:
    """Return all renders as plain values."""
    return [asdict(one) for one in found]

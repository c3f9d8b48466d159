"""How far the mean of adaptive pictures is off, and what it costs to give back what is lost.

Every scene is rendered with uniform samples, by the default, and by the default that gives nothing back, with the same
seeds; the truth is a uniform picture of many samples.
"""

from __future__ import annotations

import platform
from collections.abc import Callable
from dataclasses import asdict, astuple, dataclass
from functools import partial
from pathlib import Path
from typing import Any
from unittest.mock import patch

import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

import tracer
from benchmarks import harness
from benchmarks.harness import Announce
from tracer.film import bias
from tracer.image import metrics
from tracer.progress import StepCallback
from tracer.scene.load import load
from tracer.study.gains import Interval, gain
from tracer.study.tables import bounds, markdown_table

FILES = (harness.PAGE, harness.NUMBERS)
SIZE, BUDGETS, SEEDS, FIRST_SEED = 64, (16, 64), 16, 500
REFERENCE_SPP, REFERENCE_SEED = 8192, 1000003
METHODS: dict[str, dict[str, Any]] = {"uniform": {"criterion": "uniform"}, "given back": {}, "not given back": {}}
HEADINGS = (
    "scene",
    "spp",
    "bias, %",
    "if nothing is given back",
    "uniform",
    "gain",
    "if nothing is given back",
    "spread of the mean, %",
    "uniform",
)


@dataclass(frozen=True)
class Row:
    """One scene at one budget."""

    scene: str
    spp: int
    bias: dict[str, tuple[float, float]]
    """Of each method: relative error of the mean over seeds, and its standard error."""
    spread: dict[str, float]
    """Of each method: standard deviation of a picture's mean, relative."""
    gain: dict[str, tuple[float, float, float]]
    """Of each method but uniform: relMSE of uniform samples over its own, and the 95 % interval."""


def report(folder: Path, progress: StepCallback) -> None:
    """Measure all scenes, and write ``FILES`` after every scene: a run that is stopped leaves what it has measured.

    Raises KeyboardInterrupt if ``progress`` stops it.
    """
    scenes = openers()
    announce = harness.StepCounter(progress, len(scenes) * (1 + len(BUDGETS) * SEEDS))
    rows: list[Row] = []
    for name, opener in scenes.items():
        announce(f"{name}: reference")
        scene = opener()
        reference = tracer.render(scene, size=SIZE, spp=REFERENCE_SPP, seed=REFERENCE_SEED, criterion="uniform")
        truth = reference.image[..., :3]
        rows += [measure(name, scene, spp, truth, announce) for spp in BUDGETS]
        numbers = [asdict(row) for row in rows]
        harness.write(folder, numbers, to_page(numbers))


def openers() -> dict[str, Callable[[], Any]]:
    """Return what opens each scene: one is open at a time, as others slow it down."""
    bundled = {path.stem: partial(load, path) for path in harness.bundled_scenes()}
    return {"cornell_box": lambda: mi.load_dict(mi.cornell_box()), **bundled}


def measure(name: str, scene: Any, spp: int, truth: NDArray[np.float32], announce: Announce) -> Row:
    """Render a scene with all seeds and methods."""
    errors: dict[str, list[float]] = {method: [] for method in METHODS}
    means: dict[str, list[float]] = {method: [] for method in METHODS}
    level = truth.mean(dtype=np.float64)
    for seed in range(FIRST_SEED, FIRST_SEED + SEEDS):
        announce(f"{name}: {spp} spp, seed {seed}")
        for method, settings in METHODS.items():
            with patch("tracer.film.bias.MOST", 0.0 if method == "not given back" else bias.MOST):
                image = tracer.render(scene, size=SIZE, spp=spp, seed=seed, **settings).image[..., :3]
            errors[method].append(metrics.relative_mse(image, truth))
            means[method].append(float(image.mean(dtype=np.float64) / level - 1))
    gains = {method: gain(errors[method], errors["uniform"], np.ones(SEEDS)).interval for method in METHODS}
    spread = {method: float(np.std(values, ddof=1)) for method, values in means.items()}
    return Row(
        name,
        spp,
        {method: (float(np.mean(values)), spread[method] / SEEDS**0.5) for method, values in means.items()},
        spread,
        {method: astuple(interval) for method, interval in gains.items() if method != "uniform"},
    )


def to_page(numbers: list[dict[str, Any]]) -> str:
    """Return the results as Markdown."""
    conditions = (
        f"{SIZE} pixels wide, seeds {FIRST_SEED} to {FIRST_SEED + SEEDS - 1}, references of {REFERENCE_SPP} spp with "
        f"uniform samples; {platform.machine()}. Bias: error of a picture's mean and its 95 % interval. Gain: relMSE "
        "of uniform samples over that of the default, same samples. Spread: standard deviation of a picture's mean."
    )
    table = markdown_table(HEADINGS, [cells(Row(**row)) for row in numbers])
    return harness.page("Bias", f"{conditions}\n\n{table}", {})


def cells(row: Row) -> list[str]:
    """Return a row as text, a cell a heading."""
    biases = [row.bias[method] for method in ("given back", "not given back", "uniform")]
    gains = [row.gain[method] for method in ("given back", "not given back")]
    return [
        row.scene,
        str(row.spp),
        *(f"{100 * mean:+.2f} ± {196 * error:.2f}" for mean, error in biases),
        *(bounds(Interval(*gain)) for gain in gains),
        *(f"{100 * row.spread[method]:.2f}" for method in ("given back", "uniform")),
    ]

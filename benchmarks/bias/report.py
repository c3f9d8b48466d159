"""The bias of the mean of adaptive pictures, and the cost of the correction that gives lost light back.

Every scene is rendered with uniform samples, with the default, and with the default that gives nothing back, using the
same seeds. The reference is a uniform picture of many samples.
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
"""Names of the files that this benchmark writes."""
SIZE, BUDGETS, SEEDS, FIRST_SEED = 64, (16, 64), 16, 500
"""Width of the pictures in pixels, samples per pixel of the budgets, number of seeds, and the first seed."""
REFERENCE_SPP, REFERENCE_SEED = 8192, 1000003
"""Samples per pixel of a reference, and its seed, which no other picture has."""
METHODS: dict[str, dict[str, Any]] = {
    "uniform": {"criterion": "uniform"},
    "given back": {"guide": False},
    "not given back": {"guide": False},
}
"""Settings of each method, by its name. Lights are chosen as Mitsuba does, as they are in uniform pictures."""
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
"""Headings of the columns of the table."""


@dataclass(frozen=True)
class Row:
    """Results of a scene at a budget."""

    scene: str
    spp: int
    bias: dict[str, tuple[float, float]]
    """For each method, the relative error of the mean of a picture, averaged over seeds, and its standard error."""
    spread: dict[str, float]
    """For each method, the standard deviation over seeds of the mean of a picture, as a share of the true mean."""
    gain: dict[str, tuple[float, float | None, float | None]]
    """For each method but uniform, the relMSE of uniform samples over that of the method, and its 95 % interval: NaN,
    and None in a file, where both drew the same pictures."""


def report(folder: Path, progress: StepCallback) -> None:
    """Measure all scenes, and write ``FILES`` after every scene, so that a run that is stopped keeps its results.

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
    """Return a function for each scene that opens it: one scene is open at a time, as others would slow it down."""
    bundled = {path.stem: partial(load, path) for path in harness.bundled_scenes()}
    return {"cornell_box": lambda: mi.load_dict(mi.cornell_box()), **bundled}


def measure(name: str, scene: Any, spp: int, truth: NDArray[np.float32], announce: Announce) -> Row:
    """Return the results of a scene at a budget, rendered with all seeds and methods. ``truth`` (H, W, 3)."""
    errors: dict[str, list[float]] = {method: [] for method in METHODS}
    means: dict[str, list[float]] = {method: [] for method in METHODS}
    true_mean = truth.mean(dtype=np.float64)
    for seed in range(FIRST_SEED, FIRST_SEED + SEEDS):
        announce(f"{name}: {spp} spp, seed {seed}")
        for method, settings in METHODS.items():
            with patch("tracer.film.bias.MOST", 0.0 if method == "not given back" else bias.MOST):
                image = tracer.render(scene, size=SIZE, spp=spp, seed=seed, **settings).image[..., :3]
            errors[method].append(metrics.relative_mse(image, truth))
            means[method].append(float(image.mean(dtype=np.float64) / true_mean - 1))
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
    """Return the cells of a row as text, one for each heading."""
    biases = [row.bias[method] for method in ("given back", "not given back", "uniform")]
    gains = [row.gain[method] for method in ("given back", "not given back")]
    return [
        row.scene,
        str(row.spp),
        *(f"{100 * mean:+.2f} ± {196 * error:.2f}" for mean, error in biases),
        *(bounds(Interval(*(np.nan if value is None else value for value in gain))) for gain in gains),
        *(f"{100 * row.spread[method]:.2f}" for method in ("given back", "uniform")),
    ]

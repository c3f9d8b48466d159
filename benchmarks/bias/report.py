"""How far the mean of adaptive pictures is off, and what it costs to give back what is lost: results/bias.

    python -m benchmarks.bias.report -o results/bias

Every scene is rendered with uniform samples, by the default, and by the default that gives nothing back, with the same
seeds; the truth is a uniform picture of many samples.
"""

from __future__ import annotations

import json
import platform
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Annotated, Any
from unittest.mock import patch

import numpy as np
import typer
from numpy.typing import NDArray
from rich.progress import track

import tracer
from tracer.film import bias
from tracer.image import metrics
from tracer.io import atomic
from tracer.scene import load
from tracer.study.gains import gain

SIZE, BUDGETS, SEEDS, FIRST_SEED = 64, (16, 64), 16, 500
SCENES = 9
REFERENCE_SPP, REFERENCE_SEED = 8192, 1000003
METHODS: dict[str, dict[str, Any]] = {"uniform": {"criterion": "uniform"}, "given back": {}, "not given back": {}}


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


def bundled() -> Iterator[tuple[str, Any]]:
    """Yield Mitsuba's Cornell box and the scenes that come with tracer, one open at a time: others slow it down."""
    import mitsuba as mi

    yield "cornell_box", mi.load_dict(mi.cornell_box())
    for path in sorted((Path(__file__).parents[2] / "scenes").glob("*.xml")):
        yield path.stem, load.load(path)


def measure(name: str, scene: Any, spp: int, truth: NDArray[np.float32]) -> Row:
    """Render a scene with all seeds and methods."""
    errors: dict[str, list[float]] = {method: [] for method in METHODS}
    means: dict[str, list[float]] = {method: [] for method in METHODS}
    level = truth.mean(dtype=np.float64)
    for seed in range(FIRST_SEED, FIRST_SEED + SEEDS):
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
        {method: (found.mean, found.low, found.high) for method, found in gains.items() if method != "uniform"},
    )


def table(rows: list[Row]) -> str:
    """Return rows as Markdown."""
    lines = [
        "| scene | spp | bias, % | if nothing is given back | uniform | gain | if nothing is given back "
        "| spread of the mean, % | uniform |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    for row in rows:
        shown = [row.bias[method] for method in ("given back", "not given back", "uniform")]
        biases = [f"{100 * mean:+.2f} ± {196 * error:.2f}" for mean, error in shown]
        gains = [gain_and_interval(*row.gain[method]) for method in ("given back", "not given back")]
        spreads = [f"{100 * row.spread[method]:.2f}" for method in ("given back", "uniform")]
        lines.append(f"| {row.scene} | {row.spp} | {' | '.join([*biases, *gains, *spreads])} |")
    return "\n".join(lines) + "\n"


def gain_and_interval(mean: float, low: float, high: float) -> str:
    """Return a gain with its interval; there is none where both pictures are the same."""
    return f"{mean:.2f}" if np.isnan(low) else f"{mean:.2f} [{low:.2f}, {high:.2f}]"


def main(output: Annotated[Path, typer.Option("--output", "-o", help="Folder for the results.")]) -> None:
    """Measure the bias of the default on all bundled scenes; about a quarter of an hour on two cores."""
    tracer.activate()
    output.mkdir(parents=True, exist_ok=True)
    rows = []
    for name, scene in track(bundled(), "Scenes", total=SCENES):
        reference = tracer.render(scene, size=SIZE, spp=REFERENCE_SPP, seed=REFERENCE_SEED, criterion="uniform")
        truth = reference.image[..., :3]
        rows += [measure(name, scene, spp, truth) for spp in BUDGETS]
        write(output, rows)


def write(output: Path, rows: list[Row]) -> None:
    """Write what there is, after every scene: a run that is stopped leaves what it has measured."""
    conditions = (
        f"{SIZE} pixels wide, seeds {FIRST_SEED} to {FIRST_SEED + SEEDS - 1}, references of {REFERENCE_SPP} spp with "
        f"uniform samples; {platform.machine()}. Bias: error of a picture's mean and its 95 % interval. Gain: relMSE "
        "of uniform samples over that of the default, same samples. Spread: standard deviation of a picture's mean.\n"
    )
    atomic.write_text(output / "results.json", json.dumps([asdict(row) for row in rows], indent=1) + "\n")
    atomic.write_text(output / "results.md", f"# Bias\n\n{conditions}\n{table(rows)}")


if __name__ == "__main__":
    typer.run(main)

"""Show how a render decides: what it sees, what that is worth, where samples go, and which errors are left.

One scene is rendered by the default beside even samples, and one of a thousand lamps with and without learning which
lights matter where. All pictures of a scene have the same number of samples; the reference has many.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

import tracer
from benchmarks import harness
from benchmarks.decisions import figures
from benchmarks.decisions.figures import Panel
from benchmarks.harness import Announce
from tracer.core.arrays import Floats
from tracer.image.metrics import relative_mse
from tracer.progress import StepCallback
from tracer.study.panels import relative_error

DECISIONS, LIGHTS = "decisions.png", "lights.png"
"""File names of the figures."""
FILES = (harness.PAGE, harness.NUMBERS, DECISIONS, LIGHTS)
"""Names of the files that this benchmark writes."""
SCENE, LIT_SCENE = "spheres_and_rods", "thousand_lamps"
"""Names of the bundled scenes that show where samples go, and which lights are chosen."""
SIZE, SPP, SEED = 256, 64, 0
"""Width of the pictures in pixels, samples per pixel on average, and seed."""
REFERENCE_SPP, REFERENCE_SEED = 1024, 1000003
"""Samples per pixel of a reference, and its seed."""
STEPS = 6
"""Number of pictures that are rendered."""
ERROR_TOP = 0.99
"""Quantile of the errors of even samples at which the colours of both error maps end."""


def report(folder: Path, progress: StepCallback) -> None:
    """Render everything, and write ``FILES``. Raises KeyboardInterrupt if ``progress`` stops it."""
    announce = harness.StepCounter(progress, STEPS)
    numbers = {
        "decisions": show_decisions(folder / DECISIONS, announce),
        "lights": show_lights(folder / LIGHTS, announce),
    }
    harness.write(folder, numbers, to_page(numbers))


def show_decisions(path: Path, announce: Announce) -> dict[str, Any]:
    """Draw what is seen, what that is worth, where samples go, and the errors; return the numbers beside it."""
    even, adaptive, truth = pictures(SCENE, announce, {"criterion": "uniform"}, {}, {"criterion": "uniform"})
    errors = [relative_error(result.rgb, truth) for result in (even, adaptive)]
    scores = [relative_mse(result.rgb, truth) for result in (even, adaptive)]
    top = float(np.quantile(errors[0], ERROR_TOP))
    importance = adaptive.importance / adaptive.importance.mean()
    figures.write(
        path,
        [
            Panel("the picture", adaptive.rgb),
            Panel("complexity that pilot rays saw, bits", adaptive.complexity, colours="viridis"),
            Panel("importance, as a multiple of its mean", importance),
            Panel("samples of each pixel", adaptive.samples, is_logarithmic=True),
            Panel(f"error of even samples: relMSE {scores[0]:.2g}", errors[0], top=top),
            Panel(f"error of adaptive samples: relMSE {scores[1]:.2g}", errors[1], top=top),
        ],
        columns=3,
    )
    return {
        "scene": SCENE,
        "rounds": [{"least": drawn.least, "most": drawn.most} for drawn in adaptive.report.rounds],
        "even": scores[0],
        "adaptive": scores[1],
    }


def show_lights(path: Path, announce: Announce) -> dict[str, Any]:
    """Draw a picture with and without learned lights, and the errors of both; return the numbers beside it."""
    stock, learned, truth = pictures(
        LIT_SCENE,
        announce,
        {"criterion": "uniform", "guide": False},
        {"criterion": "uniform", "guide": True},
        {"criterion": "uniform", "guide": True},
    )
    errors = [relative_error(result.rgb, truth) for result in (stock, learned)]
    scores = [relative_mse(result.rgb, truth) for result in (stock, learned)]
    top = float(np.quantile(errors[0], ERROR_TOP))
    figures.write(
        path,
        [
            Panel("every lamp with the same chance", stock.rgb),
            Panel("lamps chosen by what they give", learned.rgb),
            Panel(f"error: relMSE {scores[0]:.2g}", errors[0], top=top),
            Panel(f"error: relMSE {scores[1]:.2g}", errors[1], top=top),
        ],
        columns=2,
    )
    return {"scene": LIT_SCENE, "same chance": scores[0], "learned": scores[1]}


def pictures(
    scene: str,
    announce: Announce,
    first: dict[str, Any],
    second: dict[str, Any],
    reference: dict[str, Any],
) -> tuple[tracer.Result, tracer.Result, Floats]:
    """Return two results of a bundled scene, with the same number of samples, and a reference (H, W, 3).

    The settings of each are given as a dictionary.
    """
    path = next(path for path in harness.bundled_scenes() if path.stem == scene)
    announce(f"{scene}: reference")
    truth = tracer.render(path, size=SIZE, spp=REFERENCE_SPP, seed=REFERENCE_SEED, **reference).rgb
    results = []
    for k, settings in enumerate((first, second)):
        announce(f"{scene}: picture {k + 1}")
        results.append(tracer.render(path, size=SIZE, spp=SPP, seed=SEED, **settings))
    return results[0], results[1], truth.astype(np.float64)


def to_page(numbers: dict[str, Any]) -> str:
    """Return the results as Markdown."""
    decided, lit = numbers["decisions"], numbers["lights"]
    counts = ", then ".join(
        f"{drawn['least']}" if drawn["least"] == drawn["most"] else f"{drawn['least']} to {drawn['most']}"
        for drawn in decided["rounds"]
    )
    introduction = (
        f"{harness.written_by('decisions')}: {SIZE} pixels wide, {SPP} samples per pixel on average, seed {SEED}; "
        f"references of {REFERENCE_SPP}. Maps of errors show the root of the relative squared error of each pixel, "
        "both of a scene in the same colours."
    )
    return harness.page(
        "Decisions",
        introduction,
        {
            "Where samples go": (
                f"![complexity, importance, samples and errors of {decided['scene']}]({DECISIONS})\n\n"
                f"{decided['scene']}, by the default. After its rounds pixels had {counts} samples. The relMSE of even "
                f"samples is {decided['even'] / decided['adaptive']:.2f} times that of the adaptive ones."
            ),
            "Which lights are chosen": (
                f"![{lit['scene']} with and without learned lights, and the errors]({LIGHTS})\n\n"
                f"{lit['scene']}, with the same number of samples in every pixel. Without learning, the relMSE is "
                f"{lit['same chance'] / lit['learned']:.1f} times as large."
            ),
        },
    )

"""Put a page together: numbers, tables, plots and pictures in one HTML file."""

from __future__ import annotations

import base64
import io
import json
from collections.abc import Sequence
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tracer.core.extras import require_package
from tracer.study.page.encode import encode_counts, encode_picture, reduce
from tracer.study.page.plots import convergence
from tracer.study.page.scene import ScenePictures, Shown
from tracer.study.panels import relative_error, write_panels
from tracer.study.records import Row, SceneFacts
from tracer.study.results import Results
from tracer.study.tables import HEADINGS, bounds, cells, legend
from tracer.study.write import conditions, finite

MOST_BYTES = 36 * 2**20
"""Of all pictures together: above it they are made smaller."""
TOP_SHARE = 0.99
"""Share of the baseline's pixels whose error the colours of the error maps can tell apart."""


def require_template_engine() -> Any:
    """Return the module ``jinja2``, which makes the page. Raises MissingPackageError if it is not installed."""
    return require_package("jinja2", "Jinja2", "The page of a study", "study")


def build_page(results: Results, pictures: Sequence[ScenePictures]) -> str:
    """Return the page."""
    jinja2 = require_template_engine()
    folder = files("tracer.study.page")
    environment = jinja2.Environment(
        autoescape=True, trim_blocks=True, lstrip_blocks=True, undefined=jinja2.StrictUndefined
    )
    template = environment.from_string((folder / "page.html").read_text(encoding="utf-8"))
    rows, means = results.tables()
    blocks, scenes = fit(results, pictures)
    return template.render(
        plan=results.plan,
        baseline=results.plan.compared_with,
        finished=results.finished,
        made=conditions(results),
        style=(folder / "style.css").read_text(encoding="utf-8"),
        scripts=[(folder / name).read_text(encoding="utf-8") for name in ("pixels.js", "viewer.js", "table.js")],
        means=[mean for mean in means if mean.method != results.plan.compared_with],
        bounds=bounds,
        headings=HEADINGS,
        lines=[list(zip(cells(row), sort_keys(row), strict=True)) for row in rows],
        legend=legend(results),
        facts=[
            {
                "facts": facts,
                "factor": shown["factor"],
                "ratio": closeness(facts, rows),
                "too_close": [row for row in rows if row.scene == facts.name and row.too_close],
                "plot": convergence([row for row in rows if row.scene == facts.name], facts.name),
                "strip": strip(results, one),
            }
            for facts, one, shown in zip(results.scenes, pictures, scenes, strict=True)
        ],
        failures=results.failures,
        data=json.dumps(finite({"scenes": scenes, "colours": colours()})),
        blocks=blocks,
    )


def closeness(facts: SceneFacts, rows: Sequence[Row]) -> float:
    """Return how many times the reference's error (RMS) fits into the smallest mean error on its scene."""
    smallest = min(row.scores.relative_mse for row in rows if row.scene == facts.name)
    return float(np.sqrt(smallest / max(facts.reference_relative_mse, 1e-30)))


def sort_keys(row: Row) -> list[str | float]:
    """Return what each cell of a row is sorted by: numbers, best estimates without their intervals, and names."""
    scores = row.scores
    gains = [np.nan if one is None else one.mean for one in (row.gain_samples, row.gain_trimmed, row.gain_time)]
    shares = [np.nan if one is None else one for one in (row.oracle_share, row.oracle_time_share)]
    budget = float(row.budget.split()[0])
    errors = [scores.relative_mse, scores.relative_mse_trimmed, scores.mse, scores.psnr, scores.ssim, scores.flip]
    return [row.scene, budget, row.method, *errors, scores.bias, row.spp, row.seconds, row.drawing, *gains, *shares]


def fit(results: Results, pictures: Sequence[ScenePictures]) -> tuple[dict[str, str], list[dict[str, Any]]]:
    """Return the encoded pictures by name and what the viewer knows of each scene, within MOST_BYTES."""
    asked = results.plan.page_size
    factors = [1 if asked is None else -(-facts.width // asked) for facts in results.scenes]
    while True:
        blocks: dict[str, str] = {}
        scenes = [
            encode_scene(one, facts, factor, blocks)
            for one, facts, factor in zip(pictures, results.scenes, factors, strict=True)
        ]
        if sum(map(len, blocks.values())) <= MOST_BYTES:
            return blocks, scenes
        factors = [factor + 1 for factor in factors]


def encode_scene(one: ScenePictures, facts: SceneFacts, factor: int, blocks: dict[str, str]) -> dict[str, Any]:
    """Add the pictures of a scene to ``blocks`` and return what the viewer knows of it."""

    def block(text: str) -> str:
        name = f"block{len(blocks)}"
        blocks[name] = text
        return name

    truth = reduce(one.reference, factor)
    methods = []
    for shown in one.shown:
        counts = shown.counts
        even = counts.min() == counts.max()
        methods.append(
            {
                "name": shown.method,
                "image": block(encode_picture(reduce(shown.image, factor))),
                "counts": float(counts.flat[0]) if even else block(encode_counts(np.rint(reduce(counts, factor)))),
                "score": f"relMSE {shown.relative_mse:.3g}",
            }
        )
    error = relative_error(reduce(one.shown[0].image, factor), truth)
    return {
        "name": facts.name,
        "width": truth.shape[1],
        "height": truth.shape[0],
        "factor": factor,
        "caption": f"{one.budget}, seed {one.seed}",
        "reference": block(encode_picture(truth)),
        "methods": methods,
        "errorTop": float(max(np.quantile(error, TOP_SHARE), 1e-6)),
        "countRange": [float(min(s.counts.min() for s in one.shown)), float(max(s.counts.max() for s in one.shown))],
    }


def strip(results: Results, one: ScenePictures) -> str:
    """Return pictures and errors of the baseline and the first adaptive method, for print, as the text of an image."""
    other = next((shown for shown in one.shown[1:] if np.ptp(shown.counts) > 0), one.shown[-1])
    pair: list[Shown] = [one.shown[0], other]
    errors = [relative_error(shown.image, one.reference) for shown in pair]
    panels: list[tuple[str, NDArray, bool]] = [(shown.method, shown.image, False) for shown in pair]
    panels += [(f"relative error, {shown.method}", error, False) for shown, error in zip(pair, errors, strict=True)]
    if np.ptp(other.counts) > 0:
        panels.append((f"samples per pixel, {other.method}", other.counts, True))
    file = io.BytesIO()
    write_panels(file, panels, f"{one.name}, {one.budget}", float(np.quantile(errors[0], TOP_SHARE)), "webp")
    return "data:image/webp;base64," + base64.b64encode(file.getvalue()).decode("ascii")


def colours() -> str:
    """Return matplotlib's colour map for errors and counts as 256 x 3 bytes, in hexadecimal."""
    from matplotlib import colormaps

    table = colormaps["magma"](np.arange(256))[:, :3]
    return np.rint(table * 255).astype(np.uint8).tobytes().hex()


def write_page(path: Path, results: Results, pictures: Sequence[ScenePictures]) -> None:
    """Write the page to a file."""
    from tracer.io.atomic import write_text

    write_text(path, build_page(results, pictures))

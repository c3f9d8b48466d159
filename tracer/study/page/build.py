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
"""Most bytes of all encoded pictures of a page together; pictures are made smaller until they fit."""
TOP_SHARE = 0.99
"""Share of the baseline's pixels whose error is below the top of the scale of colours of the error maps."""


def require_template_engine() -> Any:
    """Return the module ``jinja2``, which makes the page. Raises MissingPackageError if it is not installed."""
    return require_package("jinja2", "Jinja2", "The page of a study", "study")


def build_page(results: Results, pictures: Sequence[ScenePictures]) -> str:
    """Return the text of the page."""
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
                "strip": strip(results, scene_pictures),
            }
            for facts, scene_pictures, shown in zip(results.scenes, pictures, scenes, strict=True)
        ],
        failures=results.failures,
        data=json.dumps(finite({"scenes": scenes, "colours": colours()})),
        blocks=blocks,
    )


def closeness(facts: SceneFacts, rows: Sequence[Row]) -> float:
    """Return the smallest mean error of any row of a scene over the error of its reference (both RMS, in relMSE)."""
    smallest = min(row.scores.relative_mse for row in rows if row.scene == facts.name)
    return float(np.sqrt(smallest / max(facts.reference_relative_mse, 1e-30)))


def sort_keys(row: Row) -> list[str | float]:
    """Return what the table is sorted by, for each cell of a row: a name, or a number without its interval."""
    scores = row.scores
    gains = [np.nan if gain is None else gain.mean for gain in (row.gain_samples, row.gain_trimmed, row.gain_time)]
    shares = [np.nan if share is None else share for share in (row.oracle_share, row.oracle_time_share)]
    budget = float(row.budget.split()[0])
    errors = [scores.relative_mse, scores.relative_mse_trimmed, scores.mse, scores.psnr, scores.ssim, scores.flip]
    return [row.scene, budget, row.method, *errors, scores.bias, row.spp, row.seconds, row.drawing, *gains, *shares]


def fit(results: Results, pictures: Sequence[ScenePictures]) -> tuple[dict[str, str], list[dict[str, Any]]]:
    """Return the encoded pictures by name, within MOST_BYTES, and what the viewer needs to know of each scene."""
    page_size = results.plan.page_size
    factors = [1 if page_size is None else -(-facts.width // page_size) for facts in results.scenes]
    while True:
        blocks: dict[str, str] = {}
        scenes = [
            encode_scene(scene_pictures, facts, factor, blocks)
            for scene_pictures, facts, factor in zip(pictures, results.scenes, factors, strict=True)
        ]
        if sum(map(len, blocks.values())) <= MOST_BYTES:
            return blocks, scenes
        factors = [factor + 1 for factor in factors]


def encode_scene(pictures: ScenePictures, facts: SceneFacts, factor: int, blocks: dict[str, str]) -> dict[str, Any]:
    """Add the pictures of a scene to ``blocks`` and return what the viewer needs to know of the scene.

    ``factor``: pixels along the side of the squares that are averaged.
    """

    def block(text: str) -> str:
        name = f"block{len(blocks)}"
        blocks[name] = text
        return name

    truth = reduce(pictures.reference, factor)
    methods = []
    for shown in pictures.shown:
        counts = shown.counts
        uniform = counts.min() == counts.max()
        methods.append(
            {
                "name": shown.method,
                "image": block(encode_picture(reduce(shown.image, factor))),
                "counts": float(counts.flat[0]) if uniform else block(encode_counts(np.rint(reduce(counts, factor)))),
                "score": f"relMSE {shown.relative_mse:.3g}",
            }
        )
    error = relative_error(reduce(pictures.shown[0].image, factor), truth)
    return {
        "name": facts.name,
        "width": truth.shape[1],
        "height": truth.shape[0],
        "factor": factor,
        "caption": f"{pictures.budget}, seed {pictures.seed}",
        "reference": block(encode_picture(truth)),
        "methods": methods,
        "errorTop": float(max(np.quantile(error, TOP_SHARE), 1e-6)),
        "countRange": [
            float(min(shown.counts.min() for shown in pictures.shown)),
            float(max(shown.counts.max() for shown in pictures.shown)),
        ],
    }


def strip(results: Results, pictures: ScenePictures) -> str:
    """Return pictures and errors of the baseline and the first adaptive method, for print, as the URL of an image."""
    adaptive = next((shown for shown in pictures.shown[1:] if np.ptp(shown.counts) > 0), pictures.shown[-1])
    pair: list[Shown] = [pictures.shown[0], adaptive]
    errors = [relative_error(shown.image, pictures.reference) for shown in pair]
    panels: list[tuple[str, NDArray, bool]] = [(shown.method, shown.image, False) for shown in pair]
    panels += [(f"relative error, {shown.method}", error, False) for shown, error in zip(pair, errors, strict=True)]
    if np.ptp(adaptive.counts) > 0:
        panels.append((f"samples per pixel, {adaptive.method}", adaptive.counts, True))
    file = io.BytesIO()
    write_panels(file, panels, f"{pictures.name}, {pictures.budget}", float(np.quantile(errors[0], TOP_SHARE)), "webp")
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

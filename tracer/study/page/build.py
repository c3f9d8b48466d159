"""Put a page together: numbers, tables, plots and pictures in one HTML file."""

from __future__ import annotations

import json
from collections.abc import Sequence
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np

from tracer.core.extras import require_package
from tracer.study.clock import clock_warning
from tracer.study.page.encode import require_image_writer
from tracer.study.page.overview import overviews
from tracer.study.page.pictures import decoding, filters, fit
from tracer.study.page.plots import convergence
from tracer.study.page.scene import ScenePictures
from tracer.study.page.svg import marker, series
from tracer.study.records import Row, SceneFacts
from tracer.study.results import Results
from tracer.study.tables import HEADINGS, bounds, cells, legend, own_cells
from tracer.study.write import conditions, finite, numbers

SCRIPTS = ("pixels.js", "viewer.js", "pointer.js", "controls.js", "table.js")
"""Scripts of the page, in the order in which they run."""


def require_page_packages() -> Any:
    """Return the module ``jinja2``, which makes the page. Raises MissingPackageError if it or Pillow is missing."""
    jinja2 = require_package("jinja2", "Jinja2", "The page of a study", "study")
    require_image_writer()
    return jinja2


def build_page(results: Results, pictures: Sequence[ScenePictures]) -> str:
    """Return the text of the page."""
    jinja2 = require_page_packages()
    folder = files("tracer.study.page")
    environment = jinja2.Environment(
        autoescape=True, trim_blocks=True, lstrip_blocks=True, undefined=jinja2.StrictUndefined
    )
    template = environment.from_string((folder / "page.html").read_text(encoding="utf-8"))
    rows, means = results.tables()
    methods = [method.name for method in results.plan.methods]
    scenes = fit(results, pictures)
    data = {"scenes": [scene.viewer for scene in scenes], **decoding()}
    return template.render(
        plan=results.plan,
        baseline=results.plan.compared_with,
        finished=results.finished,
        clock=clock_warning(results),
        made=conditions(results),
        style=(folder / "style.css").read_text(encoding="utf-8"),
        scripts=[(folder / name).read_text(encoding="utf-8") for name in SCRIPTS],
        filters=filters(),
        methods=[(name, series(k), marker(k, 6, 6)) for k, name in enumerate(methods)],
        overviews=overviews(numbers(results)),
        means=[mean for mean in means if mean.method != results.plan.compared_with],
        bounds=bounds,
        headings=[*HEADINGS, *(rows[0].own if rows else ())],
        lines=[list(zip([*cells(row), *own_cells(row)], sort_keys(row), strict=True)) for row in rows],
        legend=legend(results),
        facts=[
            {
                "facts": facts,
                "factor": scene.viewer["factor"],
                "map_factor": scene.viewer["mapFactor"],
                "ratio": closeness(facts, rows),
                "too_close": [row for row in rows if row.scene == facts.name and row.too_close],
                "plots": convergence([row for row in rows if row.scene == facts.name], facts.name, methods),
                "sources": scene.sources,
                "caption": scene.viewer["caption"],
            }
            for facts, scene in zip(results.scenes, scenes, strict=True)
        ],
        failures=results.failures,
        data=json.dumps(finite(data)),
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
    used = [scores.bias, row.spp, row.seconds, row.drawing]
    return [row.scene, budget, row.method, *errors, *used, *gains, *shares, *row.own.values()]


def write_page(path: Path, results: Results, pictures: Sequence[ScenePictures]) -> None:
    """Write the page to a file."""
    from tracer.io.atomic import write_text

    write_text(path, build_page(results, pictures))

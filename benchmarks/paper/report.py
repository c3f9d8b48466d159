"""Measure the paper's rules for rays of patches in all scenes, and draw what they look like (figures 11 and 12)."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks import harness
from benchmarks.paper import methods
from benchmarks.radiosity import convergence
from benchmarks.radiosity.convergence import Place
from benchmarks.radiosity.figures import lit, picture, toned
from benchmarks.radiosity.scenes import examples
from tracer.progress import StepCallback
from tracer.radiosity.lattice import evenly, randomly
from tracer.radiosity.paper import PaperRules
from tracer.study.tables import markdown_table

FIGURE = "figure_11.png"
"""File name of the pictures."""
FILES = (harness.PAGE, harness.NUMBERS, FIGURE)
"""Names of the files that this benchmark writes."""
SHOWN, FEW = "chandelier", 256
"""Scene of the pictures, and rays a patch in them."""


def report(folder: Path, progress: StepCallback) -> None:
    """Measure everything, and write ``FILES``. Raises KeyboardInterrupt if ``progress`` stops it."""
    scenes = examples()
    announce = harness.StepCounter(progress, len(scenes) * (1 + methods.step_count()))
    rows: list[dict[str, Any]] = []
    for example in scenes:
        announce(f"{example.name}, truth")
        place = convergence.prepare(example)
        rows += methods.measure(place, announce)
        if example.name == SHOWN:
            draw(place, folder / FIGURE)
    harness.write(folder, rows, to_page(rows))


def to_page(rows: Sequence[dict[str, Any]]) -> str:
    """Return the results as Markdown."""
    rules = PaperRules()
    introduction = f"""
{harness.written_by("paper")}. Gain in mean squared error over classical random rays, and in brackets how much brighter
points are on average than they should be, {methods.SEEDS} seeds. By the paper's rules every point looks for itself,
with {rules.look} rays through each triangle, and splits triangles in which these see more than {rules.threshold:g}
faces; "looks free": these rays are not counted. "lattice": evenly spread rays; "guided": the default of tracer, with
looks. What is seen is a solution with 512 rays a patch."""
    counts = dict.fromkeys(row["rays"] for row in rows)
    sections = {f"{rays} rays": table([row for row in rows if row["rays"] == rays]) for rays in counts}
    sections["As many rays in all ways"] = f"![The patches of {SHOWN} in all ways]({FIGURE})"
    return harness.page("The paper's rules for rays", introduction, sections)


def table(rows: Sequence[dict[str, Any]]) -> str:
    """Return the table of a number of rays."""
    cells = {(row["method"], row["scene"]): f"{row['gain'][0]:.2f} ({100 * row['bias']:+.1f} %)" for row in rows}
    scenes, names = (dict.fromkeys(row[key] for row in rows) for key in ("scene", "method"))
    lines = [[name, *(cells.get((name, scene), "-") for scene in scenes)] for name in names]
    return markdown_table(["", *scenes], lines, right_aligned=True)


def draw(place: Place, path: Path) -> None:
    """Draw patches lit by few rays: random, of a lattice, guided, by the paper's rules, and by many rays."""
    guide = methods.looked(place, 1, 0)
    results = {
        "random rays": methods.plain(place, randomly, FEW, 0),
        "lattice": methods.plain(place, evenly, FEW, 0),
        "guided": methods.by_ours(place, FEW, 0),
        "the paper's rules": methods.by_rules(place, methods.Published(1, False, False), guide, FEW, 0),
        "energies made right": methods.by_rules(place, methods.Published(1, True, False), guide, FEW, 0),
    }
    truth = lit(place, place.truth)
    with harness.figure(path, 13, 9.2, dpi=80) as figure:
        axes = figure.subplots(2, 3).ravel()
        for axis, (title, result) in zip(axes, results.items(), strict=False):
            assert result is not None
            error = float(np.sqrt(np.mean((result.irradiance - place.truth) ** 2)) / place.truth.mean())
            axis.imshow(toned(picture(place, lit(place, result.irradiance)), truth))
            axis.set_title(f"{title}: {result.rays:.0f} rays a patch, error {error:.3f}")
        axes[-1].imshow(toned(picture(place, truth), truth))
        axes[-1].set_title("many rays")
        for axis in axes:
            axis.set_axis_off()

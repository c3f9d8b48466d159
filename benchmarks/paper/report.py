"""Measure the paper's rules for rays of patches in all scenes, and draw what they look like (figures 11 and 12)."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks import harness
from benchmarks.paper import few_rays, methods
from benchmarks.paper.scenes import THINGS, rooms
from benchmarks.radiosity import convergence
from benchmarks.radiosity.convergence import Gathered, Place
from benchmarks.radiosity.figures import lit, picture, toned
from benchmarks.radiosity.scenes import examples
from tracer.progress import StepCallback
from tracer.radiosity.lattice import evenly, randomly
from tracer.radiosity.paper import PaperRules
from tracer.study.tables import markdown_table

FIGURE, FEW_FIGURE = "figure_11.png", "few_rays.png"
"""File names of the pictures."""
FILES = (harness.PAGE, harness.NUMBERS, FIGURE, FEW_FIGURE)
"""Names of the files that this benchmark writes."""
SHOWN, FEW = "chandelier", 256
"""Scene of the pictures, and rays a patch in them."""
ROOM, FEWEST = "shining clutter", 32
"""Room of the pictures with few rays, and rays a patch in them."""
KINDS = {
    "gain": "Gain",
    "over_uniform": "Gain over uniform rays",
    "typical": "Gain of the typical patch",
    "in_corner": "Gain in the corner",
    "elsewhere": "Gain elsewhere",
}
"""Heading of the table of each kind of gain."""


def report(folder: Path, progress: StepCallback, resume: bool = False) -> None:
    """Measure everything, and write ``FILES``. Raises KeyboardInterrupt if ``progress`` stops it.

    ``resume``: keep the parts of the numbers that the folder has, and measure those that it lacks.
    """
    numbers = harness.measured_before(folder, resume)
    scenes = [] if "rows" in numbers else examples()
    crowded = [] if "few_rays" in numbers else rooms()
    announce = harness.StepCounter(
        progress, len(scenes) * (1 + methods.step_count()) + len(crowded) * (1 + few_rays.step_count())
    )
    rows: list[dict[str, Any]] = []
    for example in scenes:
        announce(f"{example.name}, truth")
        place = convergence.prepare(example)
        rows += methods.measure(place, announce)
        if example.name == SHOWN:
            draw(place, folder / FIGURE)
    few_rows: list[dict[str, Any]] = []
    for example in crowded:
        announce(f"{example.name}, truth")
        place = convergence.prepare(example)
        few_rows += few_rays.measure(place, announce)
        if example.name == ROOM:
            draw_few(place, folder / FEW_FIGURE)
    numbers = {"rows": rows, "few_rays": few_rows, **numbers}
    harness.write(folder, numbers, to_page(numbers))


def to_page(numbers: dict[str, Any]) -> str:
    """Return the results as Markdown."""
    rows, few_rows, rules = numbers["rows"], numbers["few_rays"], PaperRules()
    introduction = f"""
{harness.written_by("paper")}. Gain in mean squared error over classical random rays, and in brackets how much brighter
points are on average than they should be, {methods.SEEDS} seeds. By the paper's rules every point looks for itself,
with {rules.look} rays through each triangle, and splits triangles in which these see more than {rules.threshold:g}
faces; "looks free": these rays are not counted. "lattice": evenly spread rays; "guided": the default of tracer, with
looks. What is seen is a solution with 512 rays a patch."""
    counts = dict.fromkeys(row["rays"] for row in rows)
    sections = {f"{rays} rays": table([row for row in rows if row["rays"] == rays]) for rays in counts}
    sections["As many rays in all ways"] = f"![The patches of {SHOWN} in all ways]({FIGURE})"
    sections |= few_sections(few_rows)
    return harness.page("The paper's rules for rays", introduction, sections)


def few_sections(rows: Sequence[dict[str, Any]]) -> dict[str, str]:
    """Return the sections about few rays, by their headings."""
    patches = ", ".join(f"{scene} {count}" for scene, count in {row["scene"]: row["points"] for row in rows}.items())
    counts = dict.fromkeys(row["rays"] for row in rows)
    sections = {
        "Few rays, thousands of patches": f"""
Rooms with simple walls and {THINGS} small things in a corner. Patches that do not emit: \
{patches}. "random rays" are
distributed as the cosine; "uniform rays" have the same density everywhere, and weights by their cosine. Complexity is
"known" if it is found by {few_rays.KNOWN} rays through each triangle that are not counted; "4 looks free": by 4 that
are not counted; "1 look": by one that is. The typical patch is the median of squared errors, {few_rays.SEEDS} seeds.
Where a way is missing, there are too few rays for the triangles of most patches.
{summary(rows)}

![The patches of {ROOM} with {FEWEST} rays]({FEW_FIGURE})"""
    }
    for kind, heading in KINDS.items():
        for rays in counts if kind in ("gain", "over_uniform") else [max(counts)]:
            some = [row for row in rows if row["rays"] == rays]
            cells = {(row["method"], row["scene"]): f"{row[kind][0]:.2f}" for row in some}
            sections[f"{heading}, {rays} rays a patch"] = cell_table(some, cells)
    return sections


def summary(rows: Sequence[dict[str, Any]]) -> str:
    """Return in words where the paper's rules are better than others' rays, and where they are not."""
    by_rules = [row for row in rows if row["method"].startswith(("as printed", "energies right"))]
    lattice = {(row["scene"], row["rays"]): row["gain"][0] for row in rows if row["method"] == methods.LATTICE}
    random, uniform = ([row for row in by_rules if row[kind][0] > 1] for kind in ("gain", "over_uniform"))
    even = [row for row in by_rules if row["gain"][0] > lattice[row["scene"], row["rays"]]]
    counted = [row for row in by_rules if not any(word in row["method"] for word in ("known", "free"))]
    return f"""
By the paper's rules the mean squared error is smaller than that of random rays in {len(random)} of {len(by_rules)}
cases ({cases(random) or "none"}), than that of uniform rays in {len(uniform)}, and than that of the lattice in
{len(even)}. Where looks are counted, it is smaller than that of random rays in \
{sum(row in random for row in counted)} of {len(counted)} cases."""


def cases(rows: Sequence[dict[str, Any]]) -> str:
    """Return scenes and methods with the range of their gains over numbers of rays."""
    ranges: dict[tuple[str, str], list[float]] = {}
    for row in rows:
        ranges.setdefault((row["scene"], row["method"]), []).append(row["gain"][0])
    return "; ".join(
        f"{scene}, {method}: {min(gains):.2f}" + (f" to {max(gains):.2f}" if len(gains) > 1 else "")
        for (scene, method), gains in ranges.items()
    )


def table(rows: Sequence[dict[str, Any]]) -> str:
    """Return the table of a number of rays."""
    cells = {(row["method"], row["scene"]): f"{row['gain'][0]:.2f} ({100 * row['bias']:+.1f} %)" for row in rows}
    return cell_table(rows, cells)


def cell_table(rows: Sequence[dict[str, Any]], cells: dict[tuple[str, str], str]) -> str:
    """Return a table of cells, which are given by method and scene, with the methods and scenes of rows."""
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
    draw_results(place, results, path)


def draw_few(place: Place, path: Path) -> None:
    """Draw patches lit by very few rays: of a kind of random rays each, of a lattice, and by the paper's rules."""
    look = next(look for look in few_rays.LOOKS if look.depth == 1 and look.look == few_rays.KNOWN)
    guide = few_rays.looked(place, look, 0)
    results = {
        few_rays.UNIFORM: methods.plain(place, few_rays.uniformly, FEWEST, 0),
        few_rays.COSINE: methods.plain(place, randomly, FEWEST, 0),
        methods.LATTICE: methods.plain(place, evenly, FEWEST, 0),
        f"as printed, {look.name}": few_rays.by_rules(place, look, guide, False, FEWEST, 0),
        f"energies right, {look.name}": few_rays.by_rules(place, look, guide, True, FEWEST, 0),
    }
    draw_results(place, results, path)


def draw_results(place: Place, results: dict[str, Gathered | None], path: Path) -> None:
    """Draw the patches in the light of up to five results, and in that of many rays."""
    truth = lit(place, place.truth)
    with harness.figure(path, 13, 9.2, dpi=80) as figure:
        axes = figure.subplots(2, 3).ravel()
        for axis, (title, result) in zip(axes, results.items(), strict=False):
            if result is None:
                continue
            error = float(np.sqrt(np.mean((result.irradiance - place.truth) ** 2)) / place.truth.mean())
            axis.imshow(toned(picture(place, lit(place, result.irradiance)), truth))
            axis.set_title(f"{title}:\n{result.rays:.0f} rays a patch, error {error:.3f}")
        axes[-1].imshow(toned(picture(place, truth), truth))
        axes[-1].set_title("many rays")
        for axis in axes:
            axis.set_axis_off()

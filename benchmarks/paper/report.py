"""Measure the paper's rules for rays of patches in all scenes, and draw what they look like (figures 11 and 12)."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from benchmarks import harness
from benchmarks.paper import few_rays, figures, methods, shot
from benchmarks.paper.scenes import THINGS, rooms
from benchmarks.radiosity import convergence
from benchmarks.radiosity.scenes import Example, examples
from tracer.progress import StepCallback
from tracer.radiosity.paper import PaperRules
from tracer.study.tables import markdown_table

FREE_FIGURE, COUNTED_FIGURE, FEW_FIGURE, DEPTHS_FIGURE = "figure_11.png", "figure_12.png", "few_rays.png", "depths.png"
"""File names of the figures."""
FILES = (harness.PAGE, harness.NUMBERS, FREE_FIGURE, COUNTED_FIGURE, FEW_FIGURE, DEPTHS_FIGURE)
"""Names of the files that this benchmark writes."""
SHOWN, ROOM = "chandelier", "shining clutter"
"""Scene of the pictures, and room of those with few rays."""
COMPARED = ("clutter", "shining clutter")
"""Rooms in which other kinds of complexity are measured, and whose light is shot: what is complex shines in the second.
"""
ROOM_PARTS: dict[str, tuple[str, ...] | None] = {"few_rays": None, "other_kinds": COMPARED, "shooting": COMPARED}
"""Parts of the numbers that are measured room by room, and their rooms; None: all."""
ORDER = (methods.LATTICE, methods.OURS, *(form.name for form in methods.FORMS))
"""Order of the methods in the tables of all scenes."""
KINDS = {
    "gain": "Gain",
    "over_uniform": "Gain over uniform rays",
    "typical": "Gain of the typical patch",
    "in_corner": "Gain in the corner",
    "elsewhere": "Gain elsewhere",
}
"""Heading of the table of each kind of gain."""


Rows = list[dict[str, Any]]
"""Rows of a table, as plain values by name."""


def report(folder: Path, progress: StepCallback, resume: bool = False) -> None:
    """Measure everything, and write ``FILES``. Raises KeyboardInterrupt if ``progress`` stops it.

    ``resume``: keep the parts of the numbers that the folder has, and measure those that it lacks.
    """
    numbers: dict[str, Rows] = {name: [] for name in ROOM_PARTS} | harness.measured_before(folder, resume)
    measures_all = "rows" not in numbers
    draws_ways = measures_all or not all((folder / name).exists() for name in (FREE_FIGURE, COUNTED_FIGURE))
    scenes = [example for example in examples() if measures_all or (draws_ways and example.name == SHOWN)]
    crowded = {example.name: (example, parts_to_measure(example, numbers)) for example in rooms()}
    announce = harness.StepCounter(
        progress,
        len(scenes) * (1 + measures_all * methods.step_count())
        + draws_ways * 2 * sum(example.name == SHOWN for example in scenes)
        + sum(room_step_count(parts) for _, parts in crowded.values()),
    )
    rows: Rows = []
    for example in scenes:
        announce(f"{example.name}, truth")
        place = convergence.prepare(example)
        if measures_all:
            rows += methods.measure(place, announce)
        if example.name == SHOWN:
            for name, are_looks_free in ((FREE_FIGURE, True), (COUNTED_FIGURE, False)):
                announce(f"{example.name}, {name}")
                figures.draw_ways(place, are_looks_free, folder / name)
    numbers = {"rows": rows} | numbers
    figures.draw_depths(numbers["rows"], folder / DEPTHS_FIGURE)
    for example, parts in crowded.values():
        for name, measured in measure_room(example, parts, folder, announce).items():
            numbers[name] = [*numbers[name], *measured]
        harness.write(folder, numbers, to_page(numbers))


def parts_to_measure(example: Example, numbers: dict[str, Rows]) -> list[str]:
    """Return the parts of the numbers of a room that are not measured yet."""
    return [
        name
        for name, scenes in ROOM_PARTS.items()
        if (scenes is None or example.name in scenes) and not any(row["scene"] == example.name for row in numbers[name])
    ]


def room_step_count(parts: Sequence[str]) -> int:
    """Return the number of steps of a room."""
    steps = {
        "few_rays": few_rays.step_count(few_rays.RAYS),
        "other_kinds": few_rays.step_count(few_rays.OTHER_RAYS),
        "shooting": shot.step_count(),
    }
    return ("few_rays" in parts or "other_kinds" in parts) + sum(steps[name] for name in parts)


def measure_room(example: Example, parts: Sequence[str], folder: Path, announce: harness.Announce) -> dict[str, Rows]:
    """Return the rows of a room by the names of the parts of the numbers, and draw it if it is ``ROOM``."""
    rows: dict[str, Rows] = {}
    if "few_rays" in parts or "other_kinds" in parts:
        announce(f"{example.name}, truth")
        place = convergence.prepare(example)
    if "few_rays" in parts:
        rows["few_rays"] = few_rays.measure(place, few_rays.LOOKS, few_rays.RAYS, announce)
        if example.name == ROOM:
            figures.draw_few(place, folder / FEW_FIGURE)
    if "other_kinds" in parts:
        rows["other_kinds"] = few_rays.measure(place, few_rays.OTHER_LOOKS, few_rays.OTHER_RAYS, announce)
    if "shooting" in parts:
        rows["shooting"] = shot.measure(example, announce)
    return rows


def to_page(numbers: dict[str, Any]) -> str:
    """Return the results as Markdown."""
    rows, few_rows, rules = numbers["rows"], numbers["few_rays"], PaperRules()
    introduction = f"""
{harness.written_by("paper")}. D. Plemenos, M. Sbert and M. Feixas, "On viewpoint complexity of 3D scenes", section
4.2.2. Gain in mean squared error over classical random rays, and in brackets how much brighter
points are on average than they should be, {methods.SEEDS} seeds. By the paper's rules every point looks for itself,
with {rules.look} rays through each triangle, and splits triangles in which these see more than {rules.threshold:g}
faces; "looks free": these rays are not counted. "lattice": evenly spread rays; "guided": the default of tracer, with
looks. What is seen is a solution with 512 rays a patch. "-": looks would take more than two thirds of the rays."""
    counts = dict.fromkeys(row["rays"] for row in rows)
    sections = {f"{rays} rays": table([row for row in rows if row["rays"] == rays]) for rays in counts}
    sections["Gain by depth"] = f"![Gain of all ways by depth, for every scene]({DEPTHS_FIGURE})"
    sections["Figures 11 and 12: as many rays in all ways"] = f"""
In its figures 11 and 12 the paper compares its rules with classical random rays; its scenes are not at hand. With looks
that are not counted, as if the complexity were known:

![The patches of {SHOWN} in all ways, looks free]({FREE_FIGURE})

With looks that are counted, as complexity is estimated along rays in figure 12 of the paper:

![The patches of {SHOWN} in all ways, looks counted]({COUNTED_FIGURE})"""
    sections |= few_sections(few_rows)
    sections |= other_sections(numbers["other_kinds"])
    sections["Shooting"] = f"""
The paper's own method: patches shoot their light, the brightest first, until {100 * shot.RESIDUAL:g} % is left. Gain in
squared error of irradiance, mean over the area of patches that do not emit, over as many random rays; in brackets how
much brighter they are on average, and their rays, with those that look, over those of random rays. Light that is made
is shot on, so that rays grow, too; {shot.SEEDS} seeds. Rays are counted a patch, for the power that lamps supply.

{shot_table(numbers["shooting"])}"""
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

![The patches of {ROOM} with {figures.FEWEST} rays]({FEW_FIGURE})"""
    }
    for kind, heading in KINDS.items():
        for rays in counts if kind in ("gain", "over_uniform") else [max(counts)]:
            some = [row for row in rows if row["rays"] == rays]
            cells = {(row["method"], row["scene"]): f"{row[kind][0]:.2f}" for row in some}
            sections[f"{heading}, {rays} rays a patch"] = cell_table(some, cells)
    return sections


def other_sections(rows: Sequence[dict[str, Any]]) -> dict[str, str]:
    """Return the sections about entropy and C(V) as the complexity, by their headings."""
    sections = {}
    for rays in dict.fromkeys(row["rays"] for row in rows):
        some = [row for row in rows if row["rays"] == rays]
        cells = {(row["method"], row["scene"]): f"{row['gain'][0]:.2f} / {row['over_uniform'][0]:.2f}" for row in some}
        thresholds = ", ".join(f"{name} {threshold:g}" for name, (_, threshold) in few_rays.OTHER_KINDS.items())
        sections[f"Other kinds of complexity, {rays} rays a patch"] = f"""
Entropy in bits and C(V), which the paper defines in section 3.1, in place of the number of faces: gain over random /
uniform rays in the same rooms. Triangles above a threshold are split: {thresholds}. "4 looks": these rays are counted.
{summary(some)}

{cell_table(some, cells)}"""
    return sections


def shot_table(rows: Sequence[dict[str, Any]]) -> str:
    """Return the table of shooting."""
    scenes = dict.fromkeys(row["scene"] for row in rows)
    cells = {
        (f"{row['method']}, {row['rays']} rays", row["scene"]): (
            f"{row['gain'][0]:.2f} ({100 * row['bias']:+.1f} %, {row['traced']:.2f})"
        )
        for row in rows
    }
    names = dict.fromkeys(name for name, _ in cells)
    return markdown_table(
        ["", *scenes], [[name, *(cells[name, scene] for scene in scenes)] for name in names], right_aligned=True
    )


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
    return cell_table(sorted(rows, key=lambda row: ORDER.index(row["method"])), cells)


def cell_table(rows: Sequence[dict[str, Any]], cells: dict[tuple[str, str], str]) -> str:
    """Return a table of cells, which are given by method and scene, with the methods and scenes of rows."""
    scenes, names = (dict.fromkeys(row[key] for row in rows) for key in ("scene", "method"))
    lines = [[name, *(cells.get((name, scene), "-") for scene in scenes)] for name in names]
    return markdown_table(["", *scenes], lines, right_aligned=True)

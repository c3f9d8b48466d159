"""Measure and draw everything about radiosity."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from benchmarks import harness
from benchmarks.radiosity import ablations, convergence, figures, furnace, phases, solutions, views
from benchmarks.radiosity.convergence import Curve
from benchmarks.radiosity.scenes import examples
from tracer.progress import StepCallback
from tracer.study.gains import Interval
from tracer.study.tables import bounds, markdown_table

FIGURE = "convergence.png"
"""File name of the figure."""
FILES = (harness.PAGE, harness.NUMBERS, FIGURE)
"""Names of the files that this benchmark writes."""
CORNELL = "Cornell box"
"""Scene that is compared with paths."""
SOLVED = ("chandelier", "cove", "foliage")
"""Scenes of which whole solutions and pictures are made."""
VIEWED = (CORNELL, "chandelier", "cove", "foliage")
"""Scenes of which many views are compared with paths, and in which the time of solutions is looked into."""
MIDDLE = 256
"""Rays a point in the tables that show all methods."""
BEST = "deviation, warp"
"""Name of the method whose gains are shown for all numbers of rays."""

PARTS = {
    "curves": ("curves", "gains", "uses"),
    "solutions": ("solutions", "pictures"),
    "views": ("views",),
    "phases": ("phases",),
    "paths": ("paths", "large"),
    "furnace": ("furnace",),
}
"""Names of the numbers that are measured together, by the name of the part."""
Rows = list[dict[str, Any]]
"""Rows of a table, as plain values by name."""


def report(folder: Path, progress: StepCallback, resume: bool = False) -> None:
    """Measure everything, and write ``FILES``. Raises KeyboardInterrupt if ``progress`` stops it.

    ``resume``: keep the parts of the numbers that the folder has, and measure those that it lacks.
    """
    scenes = examples()
    numbers = {"seeds": convergence.SEEDS, **harness.measured_before(folder, resume)}
    lacks = {name: any(part not in numbers for part in parts) for name, parts in PARTS.items()}
    solved_count, viewed_count = (sum(example.name in names for example in scenes) for names in (SOLVED, VIEWED))
    announce = harness.StepCounter(
        progress,
        lacks["curves"] * len(scenes) * (1 + convergence.step_count() + ablations.step_count())
        + lacks["solutions"] * solved_count * solutions.step_count()
        + lacks["views"] * viewed_count * views.step_count()
        + lacks["phases"] * viewed_count * phases.step_count()
        + lacks["paths"] * solutions.cornell_step_count()
        + lacks["furnace"] * furnace.step_count(),
    )
    curves: list[Curve] = []
    measured: dict[str, Rows] = {name: [] for name in ("uses", "solutions", "pictures", "views", "phases")}
    for example in scenes:
        if lacks["curves"]:
            announce(f"{example.name}, truth")
            place = convergence.prepare(example)
            curves += convergence.measure(place, announce)
            measured["uses"] += ablations.uses(place, announce)
        if example.name in SOLVED and lacks["solutions"]:
            measured["solutions"] += solutions.solutions(example, announce)
            measured["pictures"].append(solutions.pictures(example, announce))
        if example.name in VIEWED and lacks["views"]:
            measured["views"].append(views.views(example, announce))
        if example.name in VIEWED and lacks["phases"]:
            measured["phases"] += phases.phases(example, announce)
    numbers |= {name: rows for name, rows in measured.items() if name not in numbers or rows}
    if lacks["curves"]:
        numbers |= {"curves": [asdict(curve) for curve in curves], "gains": convergence.gains_over_even(curves)}
    if lacks["paths"]:
        cornell = next(example for example in scenes if example.name == CORNELL)
        numbers["paths"] = solutions.against_paths(cornell, announce)
        numbers["large"] = solutions.large(cornell, announce)
    if lacks["furnace"]:
        numbers["furnace"] = furnace.furnace(announce)
    figures.draw_curves([Curve(**curve) for curve in numbers["curves"]], folder / FIGURE)
    harness.write(folder, numbers, to_page(numbers))


def to_page(numbers: dict[str, Any]) -> str:
    """Return the results as Markdown."""
    gains, seeds = numbers["gains"], numbers["seeds"]
    introduction = f"""
{harness.written_by("radiosity")}. A gain is a mean squared error of evenly spread rays over that of guided ones:
more than 1 is better. Rays that looked are counted. Intervals are of 95 % over {seeds} seeds (of the logarithm,
Student). Points are all patches that do not emit; what they see is a solution with 512 rays a patch. Complexity is that
of the faces that are seen. Methods take turns, and time is compared at the same number of rays."""
    sections = {
        f"Gain at {MIDDLE} rays": gain_table(gains, "equal_rays"),
        f"Gain in the time of {MIDDLE} rays": gain_table(gains, "equal_time"),
        f"Gain of {BEST}, at equal rays / time": f"""
{best_table(gains)}
![Error against rays and time]({FIGURE})""",
        f"Which use is best, at {MIDDLE} rays": f"""
Gain at equal rays over {ablations.SEEDS} seeds. Floor 0.5, depth 2 and looks 1/16 unless it says otherwise. \
Everything is guided
but in the last row.

{ablation_table(numbers["uses"], scenes_of(gains))}""",
        f"Whole solutions, {solutions.RAYS} rays a patch": solution_table(numbers["solutions"]),
        f"Final gathers, {solutions.SPP} samples a pixel": picture_table(numbers["pictures"]),
        "Views of one solution": f"""
Seconds of all processors. "apart" is how far pictures of the solution tend to be from those of paths, and "noise" the
error of {views.SPP} paths a pixel, both as root mean squares over the mean of the picture. How far they are apart is
found from pairs of pictures of {views.TRUTH} samples, whose noise is independent; "none seen": it is lost in what noise
is left. A view by radiosity takes as many samples as make its noise, and what it is apart, together as small as the
noise of paths; "-": what it is apart is more. From the last number of views on, one solution is cheaper than paths;
"-": it never is.

{view_table(numbers["views"])}""",
        "Where the time of a solution goes": f"""
Seconds of all processors, {phases.SPP} samples a pixel, once all kernels are compiled. Gathering is guided, and its
light straight from lamps comes along rays to them.

{phase_table(numbers["phases"])}""",
        "Furnace": f"""
A box of {numbers["furnace"][0]["patches"]} patches that shines and reflects everywhere: how far
the radiosity of patches is off, on average and at most, and how much too bright all are together.

{furnace_table(numbers["furnace"])}""",
        "Against the path tracer, in the Cornell box": f"""
Mean absolute difference of pictures from 2048 paths a pixel, over their mean; and the ratio of the means.

{path_table(numbers["paths"])}""",
        "Many patches": large_table(numbers["large"]),
    }
    return harness.page("Radiosity", introduction, sections)


def scenes_of(gains: Rows) -> list[str]:
    """Return the scenes in the order in which they were measured."""
    return list(dict.fromkeys(row["scene"] for row in gains))


def table(headings: Sequence[str], lines: Sequence[Sequence[str]]) -> str:
    """Return a table with its numbers aligned to the right."""
    return markdown_table(headings, lines, right_aligned=True)


def interval(values: Sequence[float]) -> str:
    """Return a gain and its interval as text."""
    return bounds(Interval(*values))


def gain_table(gains: Rows, kind: str) -> str:
    """Return a table of the gains of all methods in all scenes; ``kind``: equal_rays or equal_time."""
    scenes, methods = scenes_of(gains), dict.fromkeys(row["method"] for row in gains)
    cells = {(row["method"], row["scene"]): interval(row[kind]) for row in gains if row["rays"] == MIDDLE}
    return table(
        ["", *scenes], [[method, *(cells.get((method, scene), "-") for scene in scenes)] for method in methods]
    )


def best_table(gains: Rows) -> str:
    """Return a table of the gains of the best method by number of rays."""
    scenes = scenes_of(gains)
    cells = {
        (row["rays"], row["scene"]): f"{row['equal_rays'][0]:.2f} / {row['equal_time'][0]:.2f}"
        for row in gains
        if row["method"] == BEST
    }
    rays = dict.fromkeys(row["rays"] for row in gains)
    return table(["rays", *scenes], [[str(count), *(cells[count, scene] for scene in scenes)] for count in rays])


def ablation_table(uses: Rows, scenes: list[str]) -> str:
    """Return a table of the gains of all uses in all scenes."""
    cells = {(row["use"], row["scene"]): f"{row['equal_rays'][0]:.2f}" for row in uses}
    names = dict.fromkeys(row["use"] for row in uses)
    return table(["", *scenes], [[name, *(cells.get((name, scene), "-") for scene in scenes)] for name in names])


def solution_table(rows: Rows) -> str:
    """Return a table of gains and seconds of gathering and shooting."""
    lines = [
        [
            f"{row['method']}, {row['scene']}",
            str(row["patches"]),
            interval(row["equal_rays"]),
            *(f"{seconds:.2f}" for seconds in row["seconds"]),
        ]
        for row in rows
    ]
    return table(["", "patches", "gain", "seconds even", "guided"], lines)


def picture_table(rows: Rows) -> str:
    """Return a table of gains and seconds of final gathers."""
    lines = [
        [row["scene"], interval(row["equal_samples"]), *(f"{seconds:.2f}" for seconds in row["seconds"])]
        for row in rows
    ]
    return table(["", "gain", "seconds even", "guided"], lines)


def view_table(rows: Rows) -> str:
    """Return a table of the seconds of solutions and views, and of the views after which radiosity is cheaper."""
    lines = [
        [
            row["scene"],
            *("-" if row[name] is None else f"{row[name]:.2f}" for name in ("solved", "radiosity", "paths")),
            f"{100 * row['noise']:.1f} %",
            f"{100 * row['apart']:.1f} %" if row["apart"] > 0 else "none seen",
            str(row["number"] or "-"),
        ]
        for row in rows
    ]
    return table(["", "solved once", "a view by radiosity", "by paths", "noise", "apart", "views"], lines)


def phase_table(rows: Rows) -> str:
    """Return a table of the seconds of the phases of solutions; phases that a method does not have are left empty."""
    lines = [
        [
            f"{row['method']}, {row['scene']}",
            *(f"{row['seconds'][phase]:.2f}" if row["seconds"][phase] else "" for phase in phases.PHASES),
        ]
        for row in rows
    ]
    return table(["", *phases.PHASES.values()], lines)


def furnace_table(rows: Rows) -> str:
    """Return a table of how far the patches of a furnace are off."""
    lines = [
        [
            row["way"],
            str(row["rays"]),
            *(f"{100 * row[name]:.1f} %" for name in ("mean", "most")),
            f"{round(100 * row['all'], 1) + 0.0:+.1f} %",  # no -0.0
        ]
        for row in rows
    ]
    return table(["", "rays", "on average", "at most", "all together"], lines)


def path_table(rows: Rows) -> str:
    """Return a table of the differences between pictures of smaller and smaller patches and pictures of paths."""
    lines = [
        [
            f"{row['size']:g}",
            str(row["count"]),
            *(f"{100 * row[show]:.1f} %" for show in solutions.SHOWS),
            *(f"{row[f'{show} mean']:.4f}" for show in ("patches", "gather")),
        ]
        for row in rows
    ]
    return table(["edge", "patches", "patches", "smooth", "gather", "mean, patches", "gather"], lines)


def large_table(large: dict[str, Any]) -> str:
    """Return a table of the cost of a solution of many patches."""
    line = [
        CORNELL,
        str(large["patches"]),
        f"{large['rays'] / 1e6:.1f}",
        str(large["rounds"]),
        f"{large['residual']:.1e}",
        f"{large['seconds']:.1f}",
    ]
    return table(["", "patches", "million rays", "rounds", "residual", "seconds"], [line])

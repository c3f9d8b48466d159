"""Measure and draw everything about radiosity."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from benchmarks import harness
from benchmarks.radiosity import ablations, convergence, figures, solutions, views
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
"""Scenes of which many views are compared with paths."""
MIDDLE = 256
"""Rays a point in the tables that show all methods."""
BEST = "deviation, warp"
"""Name of the method whose gains are shown for all numbers of rays."""

Rows = list[dict[str, Any]]
"""Rows of a table, as plain values by name."""


def report(folder: Path, progress: StepCallback, resume: bool = False) -> None:
    """Measure everything, and write ``FILES``. Raises KeyboardInterrupt if ``progress`` stops it.

    ``resume``: keep the parts of the numbers that the folder has, and measure those that it lacks.
    """
    scenes = examples()
    numbers = {"seeds": convergence.SEEDS, **harness.measured_before(folder, resume)}
    measures_curves, measures_solutions, measures_views, measures_paths = (
        any(name not in numbers for name in names)
        for names in (("curves", "gains", "uses"), ("solutions", "pictures"), ("views",), ("paths", "large"))
    )
    solved_count, viewed_count = (sum(example.name in names for example in scenes) for names in (SOLVED, VIEWED))
    announce = harness.StepCounter(
        progress,
        measures_curves * len(scenes) * (1 + convergence.step_count() + ablations.step_count())
        + measures_solutions * solved_count * solutions.step_count()
        + measures_views * viewed_count * views.step_count()
        + measures_paths * solutions.cornell_step_count(),
    )
    curves: list[Curve] = []
    measured: dict[str, Rows] = {name: [] for name in ("uses", "solutions", "pictures", "views")}
    for example in scenes:
        if measures_curves:
            announce(f"{example.name}, truth")
            place = convergence.prepare(example)
            curves += convergence.measure(place, announce)
            measured["uses"] += ablations.uses(place, announce)
        if example.name in SOLVED and measures_solutions:
            measured["solutions"] += solutions.solutions(example, announce)
            measured["pictures"].append(solutions.pictures(example, announce))
        if example.name in VIEWED and measures_views:
            measured["views"].append(views.views(example, announce))
    numbers |= {name: rows for name, rows in measured.items() if name not in numbers or rows}
    if measures_curves:
        numbers |= {"curves": [asdict(curve) for curve in curves], "gains": convergence.gains_over_even(curves)}
    if measures_paths:
        cornell = next(example for example in scenes if example.name == CORNELL)
        numbers["paths"] = solutions.against_paths(cornell, announce)
        numbers["large"] = solutions.large(cornell, announce)
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
Seconds of all processors, to the noise of {views.SPP} paths a pixel. From the last number of views on, one solution is
cheaper than paths; "-": it never is. "apart" is the mean absolute difference of pictures of {views.TRUTH} samples, over
their mean: the bias of patches, and what noise is left.

{view_table(numbers["views"])}""",
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
            *(f"{row[name]:.2f}" for name in ("solved", "radiosity", "paths")),
            f"{100 * row['bias']:.1f} %",
            str(row["number"] or "-"),
        ]
        for row in rows
    ]
    return table(["", "solved once", "a view by radiosity", "by paths", "apart", "views"], lines)


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

"""All that is claimed of radiosity, measured and drawn."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from typing import Any

from benchmarks.radiosity import figures as drawn
from benchmarks.radiosity import solutions as whole
from benchmarks.radiosity.ablations import SEEDS as SOME
from benchmarks.radiosity.ablations import uses
from benchmarks.radiosity.convergence import RAYS, SEEDS, Curve, measure, prepare, rows
from benchmarks.radiosity.scenes import examples
from tracer.io.atomic import whole as whole_file
from tracer.io.atomic import write_text
from tracer.progress import StepCallback

FILES = ("results.md", "results.json", "convergence.png", "figure_11.png", "figure_12.png")
PAIRED = ("chandelier", "cove", "foliage")
NEEDED = ("chandelier", "Cornell box")


class Stopped(KeyboardInterrupt):
    """Raised between two steps when asked to stop."""


def everything(folder: Path, step: StepCallback) -> None:
    """Measure everything, and write ``FILES``."""
    done = 0

    def told(text: str) -> None:
        nonlocal done
        done += 1
        if not step(text, min(done, 499), 500):
            raise Stopped

    curves: list[Curve] = []
    tried: list[dict[str, Any]] = []
    solved, seen = [], []
    for example in examples():
        told(f"{example.name}, truth")
        place = prepare(example)
        curves += measure(place, told)
        tried += uses(place, told)
        if example.name == "chandelier":
            for name, figure in (("deviation, warp", "figure_11.png"), ("distinct, warp", "figure_12.png")):
                with whole_file(folder / figure) as path:
                    drawn.draw_both(place, name, path)
        if example.name in PAIRED:
            solved += whole.solutions(example, told)
            seen.append(whole.pictures(example, told))
    cornell = next(example for example in examples() if example.name == "Cornell box")
    paths = whole.against_paths(cornell, told)
    large = whole.large(cornell, told)
    with whole_file(folder / "convergence.png") as path:
        drawn.draw_curves(curves, path)
    found = {
        "seeds": SEEDS,
        "curves": [asdict(curve) for curve in curves],
        "gains": rows(curves),
        "uses": tried,
        "solutions": solved,
        "pictures": seen,
        "paths": paths,
        "large": large,
    }
    write_text(folder / "results.json", json.dumps(found, indent=1) + "\n")
    write_text(folder / "results.md", text(found))


def interval(values: tuple[float, float, float] | list[float]) -> str:
    """Return a number and its interval."""
    return f"{values[0]:.2f} [{values[1]:.2f}, {values[2]:.2f}]"


def table(head: list[str], lines: list[list[str]]) -> str:
    """Return a Markdown table."""
    rule = ["---", *["---:"] * (len(head) - 1)]
    return "".join("| " + " | ".join(line) + " |\n" for line in (head, rule, *lines))


def text(found: dict[str, Any]) -> str:
    """Return the results as Markdown."""
    gains, middle = found["gains"], 256
    scenes = list(dict.fromkeys(row["scene"] for row in gains))
    methods = list(dict.fromkeys(row["method"] for row in gains))
    at = {(row["method"], row["scene"]): row for row in gains if row["rays"] == middle}

    def every(what: str) -> list[list[str]]:
        return [
            [method, *(interval(at[method, scene][what]) if (method, scene) in at else "-" for scene in scenes)]
            for method in methods
        ]

    best = [
        [
            str(rays),
            *(
                next(
                    f"{row['equal_rays'][0]:.2f} / {row['equal_time'][0]:.2f}"
                    for row in gains
                    if (row["method"], row["scene"], row["rays"]) == ("deviation, warp", scene, rays)
                )
                for scene in scenes
            ),
        ]
        for rays in RAYS
    ]
    gained = {(row["use"], row["scene"]): f"{row['equal_rays'][0]:.2f}" for row in found["uses"]}
    tried = [
        [use, *(gained.get((use, scene), "-") for scene in scenes)] for use in dict.fromkeys(use for use, _ in gained)
    ]
    solved = [
        [
            f"{row['method']}, {row['scene']}",
            str(row["patches"]),
            interval(row["equal_rays"]),
            *(f"{seconds:.2f}" for seconds in row["seconds"]),
        ]
        for row in found["solutions"]
    ]
    seen = [
        [row["scene"], interval(row["equal_samples"]), *(f"{seconds:.2f}" for seconds in row["seconds"])]
        for row in found["pictures"]
    ]
    paths = [
        [
            f"{row['size']:g}",
            str(row["count"]),
            *(f"{100 * row[show]:.1f} %" for show in ("patches", "smooth", "gather")),
            *(f"{row[f'{show} mean']:.4f}" for show in ("patches", "gather")),
        ]
        for row in found["paths"]
    ]
    large = found["large"]
    return f"""# Radiosity

Written by `tracer radiosity-report`. A gain is a mean squared error of evenly spread rays over that of guided ones:
more than 1 is better. Rays that looked are counted. Intervals are of 95 % over {
        found["seeds"]
    } seeds (of the logarithm,
Student). Points are all patches that do not emit; what they see is a solution with 512 rays a patch. Complexity is that
of the faces that are seen. Methods take turns, and time is compared at the same number of rays.

## Gain at {middle} rays

{table(["", *scenes], every("equal_rays"))}
## Gain in the time of {middle} rays

{table(["", *scenes], every("equal_time"))}
## Gain of deviation, warp, at equal rays / time

{table(["rays", *scenes], best)}
![Error against rays and time](convergence.png)

## Which use is best, at {middle} rays

Gain at equal rays over {SOME} seeds. Floor 0.5, depth 2 and looks 1/16 unless it says otherwise. Everything is guided
but in the last row.

{table(["", *scenes], tried)}
## Whole solutions, {whole.RAYS} rays a patch

{table(["", "patches", "gain", "seconds even", "guided"], solved)}
## Final gathers, {whole.SPP} samples a pixel

{table(["", "gain", "seconds even", "guided"], seen)}
## Against the path tracer, in the Cornell box

Mean absolute difference of pictures from 2048 paths a pixel, over their mean; and the ratio of the means.

{table(["edge", "patches", "patches", "smooth", "gather", "mean, patches", "gather"], paths)}
## Many patches

{
        table(
            ["", "patches", "million rays", "rounds", "residual", "seconds"],
            [
                [
                    "Cornell box",
                    str(large["patches"]),
                    f"{large['rays'] / 1e6:.1f}",
                    str(large["rounds"]),
                    f"{large['residual']:.1e}",
                    f"{large['seconds']:.1f}",
                ]
            ],
        )
    }
## As many rays, both ways

As in figure 11 of the paper, with radiance as the guide:

![Figure 11](figure_11.png)

As in figure 12, with the number of faces that a few rays see:

![Figure 12](figure_12.png)
"""

"""Measure everything about production features, and write the results."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import Any

from benchmarks import harness
from benchmarks.production import noise_targets, overhead
from benchmarks.production.noise_targets import Stop
from tracer.progress import StepCallback
from tracer.study.tables import markdown_table

FIGURE = "noise.png"
"""File name of the figure."""
FILES = (harness.PAGE, harness.NUMBERS, FIGURE)
"""Names of the files that this benchmark writes."""
TIMED = ("spheres_and_rods", "window_interior")
"""Scenes with which overheads and limits of time are measured."""


def report(folder: Path, progress: StepCallback) -> None:
    """Measure everything, and write ``FILES``. Raises KeyboardInterrupt if ``progress`` stops it."""
    scenes = harness.bundled_scenes()
    total = len(scenes) * noise_targets.step_count() + len(TIMED) * overhead.step_count()
    announce = harness.StepCounter(progress, total)
    costs, limits = [], []
    for path in scenes:
        if path.stem in TIMED:
            costs += overhead.overheads(path.stem, path, announce)
            limits += overhead.limited(path.stem, path, announce)
    stops = [stop for path in scenes for stop in noise_targets.stops(path.stem, path, announce)]
    noise_targets.draw(stops, folder / FIGURE)
    numbers = {
        "noise": [asdict(stop) for stop in stops],
        "costs": [asdict(cost) for cost in costs],
        "limits": [asdict(limit) for limit in limits],
    }
    harness.write(folder, numbers, to_page(numbers))


def to_page(numbers: dict[str, Any]) -> str:
    """Return the results as Markdown."""
    stops, seeds = [Stop(**stop) for stop in numbers["noise"]], len(noise_targets.SEEDS)
    targets, factor = [f"{target:g}" for target in noise_targets.TARGETS], noise_targets.FACTOR
    accurate_count = sum(1 / factor <= stop.predicted / stop.true <= factor for stop in stops)
    accuracy = markdown_table(
        ["scene", "criterion", *(f"to {target}" for target in targets), *(f"% within {target}" for target in targets)],
        noise_targets.accuracy_rows(stops),
    )
    cost = markdown_table(
        ["scene", *(f"spp to {target}" for target in targets), *(f"s to {target}" for target in targets)],
        noise_targets.cost_rows(stops),
    )
    overheads = markdown_table(
        ["scene", "", "seconds", "overhead", "times"],
        [
            [row["scene"], row["way"], f"{row['seconds']:.1f}", f"{100 * row['share']:.1f} %", str(row["times"])]
            for row in numbers["costs"]
        ],
    )
    limits = markdown_table(
        ["scene", "--time", "seconds", "spp"],
        [
            [row["scene"], f"{row['limit']:g}", f"{row['seconds']:.1f}", f"{row['spp']:.1f}"]
            for row in numbers["limits"]
        ],
    )
    introduction = f"""
{harness.written_by("production")}, on {harness.machine()}. Scenes are those
that come with tracer, {noise_targets.WIDTH} pixels wide for noise, {overhead.WIDTH} for time."""
    sections = {
        "Noise targets": f"""
Predicted over true error that 95 % of the pixels keep within, when the render stopped: geometric mean over
{seeds} seeds, least and most; bold beyond a factor of {factor}. Then the percentage of pixels that are
in fact within the target, where 95 were asked for. At most {noise_targets.MOST_SPP} spp; references of at least
{noise_targets.REFERENCE_SPP} spp. {accurate_count} of {len(stops)} renders are within a factor of {factor}.

{accuracy}
![Predicted against true errors]({FIGURE})""",
        "What a target takes": f"""
Samples per pixel, and seconds, of fused / uniform; > where the budget came first.

{cost}""",
        "What it costs to show a picture and to keep a checkpoint": f"""
Against the plain render next to it, median of {overhead.REPEATS}. The PNG is written as often as its share allows, a
checkpoint every {overhead.KEEP_SECONDS:g} s.

{overheads}""",
        "Limits of time": f"""
Seconds of the whole program.

{limits}""",
    }
    return harness.page("Production", introduction, sections)

"""All that is claimed of production features, measured and written."""

from __future__ import annotations

import json
from dataclasses import asdict
from importlib.resources import files as package_files
from pathlib import Path

from benchmarks.production import noise_targets as noise
from benchmarks.production import overhead
from tracer.core import backend
from tracer.io.atomic import whole, write_text
from tracer.progress import StepCallback
from tracer.study.tables import markdown_table

FILES = ("results.md", "results.json", "noise.png")
TIMED = ("spheres_and_rods", "window_interior")


def everything(folder: Path, step: StepCallback) -> None:
    """Measure everything, and write ``FILES``. Raises KeyboardInterrupt if ``step`` stops it."""
    scenes = sorted(Path(str(package_files("tracer.scenes"))).glob("*.xml"))
    runs = len(noise.TARGETS) * len(noise.CRITERIA) * len(noise.SEEDS) + 1
    total = len(scenes) * runs + len(TIMED) * (3 * overhead.REPEATS + len(overhead.LIMITS))
    done = 0

    def told(text: str) -> None:
        nonlocal done
        if step(text, done, total) is False:
            raise KeyboardInterrupt
        done += 1

    costs, limits = [], []
    for path in scenes:
        if path.stem in TIMED:
            costs += overhead.overheads(path.stem, path, told)
            limits += overhead.limited(path.stem, path, told)
    stops = [stop for path in scenes for stop in noise.stops(path.stem, path, told)]
    with whole(folder / "noise.png") as path:
        noise.draw(stops, path)
    found = {
        "noise": noise.plain(stops),
        "costs": [asdict(one) for one in costs],
        "limits": [vars(one) for one in limits],
    }
    write_text(folder / "results.json", json.dumps(found, indent=1) + "\n")
    write_text(folder / "results.md", text(stops, costs, limits))


def text(stops: list[noise.Stop], costs: list[overhead.Overhead], limits: list[overhead.Limited]) -> str:
    """Return the results as Markdown."""
    targets = [f"{target:g}" for target in noise.TARGETS]
    good = sum(1 / noise.FACTOR <= one.predicted / one.true <= noise.FACTOR for one in stops)
    accuracy = markdown_table(
        ["scene", "criterion", *(f"to {each}" for each in targets), *(f"% within {each}" for each in targets)],
        noise.accuracy_rows(stops),
    )
    cost = markdown_table(
        ["scene", *(f"spp to {each}" for each in targets), *(f"s to {each}" for each in targets)],
        noise.cost_rows(stops),
    )
    shown = markdown_table(
        ["scene", "", "seconds", "overhead", "times"],
        [[one.scene, one.way, f"{one.seconds:.1f}", f"{100 * one.share:.1f} %", str(one.times)] for one in costs],
    )
    kept = markdown_table(
        ["scene", "--time", "seconds", "spp"],
        [[one.scene, f"{one.limit:g}", f"{one.seconds:.1f}", f"{one.spp:.1f}"] for one in limits],
    )
    return f"""# Production

Written by `tracer production-report`, on {backend.processor()} with {backend.thread_count()} threads. Scenes are those
that come with tracer, {noise.WIDTH} pixels wide for noise, {overhead.WIDTH} for time.

## Noise targets

Predicted over true error that 95 % of the pixels keep within, when the render stopped: geometric mean over
{len(noise.SEEDS)} seeds, least and most; bold beyond a factor of {noise.FACTOR}. Then the percentage of pixels that are
in fact within the target, where 95 were asked for. At most {noise.MOST_SPP} spp; references of at least
{noise.REFERENCE_SPP} spp. {good} of {len(stops)} renders are within a factor of {noise.FACTOR}.

{accuracy}
![Predicted against true errors](noise.png)

## What a target takes

Samples per pixel, and seconds, of fused / uniform; > where the budget came first.

{cost}
## What it costs to show a picture and to keep a checkpoint

Against the plain render next to it, median of {overhead.REPEATS}. The PNG is written as often as its share allows, a
checkpoint every {overhead.KEEP_SECONDS:g} s.

{shown}
## Limits of time

Seconds of the whole program.

{kept}"""

"""Measure everything about workers, and write the results."""

from __future__ import annotations

from dataclasses import asdict, fields
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks import harness
from benchmarks.cluster import measure, scaling_model
from benchmarks.cluster.measure import Pair
from benchmarks.cluster.scaling_model import Constants
from tracer.progress import StepCallback
from tracer.study.tables import markdown_table

FIGURE = "scaling.png"
"""File name of the figure."""
FILES = (harness.PAGE, harness.NUMBERS, FIGURE)
"""Names of the files that this benchmark writes."""
SCENES = ("spheres_and_rods", "window_interior")
"""Scenes that are rendered."""
PIXELS = 3840 * 2160
"""Number of pixels of the picture of the model."""
BUDGETS = (64, 256, 1024)
"""Mean samples per pixel of the model."""
WORKERS = (1, 10, 100, 1000)
"""Numbers of workers of the model."""
WORDS = {
    "drawing": "drawing",
    "scheduling": "the scheduler",
    "deciding": "deciding",
    "network": "the network",
    "developing": "taking in the sums, and the picture",
}
"""Name on the page of each part of the time of the model."""


def report(folder: Path, progress: StepCallback) -> None:
    """Measure everything, and write ``FILES``. Raises KeyboardInterrupt if ``progress`` stops it."""
    paths = [path for path in harness.bundled_scenes() if path.stem in SCENES]
    announce = harness.StepCounter(progress, len(paths) * measure.step_count())
    pairs = [measure.pair(path.stem, path, announce) for path in paths]
    constants = typical([measured for pair in pairs for measured in pair.constants])
    draw(constants, folder / FIGURE)
    numbers = {
        "pairs": [asdict(pair) for pair in pairs],
        "constants": asdict(constants),
        "network": scaling_model.NETWORK,
    }
    harness.write(folder, numbers, to_page(numbers))


def typical(measured: list[Constants]) -> Constants:
    """Return the median of each constant."""
    return Constants(
        **{
            field.name: float(np.median([getattr(constants, field.name) for constants in measured]))
            for field in fields(Constants)
        }
    )


def to_page(numbers: dict[str, Any]) -> str:
    """Return the results as Markdown."""
    pairs = [Pair(**pair) for pair in numbers["pairs"]]
    constants = Constants(**numbers["constants"])
    width, height = measure.SIZE
    sections = {
        "Throughput": f"""
{measure.WORKERS} workers of one thread against one process of {measure.WORKERS}, on the same two cores, in turns:
{width} x {height} pixels, {measure.SPP} spp, fused; medians of {len(measure.SEEDS)} seeds, least and most. Client and
scheduler run on these cores, too. Values that differ: of picture, counts and standard errors, of all seeds, and by how
much of the value at most. The last two are whole programs, start-up included.

{speed_table(pairs)}""",
        "What travels": f"""
Statistics come back every round, all sums once. Memory is the most that the client has at any time (16 spp).

{traffic_table(pairs)}""",
        "Where it stops scaling": f"""
A model with the constants measured above (medians), not a measurement: {PIXELS / 1e6:.1f} million pixels (4K), workers
of one thread, a client that {numbers["network"] / 1e9:.2f} GB a second can reach. A sample takes a thread
{1e6 * constants.sample:.2f} µs; client and scheduler {1e3 * constants.unit:.1f} ms for a unit, and for a pixel
{1e9 * constants.deciding:.0f} ns to decide a round, and {1e9 * constants.developing:.0f} ns to take in its sums and
develop it, once; {constants.round_bytes:.0f} bytes a pixel and round, {constants.sums_bytes:.0f} once.

{scaling_table(constants)}
![Speed-up by number of workers]({FIGURE})""",
    }
    return harness.page("Many machines", f"{harness.written_by('cluster')}, on {harness.machine()}.", sections)


def speed_table(pairs: list[Pair]) -> str:
    """Return a table of the seconds of one process and of workers, and of the differences of their pictures."""
    headings = [
        "scene",
        "s, one process",
        "s, workers",
        "throughput",
        "values that differ",
        "s, program",
        "s, program with workers",
    ]
    rows = [
        [
            pair.scene,
            f"{np.median(pair.alone):.1f}",
            f"{np.median(pair.workers):.1f}",
            harness.middle_and_range(float(np.median(pair.throughput)), pair.throughput),
            f"{pair.differing}" + (f" by {pair.difference:.0e}" if pair.differing else ""),
            f"{pair.programs['0']:.1f}",
            f"{pair.programs[str(measure.WORKERS)]:.1f}",
        ]
        for pair in pairs
    ]
    return markdown_table(headings, rows)


def traffic_table(pairs: list[Pair]) -> str:
    """Return a table of the bytes that travel for the first seed of each scene, and of the memory of the client."""
    headings = [
        "scene",
        "rounds",
        "units",
        "MB sent a round",
        "MB received a round",
        "MB of sums, once",
        "GiB client",
        "GiB alone",
    ]
    rows = []
    for pair in pairs:
        rounds, traffic = pair.rounds[0], pair.traffic[0]
        rows.append(
            [
                pair.scene,
                str(rounds),
                str(traffic["units"]),
                f"{traffic['bytes_sent'] / rounds / 1e6:.1f}",
                f"{(traffic['bytes_received'] - traffic['bytes_of_sums']) / rounds / 1e6:.1f}",
                f"{traffic['bytes_of_sums'] / 1e6:.0f}",
                f"{pair.memory[str(measure.WORKERS)]:.2f}",
                f"{pair.memory['0']:.2f}",
            ]
        )
    return markdown_table(headings, rows)


def scaling_table(constants: Constants) -> str:
    """Return a table of the times that the model predicts for more workers than were measured."""
    rows = []
    for spp in BUDGETS:
        for count, factor in zip(WORKERS, scaling_model.speed_up(constants, PIXELS, spp, WORKERS), strict=True):
            times = scaling_model.times(constants, PIXELS, spp, count)
            parts = [f"{getattr(times, name):.0f}" for name in WORDS]
            rows.append([str(spp), str(count), f"{times.total:.0f}", *parts, f"{factor:.0f}", WORDS[times.limit]])
    return markdown_table(["spp", "workers", "seconds", *WORDS.values(), "times as fast", "waits most for"], rows)


def draw(constants: Constants, path: Path) -> None:
    """Draw the speed-up by number of workers."""
    counts = np.unique(np.geomspace(1, 4096, 60).astype(int))
    with harness.figure(path, 6, 4.2, dpi=150) as figure:
        axes = figure.subplots()
        axes.loglog(counts, counts, color="0.7", linestyle="--", label="as many times as workers")
        for spp in BUDGETS:
            axes.loglog(counts, scaling_model.speed_up(constants, PIXELS, spp, counts.tolist()), label=f"{spp} spp")
        axes.set(
            xlabel="workers of one thread", ylabel="times as fast as one", title="4K, model with measured constants"
        )
        axes.grid(alpha=0.3)
        axes.legend(frameon=False)

"""All that is claimed of workers, measured and written."""

from __future__ import annotations

import json
from dataclasses import asdict, fields
from importlib.resources import files as package_files
from pathlib import Path

import numpy as np

from benchmarks.cluster import measure
from benchmarks.cluster import scaling_model as model
from benchmarks.cluster.measure import Pair
from benchmarks.cluster.scaling_model import Constants
from tracer.core import backend
from tracer.io.atomic import whole, write_text
from tracer.progress import StepCallback
from tracer.study.tables import markdown_table

FILES = ("results.md", "results.json", "scaling.png")
SCENES = ("spheres_and_rods", "window_interior")
PIXELS = 3840 * 2160
BUDGETS = (64, 256, 1024)
WORKERS = (1, 10, 100, 1000)
WORDS = {
    "drawing": "drawing",
    "scheduling": "the scheduler",
    "deciding": "deciding",
    "network": "the network",
    "developing": "taking in the sums, and the picture",
}


def everything(folder: Path, step: StepCallback) -> None:
    """Measure everything, and write ``FILES``. Raises KeyboardInterrupt if ``step`` stops it."""
    total, done = len(SCENES) * (len(measure.SEEDS) + 3), 0

    def told(text: str) -> None:
        nonlocal done
        if step(text, done, total) is False:
            raise KeyboardInterrupt
        done += 1

    scenes = Path(str(package_files("tracer.scenes")))
    pairs = [measure.pair(name, scenes / f"{name}.xml", told) for name in SCENES]
    constants = typical([one for pair in pairs for one in pair.constants])
    with whole(folder / "scaling.png") as path:
        draw(constants, path)
    plain = {"pairs": [asdict(pair) for pair in pairs], "constants": asdict(constants), "network": model.NETWORK}
    write_text(folder / "results.json", json.dumps(plain, indent=1) + "\n")
    write_text(folder / "results.md", text(pairs, constants))


def typical(found: list[Constants]) -> Constants:
    """Return the median of each constant."""
    return Constants(
        **{one.name: float(np.median([getattr(each, one.name) for each in found])) for one in fields(Constants)}
    )


def text(pairs: list[Pair], constants: Constants) -> str:
    """Return the results as Markdown."""
    width, height = measure.SIZE
    speed = markdown_table(
        [
            "scene",
            "s, one process",
            "s, workers",
            "throughput",
            "values that differ",
            "s, program",
            "s, program with workers",
        ],
        [
            [
                pair.scene,
                f"{np.median(pair.alone):.1f}",
                f"{np.median(pair.workers):.1f}",
                f"{np.median(pair.throughput):.2f} [{min(pair.throughput):.2f}, {max(pair.throughput):.2f}]",
                f"{pair.differing}" + (f" by {pair.difference:.0e}" if pair.differing else ""),
                f"{pair.programs['0']:.1f}",
                f"{pair.programs[str(measure.WORKERS)]:.1f}",
            ]
            for pair in pairs
        ],
    )
    traffic = markdown_table(
        [
            "scene",
            "rounds",
            "units",
            "MB sent a round",
            "MB received a round",
            "MB of sums, once",
            "GiB client",
            "GiB alone",
        ],
        [
            [
                pair.scene,
                str(rounds := pair.rounds[0]),
                str(one["units"]),
                f"{one['bytes_sent'] / rounds / 1e6:.1f}",
                f"{(one['bytes_received'] - one['bytes_of_sums']) / rounds / 1e6:.1f}",
                f"{one['bytes_of_sums'] / 1e6:.0f}",
                f"{pair.memory[str(measure.WORKERS)]:.2f}",
                f"{pair.memory['0']:.2f}",
            ]
            for pair in pairs
            for one in pair.traffic[:1]
        ],
    )
    return f"""# Many machines

Written by `tracer cluster-report`, on {backend.processor()} with {backend.thread_count()} threads.

## Throughput

{measure.WORKERS} workers of one thread against one process of {measure.WORKERS}, on the same two cores, in turns:
{width} x {height} pixels, {measure.SPP} spp, fused; medians of {len(measure.SEEDS)} seeds, least and most. Client and
scheduler run on these cores, too. Values that differ: of picture, counts and standard errors, of all seeds, and by how
much of the value at most. The last two are whole programs, start-up included.

{speed}
## What travels

Statistics come back every round, all sums once. Memory is the most that the client has at any time (16 spp).

{traffic}
## Where it stops scaling

A model with the constants measured above (medians), not a measurement: {PIXELS / 1e6:.1f} million pixels (4K), workers
of one thread, a client that {model.NETWORK / 1e9:.2f} GB a second can reach. A sample takes a thread
{1e6 * constants.sample:.2f} µs; client and scheduler {1e3 * constants.unit:.1f} ms for a unit, and for a pixel
{1e9 * constants.deciding:.0f} ns to decide a round, and {1e9 * constants.developing:.0f} ns to take in its sums and
develop it, once; {constants.round_bytes:.0f} bytes a pixel and round, {constants.sums_bytes:.0f} once.

{scaling(constants)}
![Speed-up by number of workers](scaling.png)
"""


def scaling(constants: Constants) -> str:
    """Return the table of the model."""
    rows = []
    for spp in BUDGETS:
        for count, faster in zip(WORKERS, model.speed_up(constants, PIXELS, spp, WORKERS), strict=True):
            found = model.times(constants, PIXELS, spp, count)
            parts = [f"{getattr(found, name):.0f}" for name in WORDS]
            rows.append([str(spp), str(count), f"{found.total:.0f}", *parts, f"{faster:.0f}", WORDS[found.limit]])
    return markdown_table(["spp", "workers", "seconds", *WORDS.values(), "times as fast", "waits most for"], rows)


def draw(constants: Constants, path: Path) -> None:
    """Draw the speed-up by number of workers."""
    from matplotlib.figure import Figure

    counts = np.unique(np.geomspace(1, 4096, 60).astype(int))
    figure = Figure(figsize=(6, 4.2), layout="constrained")
    axes = figure.subplots()
    axes.loglog(counts, counts, color="0.7", linestyle="--", label="as many times as workers")
    for spp in BUDGETS:
        axes.loglog(counts, model.speed_up(constants, PIXELS, spp, counts.tolist()), label=f"{spp} spp")
    axes.set(xlabel="workers of one thread", ylabel="times as fast as one", title="4K, model with measured constants")
    axes.grid(alpha=0.3)
    axes.legend(frameon=False)
    figure.savefig(path, dpi=150)

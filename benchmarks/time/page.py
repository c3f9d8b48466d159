"""The page of the results: tables of seconds."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from benchmarks import harness
from benchmarks.time import cases
from benchmarks.time.measure import TURNS, Row
from benchmarks.time.scaling import CORES, work_of
from tracer.session.memory import GIB
from tracer.study.tables import markdown_table

PARTS = ("pilot", "drawing", "adding", "statistics", "deciding", "developing", "rest")
"""Parts of a render, as the report names them after ``seconds_``."""


def to_page(numbers: dict[str, Any]) -> str:
    """Return the results as Markdown."""
    all_rows, threads = [row for case in numbers["cases"].values() for row in case], numbers["threads"]
    rows = [Row(**row) for row in all_rows if "parts" in row]
    first = [row for row in all_rows if "opening" in row]
    alone = [row for row in all_rows if "shared" in row]
    predicted = [row for row in all_rows if "work" in row]
    introduction = f"""
{harness.written_by("time")}, on {numbers["machine"]}: median of
{TURNS} pictures in every way, in turn, by seconds of the processor unless a table says otherwise. Scenes whose pictures
would take more than {cases.LONGEST:.0f} seconds have fewer turns or fewer samples."""
    of_scenes = [row for row in rows if row.width == cases.WIDTH and row.threads == threads]
    sections = {
        "The same samples": f"""
Seconds of `mi.render` with `owen_sobol`, then what others take, over that, [least, most] of the turns. Pictures are
{cases.WIDTH} pixels wide.

{same_samples(of_scenes)}""",
        "Parts": f"""
Seconds on the clock of an adaptive picture at 64 spp, {cases.WIDTH} pixels wide, and the part of it that each part
takes.

{parts_table([row for row in of_scenes if row.way == "fused" and row.spp == cases.LARGE_SPP])}""",
        "Sizes": f"""
As in the first table, at {cases.SIZED_SPP} spp and for other sizes.

{same_samples([row for row in rows if row.width != cases.WIDTH and row.spp == cases.SIZED_SPP])}""",
        "Parts by size": f"""
As above, for the largest size at {cases.LARGE_SPP} spp, too. GiB: most memory that the benchmark has taken until then.

{parts_table([row for row in rows if row.width != cases.WIDTH and row.way == "fused" and row.threads == threads])}""",
        "Counted work": f"""
How well the work that is counted (`tracer/sampling/work.py`) predicts the time of drawing: the samples of an adaptive
picture are drawn at once and added to nothing, in turn with as many uniform ones. Units of work of a uniform sample,
nanoseconds of the processor for each; the time of adaptive over that of uniform samples, [least, most] of the turns;
the same as predicted, and predicted over measured.

{predicted_table(predicted)}""",
        "One thread": f"""
As in the first table, with one thread at {cases.LARGE_SPP} spp.

{same_samples([row for row in rows if row.threads != threads])}""",
        "More cores": f"""
A model of adaptive pictures with more cores: the seconds in which one thread works alone stay, all others are shared by
as many cores as there are. Threads share the seconds in which a kernel runs, and those of work on large arrays, as
counted with {threads} threads and the large passes that many cores draw. Part of the time in which one core works
alone:

{cores_table(alone)}""",
        "The first picture of a program": f"""
Seconds on the clock at 16 spp, {cases.WIDTH} pixels wide, without kernels from earlier programs: opening the scene, the
first picture, what compiling took of that, the second picture.

{first_table(first)}""",
    }
    return harness.page("Time", introduction, sections)


def same_samples(rows: Sequence[Row]) -> str:
    """Return the table of the times of all ways over those of ``mi.render`` with ``owen_sobol``."""
    ways_of: dict[tuple, dict[str, Row]] = {}
    for row in rows:
        ways_of.setdefault(row.key, {})[row.way] = row
    lines = []
    for ways in ways_of.values():
        if "owen_sobol" not in ways:
            continue
        base = ways["owen_sobol"]
        lines.append(
            [
                base.scene,
                str(base.shapes),
                f"{base.width} x {base.height}",
                str(base.spp),
                f"{np.median(base.cpu):.2f}",
                *(
                    over(ways[way].cpu, base.cpu) if way in ways else "-"
                    for way in ("multijitter", "independent", "uniform", "fused")
                ),
                over(ways["fused"].cpu, ways["uniform"].cpu),
            ]
        )
    headings = ["scene", "shapes", "size", "spp", "s", "multijitter", "independent", "uniform", "fused"]
    return markdown_table([*headings, "fused / uniform"], lines)


def over(values: Sequence[float], base: Sequence[float]) -> str:
    """Return ratios turn by turn: median, least and most."""
    ratios = np.asarray(values) / np.asarray(base)
    return harness.middle_and_range(float(np.median(ratios)), ratios.tolist())


def parts_table(rows: Sequence[Row]) -> str:
    """Return the table of the parts of pictures."""
    lines = []
    for row in rows:
        wall = float(np.median(row.wall))
        shares = [100 * row.parts.get(f"seconds_{part}", (0.0, 0.0))[0] / wall for part in PARTS]
        lines.append(
            [
                row.scene,
                f"{row.width} x {row.height}",
                str(row.spp),
                f"{wall:.2f}",
                *(f"{share:.1f} %" for share in shares),
                f"{row.memory / GIB:.2f}",
            ]
        )
    return markdown_table(["scene", "size", "spp", "s", *PARTS, "GiB"], lines)


def predicted_table(rows: Sequence[dict[str, Any]]) -> str:
    """Return the table of predicted and measured times."""
    lines = []
    for row in rows:
        seconds, work = row["drawing_seconds"], row["work"]
        predicted = work["fused"] / work["uniform"]
        measured = float(np.median(np.asarray(seconds["fused"]) / np.asarray(seconds["uniform"])))
        lines.append(
            [
                row["scene"],
                f"{row['width']} x {row['height']}",
                str(row["spp"]),
                f"{work['uniform'] / row['samples']:.1f}",
                f"{1e9 * float(np.median(seconds['uniform'])) / work['uniform']:.0f}",
                over(seconds["fused"], seconds["uniform"]),
                f"{predicted:.2f}",
                f"{predicted / measured:.2f}",
            ]
        )
    headings = ["scene", "size", "spp", "units", "ns", "fused / uniform", "predicted", "predicted / measured"]
    return markdown_table(headings, lines)


def cores_table(alone: Sequence[dict[str, Any]]) -> str:
    """Return the table of the model, one line for each picture."""
    lines = []
    for row in alone:
        work = work_of(row["seconds"], row["shared"], row["threads"])
        shares = [f"{100 * work.serial_share(cores):.1f} %" for cores in CORES]
        size, seconds = f"{row['width']} x {row['height']}", [f"{work.serial:.3f}", f"{work.parallel:.2f}"]
        lines.append([row["scene"], size, str(row["spp"]), *seconds, *shares])
    headings = ["scene", "size", "spp", "s alone", "s shared", *(f"{cores} cores" for cores in CORES)]
    return markdown_table(headings, lines)


def first_table(first: Sequence[dict[str, Any]]) -> str:
    """Return the table of first pictures."""
    lines = [
        [row["scene"], row["way"], *(f"{row[name]:.2f}" for name in ("opening", "first", "compiling", "second"))]
        for row in first
    ]
    return markdown_table(["scene", "way", "opening", "first", "compiling", "second"], lines)

"""Time everything, and write the results."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, replace
from functools import partial
from pathlib import Path
from typing import Any

import mitsuba as mi
import numpy as np

from benchmarks import harness
from benchmarks.time.first_call import WAYS as FIRST_WAYS
from benchmarks.time.first_call import first_call
from benchmarks.time.many_shapes import write_scene
from benchmarks.time.measure import TURNS, Case, Row, measure
from benchmarks.time.scaling import CORES, work_of
from benchmarks.time.ways import CRITERIA
from tracer.core import backend
from tracer.errors import SettingsError
from tracer.progress import StepCallback
from tracer.session.memory import GIB
from tracer.study.tables import markdown_table

FILES = (harness.PAGE, harness.NUMBERS)
"""Names of the files that this benchmark writes."""
LONGEST = 60.0
"""Most seconds of a picture that is rendered in all ways, as those with SPPS[0] foretell."""
SHAPES = 1000
"""Number of shapes of the scene that is made for this benchmark."""
MADE = f"{SHAPES} shapes"
"""Name of that scene."""
WIDTH = 256
"""Width of the pictures of all scenes, in pixels."""
SPPS, MORE_SPPS = (16, 64), (4, 256)
"""Samples per pixel of the pictures of all scenes, and further ones for SIZED."""
SIZED = ("spheres_and_rods", "window_interior", MADE)
"""Scenes that are rendered with more numbers of samples, in several sizes, and with one thread."""
SIZES = ((128, 72), (512, 288), (1280, 720), (1920, 1080), (3840, 2160))
"""Sizes of their pictures, (width, height)."""
MOST_SIZES_MADE = 3
"""Number of sizes in which MADE is rendered, from the smallest on: many shapes cost small pictures most."""
SCALED_SIZE = SIZES[3]
"""Size of the picture that tells what more cores would bring, next to that of WIDTH."""
SIZED_SPP, LARGE_SPP = 16, 64
"""Samples per pixel of these pictures, and of the largest ones once more."""
PARTS = ("pilot", "drawing", "adding", "statistics", "deciding", "developing", "rest")
"""Parts of a render, as the report names them after ``seconds_``."""


def report(folder: Path, progress: StepCallback, public: Path, resume: bool = False) -> None:
    """Time everything, and write ``FILES`` after each case. ``resume``: keep cases that were measured before.

    Raises KeyboardInterrupt if ``progress`` stops it; raises SettingsError if another machine has measured before.
    """
    numbers: dict[str, Any] = {"machine": harness.machine(), "threads": backend.thread_count(), "cases": {}}
    if resume:
        numbers = measured_before(folder / harness.NUMBERS, harness.machine())
    measured = numbers["cases"]
    with tempfile.TemporaryDirectory() as made:
        paths = all_scenes(public, Path(made) / "scene.xml")
        steps = {f"{name}: first picture of a program": partial(first_rows, name, paths[name]) for name in SIZED}
        steps |= {str(case): partial(case_rows, case, measured) for case in all_cases(paths)}
        announce = harness.StepCounter(progress, len(steps))
        for step, rows_of in steps.items():
            announce(step)
            if step not in measured:
                measured[step] = rows_of()
                harness.write(folder, numbers, to_page(numbers))


def measured_before(path: Path, machine: str) -> dict[str, Any]:
    """Return the numbers that a benchmark on this machine has left. Raises SettingsError if they are another's."""
    try:
        numbers: dict[str, Any] = json.loads(path.read_text())
        measured_on = numbers["machine"]
    except (ValueError, KeyError, TypeError):
        raise SettingsError(f"'{path}' is not what this benchmark has left; measure it anew.") from None
    if measured_on != machine:
        raise SettingsError(f"'{path}' was measured on {measured_on}, not on {machine}; measure it anew.")
    return numbers


def all_scenes(public: Path, made: Path) -> dict[str, Path]:
    """Return the files of the bundled scenes, of those in a folder, and of one that is written to ``made``."""
    write_scene(made, SHAPES)
    paths = {path.stem: path for path in harness.bundled_scenes()}
    paths |= {path.parent.name: path for path in sorted(public.glob("*/scene.xml"))}
    return {**paths, MADE: made}


def first_rows(name: str, path: Path) -> list[dict[str, Any]]:
    """Return the seconds of the first picture of a program, for each way."""
    return [{"scene": name, "way": way, **first_call(path, WIDTH, 16, way)} for way in FIRST_WAYS]


def case_rows(case: Case, measured: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Return the rows of a case as plain values; none if its pictures would take longer than LONGEST.

    ``measured``: the rows of cases so far, by the names of these.
    """
    with_fewer = measured.get(str(replace(case, spp=SPPS[0])), ())
    seconds = [min(row["wall"]) * case.spp / SPPS[0] for row in with_fewer]
    in_all_ways = len(seconds) == len(case.ways)
    return [] if in_all_ways and max(seconds) > LONGEST else [asdict(row) for row in measure(case)]


def all_cases(paths: dict[str, Path]) -> Iterable[Case]:
    """Yield what is rendered of the scenes with these names."""
    threads = backend.thread_count()
    for name, path in paths.items():
        for spp in (*SPPS, *(MORE_SPPS if name in SIZED else ())):
            yield Case(name, path, WIDTH, spp, threads)
    one_thread = mi.variant().startswith("llvm_")
    for name in SIZED:
        for size in SIZES[:MOST_SIZES_MADE] if name == MADE else SIZES:
            yield Case(name, paths[name], size, SIZED_SPP, threads)
        if one_thread:
            yield Case(name, paths[name], WIDTH, LARGE_SPP, 1, ("owen_sobol", *CRITERIA))
    yield Case(SIZED[0], paths[SIZED[0]], SIZES[-1], LARGE_SPP, threads)
    for name in SIZED[:2]:
        yield Case(name, paths[name], SCALED_SIZE, LARGE_SPP, threads)
    if one_thread:
        yield Case(SIZED[0], paths[SIZED[0]], SCALED_SIZE, LARGE_SPP, 1)


def to_page(numbers: dict[str, Any]) -> str:
    """Return the results as Markdown."""
    cases, threads = numbers["cases"].values(), numbers["threads"]
    rows = [Row(**row) for case in cases for row in case if "parts" in row]
    first = [row for case in cases for row in case if "parts" not in row]
    introduction = f"""
{harness.written_by("time")}, on {numbers["machine"]}: median of
{TURNS} pictures in every way, in turn, by seconds of the processor unless a table says otherwise. Scenes whose pictures
would take more than {LONGEST:.0f} seconds have fewer turns or fewer samples."""
    of_scenes = [row for row in rows if row.width == WIDTH and row.threads == threads]
    adaptive = [row for row in rows if row.way == "fused"]
    sections = {
        "The same samples": f"""
Seconds of `mi.render` with `owen_sobol`, then what others take, over that, [least, most] of the turns. Pictures are
{WIDTH} pixels wide.

{same_samples(of_scenes)}""",
        "Parts": f"""
Seconds on the clock of an adaptive picture at 64 spp, {WIDTH} pixels wide, and the part of it that each part takes.

{parts_table([row for row in of_scenes if row.way == "fused" and row.spp == LARGE_SPP])}""",
        "Sizes": f"""
As in the first table, at {SIZED_SPP} spp and for other sizes.

{same_samples([row for row in rows if row.width != WIDTH and row.spp == SIZED_SPP])}""",
        "Parts by size": f"""
As above, for the two largest sizes at {LARGE_SPP} spp, too. GiB: most memory that the benchmark has taken until then.

{parts_table([row for row in rows if row.width != WIDTH and row.way == "fused" and row.threads == threads])}""",
        "One thread": f"""
As in the first table, with one thread at {LARGE_SPP} spp.

{same_samples([row for row in rows if row.threads != threads])}""",
        "More cores": f"""
A model of adaptive pictures from their times with one and with {threads} threads: the seconds in which one thread works
alone stay, all others are shared by as many cores as there are. Part of the time in which one core works alone:

{cores_table(adaptive, threads)}""",
        "The first picture of a program": f"""
Seconds on the clock at 16 spp, {WIDTH} pixels wide, without kernels from earlier programs: opening the scene, the first
picture, what compiling took of that, the second picture.

{first_table(first)}""",
    }
    return harness.page("Time", introduction, sections)


def same_samples(rows: Sequence[Row]) -> str:
    """Return the table of the times of all ways over those of ``mi.render`` with ``owen_sobol``."""
    cases: dict[tuple, dict[str, Row]] = {}
    for row in rows:
        cases.setdefault(row.key, {})[row.way] = row
    lines = []
    for ways in cases.values():
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


def cores_table(rows: Sequence[Row], threads: int) -> str:
    """Return the table of the model, for all pictures that were rendered with one thread, too."""
    of_one = {row.key: row for row in rows if row.threads == 1}
    lines = []
    for row in rows:
        if row.threads != threads or row.key not in of_one:
            continue
        work = work_of(row.parts, of_one[row.key].parts, threads)
        shares = [f"{100 * work.serial_share(cores):.1f} %" for cores in CORES]
        size, seconds = f"{row.width} x {row.height}", [f"{work.serial:.3f}", f"{work.parallel:.2f}"]
        lines.append([row.scene, size, str(row.spp), *seconds, *shares])
    headings = ["scene", "size", "spp", "s alone", "s shared", *(f"{cores} cores" for cores in CORES)]
    return markdown_table(headings, lines)


def first_table(first: Sequence[dict[str, Any]]) -> str:
    """Return the table of first pictures."""
    lines = [
        [row["scene"], row["way"], *(f"{row[name]:.2f}" for name in ("opening", "first", "compiling", "second"))]
        for row in first
    ]
    return markdown_table(["scene", "way", "opening", "first", "compiling", "second"], lines)

"""Time everything, and write the results."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Mapping
from dataclasses import asdict, replace
from functools import partial
from pathlib import Path
from typing import Any

from benchmarks import harness
from benchmarks.time import cases
from benchmarks.time.alone import alone_rows
from benchmarks.time.first_call import WAYS as FIRST_WAYS
from benchmarks.time.first_call import first_call
from benchmarks.time.measure import Case, measure
from benchmarks.time.page import to_page
from benchmarks.time.predicted import predicted_rows
from tracer.core import backend
from tracer.errors import SettingsError
from tracer.progress import StepCallback

FILES = (harness.PAGE, harness.NUMBERS)
"""Names of the files that this benchmark writes."""


def report(folder: Path, progress: StepCallback, public: Path, resume: bool = False) -> None:
    """Time everything, and write ``FILES`` after each case. ``resume``: keep cases that were measured before.

    Raises KeyboardInterrupt if ``progress`` stops it; raises SettingsError if another machine has measured before.
    """
    numbers: dict[str, Any] = {"machine": harness.machine(), "threads": backend.thread_count(), "cases": {}}
    if resume:
        numbers = measured_before(folder / harness.NUMBERS, harness.machine())
    measured = numbers["cases"]
    with tempfile.TemporaryDirectory() as made:
        paths = cases.all_scenes(public, Path(made) / "scene.xml")
        steps = {f"{name}: first picture of a program": partial(first_rows, name, paths[name]) for name in cases.SIZED}
        steps |= {str(case): partial(case_rows, case, measured) for case in cases.all_cases(paths)}
        for name, path in paths.items():
            if name not in cases.DEAREST:
                steps[f"{name}: counted work"] = partial(predicted_rows, name, path, cases.WIDTH, cases.LARGE_SPP)
        for name in cases.SIZED[:2]:
            for spp in cases.SCALED_SPPS:
                step = f"{name}, {cases.SCALED_SIZE[0]} x {cases.SCALED_SIZE[1]}, {spp} spp: what threads share"
                steps[step] = partial(alone_rows, name, paths[name], cases.SCALED_SIZE, spp)
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


def first_rows(name: str, path: Path) -> list[dict[str, Any]]:
    """Return the seconds of the first picture of a program, for each way."""
    return [{"scene": name, "way": way, **first_call(path, cases.WIDTH, 16, way)} for way in FIRST_WAYS]


def case_rows(case: Case, measured: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Return the rows of a case as plain values; none if its pictures would take longer than LONGEST.

    ``measured``: the rows of cases so far, by the names of these.
    """
    with_fewer = measured.get(str(replace(case, spp=cases.SPPS[0])), ())
    seconds = [min(row["wall"]) * case.spp / cases.SPPS[0] for row in with_fewer]
    in_all_ways = len(seconds) == len(case.ways)
    return [] if in_all_ways and max(seconds) > cases.LONGEST else [asdict(row) for row in measure(case)]

"""Write the results of a study into its folder: ``results.json``, ``results.csv``, ``results.md``, ``overview.svg``."""

from __future__ import annotations

import csv
import io
import json
import os
import sys
from dataclasses import asdict
from pathlib import Path
from typing import Any

import mitsuba as mi
import numpy as np

from tracer.core.version import version
from tracer.io import atomic
from tracer.study.overview_file import OVERVIEW, write_overview
from tracer.study.records import SCORES, Measurement
from tracer.study.results import Results
from tracer.study.tables import markdown

PAGE = "index.html"
"""File name of the page of a study."""
RESULT_FILES = ("results.json", "results.csv", "results.md", OVERVIEW, PAGE)
"""Names of the files of results in the folder of a study."""
SCHEMA = 1
"""Version of the form of ``results.json``, changed when programs that read it would have to change."""


def write_results(output: Path, results: Results) -> None:
    """Write all files of results but the page."""
    record = {**conditions(results), **numbers(results)}
    atomic.write_text(output / "results.json", json.dumps(finite(record), indent=1, allow_nan=False) + "\n")
    atomic.write_text(output / "results.csv", as_csv(results))
    atomic.write_text(output / "results.md", f"{head(results)}\n\n{markdown(results)}")
    write_overview(output, record)


def conditions(results: Results) -> dict[str, Any]:
    """Return the command, the versions, and the machines on which the pictures were made."""
    # Absolute paths of this machine mean nothing on another.
    words = [os.path.relpath(word) if os.path.isabs(word) else word for word in sys.argv[1:]]
    command = " ".join(["tracer", *words])
    return {
        "schema": SCHEMA,
        "version": version(),
        "mitsuba": mi.__version__,
        "variant": mi.variant(),
        "command": command,
        "machines": sorted({measurement.took.machine for measurement in results.measurements}),
    }


def head(results: Results) -> str:
    """Return the head of ``results.md``: a title, what the study is about, the command, the machines and the seeds."""
    made = conditions(results)
    plan = results.plan
    last = plan.first_seed + plan.seeds - 1
    seeds = f"seed {last}" if plan.seeds == 1 else f"seeds {plan.first_seed} to {last}"
    title = "\n\n".join([f"# Study: {plan.name}", *([plan.about] if plan.about else [])])
    return f"{title}\n\n`{made['command']}`, {'; '.join(made['machines'])}, {seeds}"


def numbers(results: Results) -> dict[str, Any]:
    """Return the plan and everything that was measured, as values for JSON."""
    rows, means = results.tables()
    return {
        "study": results.plan.model_dump(exclude={"folder"}),
        "baseline": results.plan.compared_with,
        "finished": results.finished,
        "scenes": [asdict(facts) for facts in results.scenes],
        "means": [asdict(mean) for mean in means],
        "rows": [asdict(row) for row in rows],
        "cells": [flat(measurement) for measurement in results.measurements],
        "failures": [asdict(failure) for failure in results.failures],
    }


def flat(measurement: Measurement) -> dict[str, Any]:
    """Return a measurement as a dictionary without nesting."""
    cell, took = measurement.cell, measurement.took
    return {
        "scene": cell.scene,
        "method": cell.method,
        "budget": cell.budget.label,
        "seed": cell.seed,
        "spp": took.spp,
        "samples": took.samples,
        "seconds": took.seconds,
        "seconds_drawing": took.seconds_drawing,
        "run": took.run,
        "machine": took.machine,
        **{name: getattr(measurement.scores, name) for name in SCORES},
        "too_close": measurement.too_close,
        **measurement.own,
    }


def as_csv(results: Results) -> str:
    """Return CSV with a line per cell, below a line of column names."""
    lines = [flat(measurement) for measurement in results.measurements]
    text = io.StringIO()
    if lines:
        writer = csv.DictWriter(text, list(lines[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows(lines)
    return text.getvalue()


def finite(value: Any) -> Any:
    """Return nested lists and dictionaries with None in place of infinities and NaN, which JSON does not have."""
    if isinstance(value, dict):
        return {name: finite(entry) for name, entry in value.items()}
    if isinstance(value, list | tuple):
        return [finite(entry) for entry in value]
    return None if isinstance(value, float) and not np.isfinite(value) else value

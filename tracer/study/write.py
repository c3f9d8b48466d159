"""What a study leaves in its folder: ``results.json``, ``results.csv``, ``results.md`` and ``index.html``."""

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

from tracer.io import atomic
from tracer.session.output import version
from tracer.study.records import SCORES, Measurement
from tracer.study.results import Results
from tracer.study.tables import markdown

PAGE = "index.html"
RESULT_FILES = ("results.json", "results.csv", "results.md", PAGE)
SCHEMA = 1
"""Changed when a reader of ``results.json`` would have to change."""


def write_results(output: Path, results: Results) -> None:
    """Write all files but the page."""
    record = {**conditions(results), **numbers(results)}
    atomic.write_text(output / "results.json", json.dumps(finite(record), indent=1, allow_nan=False) + "\n")
    atomic.write_text(output / "results.csv", as_csv(results))
    atomic.write_text(output / "results.md", f"{head(results)}\n\n{markdown(results)}")


def conditions(results: Results) -> dict[str, Any]:
    """Return command, versions and the machines that the times are of."""
    # Where a folder lies on one machine is of no use on another.
    words = [os.path.relpath(word) if os.path.isabs(word) else word for word in sys.argv[1:]]
    command = " ".join(["tracer", *words])
    return {
        "schema": SCHEMA,
        "version": version(),
        "mitsuba": mi.__version__,
        "variant": mi.variant(),
        "command": command,
        "machines": sorted({one.took.machine for one in results.measurements}),
    }


def head(results: Results) -> str:
    """Return one line that says what made the numbers."""
    made = conditions(results)
    plan = results.plan
    last = plan.first_seed + plan.seeds - 1
    seeds = f"seed {last}" if plan.seeds == 1 else f"seeds {plan.first_seed} to {last}"
    return f"`{made['command']}`, {'; '.join(made['machines'])}, {seeds}"


def numbers(results: Results) -> dict[str, Any]:
    """Return everything that was measured as plain values."""
    rows, means = results.tables()
    return {
        "study": results.plan.model_dump(exclude={"folder"}),
        "baseline": results.plan.compared_with,
        "finished": results.finished,
        "scenes": [asdict(facts) for facts in results.scenes],
        "means": [asdict(mean) for mean in means],
        "rows": [asdict(row) for row in rows],
        "cells": [flat(one) for one in results.measurements],
        "failures": [asdict(one) for one in results.failures],
    }


def flat(one: Measurement) -> dict[str, Any]:
    """Return a measurement as one level of names and values."""
    cell, took = one.cell, one.took
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
        **{name: getattr(one.scores, name) for name in SCORES},
        "too_close": one.too_close,
    }


def as_csv(results: Results) -> str:
    """Return a line a cell."""
    lines = [flat(one) for one in results.measurements]
    text = io.StringIO()
    if lines:
        writer = csv.DictWriter(text, list(lines[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows(lines)
    return text.getvalue()


def finite(value: Any) -> Any:
    """Return nested lists and dictionaries with None for numbers that JSON does not know."""
    if isinstance(value, dict):
        return {name: finite(entry) for name, entry in value.items()}
    if isinstance(value, list | tuple):
        return [finite(entry) for entry in value]
    return None if isinstance(value, float) and not np.isfinite(value) else value

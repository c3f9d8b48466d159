"""What a study leaves behind: numbers as JSON with what made them, and a table as Markdown."""

from __future__ import annotations

import json
import platform
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from tracer import backend, files
from tracer.metadata import version


def write_record(folder: Path, name: str, numbers: dict[str, Any], text: str, conditions: str) -> None:
    """Write ``NAME.json`` with ``numbers`` and ``NAME.md`` with ``text``, both headed by command, version and machine.

    ``conditions`` says in the head of the text what else was the same for all numbers, seeds for instance.
    """
    command = " ".join(["tracer", *sys.argv[1:]])
    machine = {"processor": backend.processor(), "threads": backend.thread_count(), "system": platform.system()}
    record = {"version": version(), "command": command, "machine": machine, **numbers}
    files.write_text(folder / f"{name}.json", json.dumps(finite(record), indent=1, allow_nan=False) + "\n")
    head = f"`{command}`, {machine['processor']}, {machine['threads']} threads, {conditions}\n\n"
    files.write_text(folder / f"{name}.md", head + text)


def record_files(name: str) -> tuple[str, str]:
    """Return the names of the files that ``write_record`` writes."""
    return f"{name}.json", f"{name}.md"


def finite(value: Any) -> Any:
    """Return nested lists and dictionaries with None for numbers that JSON does not know."""
    if isinstance(value, dict):
        return {name: finite(entry) for name, entry in value.items()}
    if isinstance(value, list):
        return [finite(entry) for entry in value]
    return None if isinstance(value, float) and not np.isfinite(value) else value


def markdown_table(headings: Sequence[str], lines: Sequence[Sequence[str]]) -> str:
    """Return a Markdown table."""
    head, *rows = ("| " + " | ".join(cells) + " |" for cells in (headings, *lines))
    return "\n".join([head, "|" + "---|" * len(headings), *rows]) + "\n"

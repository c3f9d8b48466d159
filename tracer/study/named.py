"""Studies with a name: what is measured of a scene, and how it is shown."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from tracer import backend, files
from tracer.errors import SettingsError
from tracer.settings import known, make_settings
from tracer.study import overhead, samplers
from tracer.study.record import record_files, write_record
from tracer.study.run import StepCallback, check_names, check_scenes


@dataclass(frozen=True)
class Study:
    """One study. ``measure`` takes (scene, size, spps, repetitions, progress) and returns measurements."""

    measure: Callable[[Path, int, Sequence[int], int, StepCallback | None], list[Any]]
    markdown: Callable[[Sequence[Any]], str]
    unit: str
    """What one measurement is, in the plural: its name in the file of numbers."""
    size: int
    """Width in pixels unless another is asked for."""
    several_spp: bool
    conditions: str
    """What the head of the table says, with {size}, {spp} and {repetitions} to be filled in."""


STUDIES = {
    "overhead": Study(
        overhead.measure,
        overhead.markdown,
        "timings",
        size=512,
        several_spp=False,
        conditions="{size} x {size} pixels, {spp} spp, {repetitions} repetitions, means in seconds",
    ),
    "samplers": Study(
        samplers.measure,
        samplers.markdown,
        "errors",
        size=256,
        several_spp=True,
        conditions="{size} pixels wide, {repetitions} seeds from 0",
    ),
}


def find_study(name: str, spps: Sequence[int]) -> Study:
    """Return a study by name. Raises SettingsError if there is none, or it cannot be made at these budgets."""
    try:
        study = STUDIES[known(name, "study", list(STUDIES))]
    except ValueError as error:
        raise SettingsError(f"{error}.") from None
    for spp in spps:
        make_settings(spp=spp)
    if len(spps) > 1 and not study.several_spp:
        raise SettingsError(f"The study '{name}' takes one --spp (was {', '.join(map(str, spps))}).")
    return study


def prepare(name: str, scenes: Sequence[Path], size: int | None, output: Path, overwrite: bool) -> None:
    """Raise an error for a scene or folder that cannot be used, before anything is rendered."""
    backend.activate()
    check_names(scenes)
    check_scenes(scenes, size)
    files.prepare_folder(output, overwrite, record_files(name))


def run_study(
    name: str,
    scenes: Sequence[Path],
    output: Path,
    spps: Sequence[int],
    repetitions: int,
    size: int | None = None,
    progress: StepCallback | None = None,
) -> str:
    """Measure every scene and return the table; ``NAME.json`` and ``NAME.md`` are written after each.

    Raises KeyboardInterrupt if ``progress`` stops it.
    """
    study = find_study(name, spps)
    size = size or study.size
    conditions = study.conditions.format(size=size, spp=", ".join(map(str, spps)), repetitions=repetitions)
    measured: list[Any] = []
    table = ""
    for scene in scenes:
        measured += study.measure(scene, size, spps, repetitions, progress)
        table = study.markdown(measured)
        numbers = {study.unit: [asdict(one) for one in measured]}
        write_record(output, name, numbers, table, conditions)
    return table

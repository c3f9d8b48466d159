"""Command ``study``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from tracer.cli import options
from tracer.errors import SettingsError, StudyError

if TYPE_CHECKING:
    from tracer.study.plan import Plan
    from tracer.study.results import Results


def study(
    plan: Annotated[
        str,
        typer.Argument(
            help="TOML file, or smoke, standard, public, rules, objectives, denoise, guiding, time, long, wide or "
            "volumes.",
            show_default=False,
        ),
    ],
    output: Annotated[Path, typer.Option("--output", "-o", help="Folder for page, tables and numbers.")],
    folder: Annotated[
        Path | None, typer.Argument(help="Where its scenes are. (beside the TOML file)", show_default=False)
    ] = None,
    workers: options.Workers = None,
    scheduler: options.Scheduler = None,
    overwrite: Annotated[
        bool, typer.Option("--overwrite", help="Render pictures again that are there, or replace another study.")
    ] = False,
    quiet: options.Quiet = False,
) -> None:
    """Measure scenes x methods x budgets x seeds against references, and write a page that shows it.

    If it is stopped and started again, it goes on where it was; a changed plan renders only cells that are new.

    Example: tracer study smoke -o results
    """
    from tracer.study.bundled import find_plan

    if workers is not None and scheduler is not None:
        raise SettingsError("Name workers or a scheduler, not both.")
    measure(find_plan(plan, folder), output, overwrite, quiet, workers or scheduler)


def measure(plan: Plan, output: Path, overwrite: bool, quiet: bool, cluster: int | str | None = None) -> Results:
    """Run a plan, showing progress, print its tables, and return them. Raises StudyError if any cell failed."""
    from tracer.cli.progress import steps
    from tracer.cli.show import study_tables

    with steps(quiet) as progress:
        progress.begin("Starting Mitsuba")
        from tracer.study.run import run_study

        progress.begin("Opening the scenes")
        results = run_study(plan, output, progress, overwrite, cluster)
    if not quiet:
        study_tables(results)
    if results.failures:
        first = results.failures[0]
        raise StudyError(
            f"{len(results.failures)} of {len(results.failures) + len(results.measurements)} cells failed, first "
            f"{first.method} on {first.scene}: {first.message.rstrip('.')}; run the same command to try them again."
        )
    return results

"""Progress bars that Ctrl-C stops without loss."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn

from tracer.cli.signals import stopping
from tracer.progress import Progress as Passed
from tracer.progress import ProgressCallback
from tracer.study.run import StepCallback


@contextmanager
def watch(title: str, quiet: bool = False) -> Iterator[ProgressCallback]:
    """Show a bar with samples done and time left; yield the callback for ``tracer.render`` that moves it.

    After a first Ctrl-C the callback returns False, so that the render ends with what there is; a second one kills.
    """
    with steps(quiet) as step:

        def passed(progress: Passed) -> bool | None:
            text = f"{title}: {progress.done / 1e6:.1f} of {progress.total / 1e6:.1f} M samples"
            if progress.converged is not None:
                text += f", {100 * progress.converged:.0f} % converged"
            return step(text, progress.done, progress.total)

        yield passed


@contextmanager
def steps(quiet: bool = False) -> Iterator[StepCallback]:
    """Show a bar for work in named steps; yield the callback that moves it. Ctrl-C stops as in ``watch``."""
    columns = (TextColumn("{task.description}"), BarColumn(), TaskProgressColumn(), TimeRemainingColumn())
    console = Console(stderr=True)
    bar = Progress(*columns, console=console, disable=quiet or not console.is_terminal, transient=True)
    task = bar.add_task("", total=None)

    with stopping() as stopped:

        def step(description: str, done: int, total: int) -> bool:
            if not bar.live.is_started:
                bar.start()  # not before: a mistake found while loading is then the only thing printed
            if done < bar.tasks[0].completed:
                bar.reset(task)
            bar.update(task, description=description, completed=done, total=total)
            return not stopped()

        try:
            yield step
        finally:
            if bar.live.is_started:
                bar.stop()

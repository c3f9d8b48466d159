"""Progress bars that Ctrl-C stops without loss."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from rich.console import Console
from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn

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
            return step(
                f"{title}: {progress.done / 1e6:.1f} of {progress.total / 1e6:.1f} M samples",
                progress.done,
                progress.total,
            )

        yield passed


@contextmanager
def steps(quiet: bool = False) -> Iterator[StepCallback]:
    """Show a bar for work in named steps; yield the callback that moves it. Ctrl-C stops as in ``watch``."""
    columns = (TextColumn("{task.description}"), BarColumn(), TaskProgressColumn(), TimeRemainingColumn())
    bar = Progress(*columns, console=Console(stderr=True), disable=quiet, transient=True)
    task = bar.add_task("", total=None)

    with stop_on_interrupt() as stopped:

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


@contextmanager
def stop_on_interrupt() -> Iterator[Callable[[], bool]]:
    """Turn the first Ctrl-C into a flag, which the yielded function returns, and the second into KeyboardInterrupt."""
    interrupted = False

    def interrupt(number: int, frame: Any) -> None:
        nonlocal interrupted
        interrupted = True
        signal.signal(signal.SIGINT, signal.default_int_handler)

    previous = signal.signal(signal.SIGINT, interrupt)
    try:
        yield lambda: interrupted
    finally:
        signal.signal(signal.SIGINT, previous)

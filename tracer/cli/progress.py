"""Progress bars for work that Ctrl-C stops without loss."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from datetime import timedelta

from rich.console import Console
from rich.progress import BarColumn, Progress, Task, TaskProgressColumn, TextColumn, TimeRemainingColumn
from rich.text import Text

from tracer.cli.signals import stopping
from tracer.progress import Progress as Passed

SECONDS_BETWEEN_LINES = 30.0
"""Seconds between two lines that say how far the work is, where there is no terminal for a bar."""


class TimeLeft(TimeRemainingColumn):
    """Column with the time left: as the work itself estimates it, or else as the pace of the bar suggests."""

    def render(self, task: Task) -> Text:
        """Return the time left, in the form 0:01:23."""
        seconds_left = task.fields.get("left")
        return super().render(task) if seconds_left is None else Text(str(timedelta(seconds=round(seconds_left))))


class Steps:
    """A progress bar for work in named steps. A call moves the bar, and returns False once the work should stop."""

    def __init__(self, quiet: bool, stopped: Callable[[], bool]) -> None:
        columns = (TextColumn("{task.description}"), BarColumn(), TaskProgressColumn(), TimeLeft())
        console = Console(stderr=True)
        self.bar = Progress(*columns, console=console, disable=quiet or not console.is_terminal, transient=True)
        self.task = self.bar.add_task("", total=None)
        self.stopped = stopped
        self.writes_lines, self.last_line = not quiet and not console.is_terminal, time.monotonic()

    def __call__(self, description: str, done: float, total: float, left: float | None = None) -> bool:
        """Show that ``done`` of ``total`` steps are done; ``left``: seconds to the end, if the work estimates them."""
        self.bar.start()
        if self.writes_lines and time.monotonic() - self.last_line > SECONDS_BETWEEN_LINES:
            self.last_line = time.monotonic()
            sys.stderr.write(f"{description}: {done / total if total else 0:.0%}\n")
        if done < self.bar.tasks[0].completed:
            self.bar.reset(self.task)
        self.bar.update(self.task, description=description, completed=done, total=total, left=left)
        return not self.stopped()

    def begin(self, description: str) -> None:
        """Show that something has begun whose end is not known; the bar moves to and fro."""
        self.bar.remove_task(self.task)
        self.task = self.bar.add_task(description, total=None)
        self.bar.start()

    def clear(self) -> None:
        """Remove the bar, so that something can be printed; the next step shows the bar again."""
        if self.bar.live.is_started:
            self.bar.stop()


class Watch:
    """A progress bar for a rendering: a progress callback for ``tracer.render``.

    ``stage`` shows what is being done while no samples are drawn.
    """

    def __init__(self, title: str, step: Steps) -> None:
        self.title, self.step, self.stage, self.clear = title, step, step.begin, step.clear

    def __call__(self, progress: Passed) -> bool:
        """Show how far the rendering is; return False once it should stop."""
        return self.step(f"{self.title}: {progress.in_words()}", progress.fraction, 1.0, progress.remaining)


@contextmanager
def watch(title: str, quiet: bool = False) -> Iterator[Watch]:
    """Show a bar with samples done and time left; yield the callback for ``tracer.render`` that moves it.

    After a first Ctrl-C the callback returns False, so that the rendering ends and keeps its samples. A second Ctrl-C
    stops the program at once.
    """
    with steps(quiet) as step:
        yield Watch(title, step)


@contextmanager
def steps(quiet: bool = False) -> Iterator[Steps]:
    """Show a bar for work in named steps; yield the callback that moves it. Ctrl-C stops as in ``watch``."""
    with stopping() as stopped:
        step = Steps(quiet, stopped)
        try:
            yield step
        finally:
            step.clear()

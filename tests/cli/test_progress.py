"""Bars on a terminal: where they stand, what they say, and that they do not go back."""

import io

import pytest
from rich.console import Console

from tracer.cli.progress import Steps, Watch
from tracer.progress import Progress


@pytest.fixture
def bar(monkeypatch):
    """Return a bar on a terminal that is a string, and that string."""
    terminal = io.StringIO()
    console = Console(file=terminal, force_terminal=True, width=120)
    monkeypatch.setattr("tracer.cli.progress.Console", lambda **_: console)
    return Steps(False, lambda: False), terminal


def passes(*fractions):
    return [
        Progress(round(6144 * fraction), 12288, 1.0, remaining=83.4, converged=0.5, fraction=fraction, is_open=True)
        for fraction in fractions
    ]


def test_a_render_moves_its_bar_by_the_fraction_and_shows_its_own_time_left(bar):
    step, terminal = bar
    watch, stands = Watch("Rendering", step), []
    for now in passes(0.1, 0.4, 0.4, 0.9, 1.0):
        watch(now)
        stands.append(step.bar.tasks[0].percentage)
    step.bar.refresh()
    step.clear()
    assert stands == pytest.approx([10, 40, 40, 90, 100])
    assert "Rendering: 6.14 k samples, 50 % converged" in terminal.getvalue()
    assert "0:01:23" in terminal.getvalue()


def test_what_comes_before_and_after_the_samples_is_said(bar):
    step, terminal = bar
    watch = Watch("Rendering", step)
    watch.stage("Opening the scene")
    assert step.bar.tasks[0].total is None
    watch(passes(1.0)[0])
    watch.stage("Writing")
    assert (len(step.bar.tasks), step.bar.tasks[0].percentage) == (1, 0)
    step.clear()
    assert "Opening the scene" in terminal.getvalue()
    assert "Writing" in terminal.getvalue()


def test_the_next_picture_begins_anew(bar):
    step, _ = bar
    watch = Watch("Rendering", step)
    for now in passes(0.5, 1.0):
        watch(now)
    step.clear()
    watch(passes(0.1)[0])
    assert step.bar.tasks[0].percentage == pytest.approx(10)
    step.clear()


def test_without_a_terminal_there_is_a_line_now_and_then(monkeypatch, capsys):
    seconds = [0.0]
    monkeypatch.setattr("tracer.cli.progress.time.monotonic", lambda: seconds[0])
    monkeypatch.setattr("tracer.cli.progress.Console", lambda **_: Console(file=io.StringIO(), force_terminal=False))
    step = Steps(False, lambda: False)
    for now in (1.0, 29.0, 31.0, 45.0, 62.0):
        seconds[0] = now
        step("thin_rods", now, 62.0)
    assert capsys.readouterr().err == "thin_rods: 50%\nthin_rods: 100%\n"

"""How a message names an option: as the reader writes it, who is at a command line or calls from Python."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Any

Tell = Callable[[str], Any]
"""Tells a person something in a sentence."""


def silent(sentence: str) -> None:
    """Tell nobody."""


on_command_line: ContextVar[bool] = ContextVar("on_command_line", default=False)


@contextmanager
def speaking_to_command_line() -> Iterator[None]:
    """Let messages name options of the command line for as long as the block runs."""
    token = on_command_line.set(True)
    try:
        yield
    finally:
        on_command_line.reset(token)


def option(name: str, value: str = "") -> str:
    """Return how an option is written: "--checkpoint-every 4" at a command line, "checkpoint_every=4" in Python.

    ``name`` is that of Python's keyword. Without a ``value`` it is a switch, which is on.
    """
    if on_command_line.get():
        return f"--{name.replace('_', '-')} {value}".rstrip()
    return f"{name}={value or True}"

"""How a message names an option: as its reader writes it, at a command line or in Python."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Any

Tell = Callable[[str], Any]
"""Function that tells a person one sentence."""


def silent(sentence: str) -> None:
    """Take a sentence and tell nobody."""


on_command_line: ContextVar[bool] = ContextVar("on_command_line", default=False)
"""Whether messages are read at a command line, rather than by a caller from Python."""


@contextmanager
def speaking_to_command_line() -> Iterator[None]:
    """Let messages name options as a command line has them for as long as the block runs."""
    token = on_command_line.set(True)
    try:
        yield
    finally:
        on_command_line.reset(token)


def option(name: str, value: str = "") -> str:
    """Return how an option is written: "--checkpoint-every 4" at a command line, "checkpoint_every=4" in Python.

    ``name``: Python's keyword. Without a ``value`` the option is a switch that is turned on.
    """
    if on_command_line.get():
        return f"--{name.replace('_', '-')} {value}".rstrip()
    return f"{name}={value or True}"

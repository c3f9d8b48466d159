"""Mistakes in a Python file of a person's own, as one sentence."""

from __future__ import annotations

import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from tracer.errors import SettingsError, TracerError


@contextmanager
def explaining(path: Path) -> Iterator[None]:
    """Turn whatever the code of a file raises within the block into a SettingsError with file and line."""
    try:
        yield
    except TracerError:
        raise
    except (Exception, SystemExit) as error:  # the file is a person's program and may raise anything
        line = line_of(error, path.resolve())
        where = f"'{path}'" if line is None else f"'{path}', line {line}"
        reason = error.msg if isinstance(error, SyntaxError) else str(error)
        raise SettingsError(" ".join(f"{where}: {type(error).__name__}: {reason}".split()).rstrip(".") + ".") from error


def line_of(error: BaseException, place: Path) -> int | None:
    """Return the line of a file in which an error arose, the innermost if several; None if it is not known."""
    if isinstance(error, SyntaxError) and error.filename == str(place):
        return error.lineno
    lines = [frame.lineno for frame in traceback.extract_tb(error.__traceback__) if frame.filename == str(place)]
    return lines[-1] if lines else None

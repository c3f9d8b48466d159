"""Mistakes in a Python file of a person's own, as one sentence."""

from __future__ import annotations

import importlib.util
import sys
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType

from tracer.core.threads import for_files
from tracer.errors import SettingsError, TracerError

FILE_ENDING = ".py"
"""End of the name of a Python file."""


def run_file(path: Path, kind: str) -> ModuleType:
    """Run a Python file, and return its module; ``kind`` tells it from other files of that name.

    Raises SettingsError, with the line, for a file that does not exist or does not run.
    """
    if not path.is_file():
        raise SettingsError(f"There is no file '{path}'.")
    specification = importlib.util.spec_from_file_location(f"tracer_{kind}_{path.stem}", path.resolve())
    if specification is None or specification.loader is None:
        raise SettingsError(f"'{path}' is no Python file; its name must end in {FILE_ENDING}.")
    module = importlib.util.module_from_spec(specification)
    sys.modules[specification.name] = module  # where dataclasses look for it
    with for_files(), explaining(path):
        specification.loader.exec_module(module)
    return module


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

"""Write a picture somewhere else when it cannot be written to its own place, as on a full disk."""

from __future__ import annotations

import contextlib
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path

from tracer.errors import WriteError


def write_or_rescue(path: Path, write: Callable[[Path], None]) -> None:
    """Call ``write`` with ``path``; if that fails, with the same file name in a new folder of another place.

    Raises WriteError if the first attempt failed; its message says where the picture is now.
    """
    try:
        write(path)
    except WriteError as error:
        raise WriteError(f"{error} {rescued(path, write)}") from None


def rescued(path: Path, write: Callable[[Path], None]) -> str:
    """Write a file in the first place that has room; return a sentence that says where the picture is."""
    for folder in other_places():
        try:
            place = Path(tempfile.mkdtemp(prefix="tracer-", dir=folder))
        except OSError:
            continue
        try:
            write(place / path.name)
        except WriteError:
            with contextlib.suppress(OSError):
                place.rmdir()
        else:
            return f"The picture is kept as '{place / path.name}'."
    return "There was no room for the picture anywhere else."


def other_places() -> Iterator[Path]:
    """Yield folders that may be on other disks: the one for temporary files, the user's home, the current folder."""
    for place in (lambda: Path(tempfile.gettempdir()), Path.home, Path.cwd):
        with contextlib.suppress(OSError, RuntimeError):  # there may be no such folder
            yield place()

"""Keep what cannot be written where it was to go, as on a full disk: somewhere else, if there is room."""

from __future__ import annotations

import contextlib
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path

from tracer.errors import WriteError


def write_or_rescue(path: Path, write: Callable[[Path], None]) -> None:
    """Call ``write`` with ``path``, and if that fails with the same name in a new folder of another place.

    Raises WriteError if it failed at first, which says where the picture is now.
    """
    try:
        write(path)
    except WriteError as error:
        raise WriteError(f"{error} {rescued(path, write)}") from None


def rescued(path: Path, write: Callable[[Path], None]) -> str:
    """Write a file in the first place that has room; return a sentence about it."""
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
    """Yield folders that are likely to be on other disks: for temporary files, the user's own, the current one."""
    for place in (lambda: Path(tempfile.gettempdir()), Path.home, Path.cwd):
        with contextlib.suppress(OSError, RuntimeError):  # there may be none
            yield place()

"""Files that are written as a whole or not at all, and folders in which no earlier result is lost."""

from __future__ import annotations

import glob
import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from tracer.core.wording import option
from tracer.errors import OutputError, WriteError

IMAGE_SUFFIXES = (".exr", ".png")
"""Suffixes of the image files that can be written."""


def check_output(path: Path, overwrite: bool = False, suffixes: tuple[str, ...] = IMAGE_SUFFIXES) -> Path:
    """Return ``path`` if a file can be written there, else raise OutputError. Call this before the work, not after."""
    if suffixes and path.suffix.lower() not in suffixes:
        raise OutputError(f"'{path}' must end in {' or '.join(suffixes)}.")
    check_folder(path.parent)
    if path.is_dir():
        raise OutputError(f"'{path}' is a folder; name a file in it.")
    if path.exists() and not overwrite:
        raise OutputError(f"'{path}' exists; choose another name, or {option('overwrite')} to replace it.")
    return path


def check_folder(folder: Path) -> Path:
    """Return ``folder`` if files can be written in it, else raise OutputError."""
    if not folder.is_dir():
        raise OutputError(f"There is no folder '{folder}'; create it first.")
    try:
        with tempfile.TemporaryFile(dir=folder):
            return folder
    except OSError as error:
        raise OutputError(f"Cannot write in folder '{folder}': {error.strerror}.") from None


def prepare_folder(folder: Path, overwrite: bool, results: tuple[str, ...]) -> None:
    """Make ``folder`` ready for results, creating it in a folder that exists. Raises OutputError.

    A folder that already holds one of the files ``results`` is refused, unless ``overwrite`` is set.
    """
    if not folder.exists():
        check_folder(folder.parent)
        folder.mkdir()
    check_folder(folder)
    existing = next((name for name in results if (folder / name).exists()), None)
    if existing is not None and not overwrite:
        raise OutputError(
            f"'{folder / existing}' exists; choose another folder, or {option('overwrite')} to replace it."
        )


@contextmanager
def whole(path: Path, durable: bool = False) -> Iterator[Path]:
    """Yield the path of a temporary file, which replaces ``path`` if the block succeeds and is removed if it fails.

    ``durable``: wait until the new file is on the disk before it replaces the old one. Temporary files of ``path`` that
    a killed process has left are removed. Raises WriteError.
    """
    remove_abandoned(path)
    temporary = path.with_name(f".{path.stem}.{os.getpid()}{path.suffix}")
    try:
        yield temporary
        if durable:
            with open(temporary, "rb") as file:
                os.fsync(file.fileno())
        os.replace(temporary, path)
    except OSError as error:
        raise WriteError(f"Cannot write '{path}': {error.strerror or error}.") from None
    finally:
        temporary.unlink(missing_ok=True)


def remove_abandoned(path: Path) -> None:
    """Remove temporary files of ``path`` whose process is gone."""
    for leftover in path.parent.glob(f".{glob.escape(path.stem)}.*{glob.escape(path.suffix)}"):
        process = leftover.name.removeprefix(f".{path.stem}.").removesuffix(path.suffix)
        if process.isdecimal() and not is_running(int(process)):
            leftover.unlink(missing_ok=True)


def is_running(process: int) -> bool:
    """Return whether a process of that number runs on this machine; a zombie, which has ended, does not."""
    try:
        os.kill(process, 0)
        status = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2]
    except ProcessLookupError:
        return False
    except (OSError, OverflowError):  # another person's process, no /proc, or a number that no process can have
        return True
    return not status.startswith(" Z")


def write_text(path: Path, text: str) -> None:
    """Write a text file as UTF-8. Raises WriteError."""
    with whole(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


def write_arrays(path: Path, arrays: dict[str, Any], durable: bool = False) -> None:
    """Write arrays by name as an NPZ file, for ``np.load``. Raises WriteError."""
    with whole(path, durable) as temporary, open(temporary, "wb") as file:
        np.savez(file, **arrays)

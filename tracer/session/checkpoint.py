"""Checkpoints: the state of a render in a file, to go on from after whatever has happened, or to be merged.

A file holds the sums of all samples so far and what decisions depend on. As samples are keyed, a render that goes on
from it is the one that was never stopped. It is written beside the old one and takes its place when it is whole; it
holds numbers and JSON only, nothing that runs when it is read.
"""

from __future__ import annotations

import json
import time
import zipfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from tracer.core.version import version
from tracer.core.wording import option
from tracer.errors import CheckpointError, OutputError
from tracer.film.estimate import Estimate
from tracer.io import atomic
from tracer.scene.fingerprint import content, digest
from tracer.scene.view import View
from tracer.session.state import Arrays, State
from tracer.settings import Settings

FORMAT = 2
"""Changed when older files cannot be gone on from any more."""
EVERY_SECONDS = 60.0
LONGEST_SHARE = 0.05
"""Most of the time that is spent on writing checkpoints, but for the last."""
MAY_CHANGE = ("spp", "noise", "noise_share", "time", "max_spp", "importance")
"""Settings with which a render may go on that were others before; of an importance image the content counts."""
HEADER = "header"


@dataclass(frozen=True)
class Checkpoint:
    """What a file holds."""

    path: Path
    identity: dict[str, Any]
    """What must agree: scene, view, settings, versions."""
    frame: dict[str, Any]
    """Fields of ``PlainFrame``, and ``kinds``: moments and peaks of the estimate."""
    plain: dict[str, Any]
    arrays: Arrays
    settings: dict[str, Any]
    """All settings, those that may change too."""
    sources: list[str]
    """What the samples are of, one entry a render: the same one twice must not be merged."""


def write(checkpoint: Checkpoint) -> None:
    """Write a checkpoint. Raises OutputError; what was there before is there still."""
    header = {name: value for name, value in vars(checkpoint).items() if name not in ("path", "arrays")}
    header |= {"format": FORMAT, "names": sorted(checkpoint.arrays)}
    text = np.frombuffer(json.dumps(header).encode(), np.uint8)
    atomic.write_arrays(checkpoint.path, {HEADER: text, **checkpoint.arrays}, durable=True)


def read(path: Path) -> Checkpoint:
    """Return what a file holds. Raises CheckpointError if there is none or it is not whole."""
    if not path.is_file():
        raise CheckpointError(f"There is no checkpoint '{path}'.")
    try:
        with zipfile.ZipFile(path) as archive:  # before a damaged length is believed
            if archive.testzip() is not None:
                raise ValueError("a checksum is wrong")
        with np.load(path, allow_pickle=False) as archive:
            arrays = {name: archive[name] for name in archive.files}
        header = json.loads(arrays.pop(HEADER).tobytes())
        if header.pop("format") != FORMAT:
            raise CheckpointError(
                f"'{path}' was written by another version of tracer ({header['identity']['version']})."
            )
        return Checkpoint(path=path, arrays=arrays, **require_kinds(header, arrays))
    except CheckpointError:
        raise
    except PermissionError as error:
        raise CheckpointError(f"Cannot read '{path}': {error.strerror}.") from None
    except Exception:  # whatever bytes can do to the readers of ZIP, NumPy and JSON
        raise CheckpointError(f"'{path}' is no checkpoint, or a damaged one; remove it to begin anew.") from None


def require_kinds(header: dict[str, Any], arrays: Arrays) -> dict[str, Any]:
    """Return a header if its entries, and the arrays, are of the right kind, else raise ValueError."""
    plain = all(isinstance(header[name], dict) for name in ("identity", "frame", "plain", "settings"))
    if not plain or type(header["plain"]["done"]) is not int or not isinstance(header["identity"]["variant"], str):
        raise ValueError("no entries")
    if header.pop("names") != sorted(arrays):
        raise ValueError("arrays are missing")
    if not all(isinstance(source, str) for source in header["sources"]):
        raise ValueError("no sources")
    if not all(array.dtype.kind in "iuf" for array in arrays.values()):
        raise ValueError("no numbers")
    return header


def identity_of(view: View, settings: Settings, wanted: NDArray[np.float64], scene_hash: str) -> dict[str, Any]:
    """Return what two renders must share to be parts of one, by a name that a person understands."""
    chosen = {name: value for name, value in settings.model_dump().items() if name not in MAY_CHANGE}
    film = view.film
    return {
        "version": version(),
        "Mitsuba": mi.__version__,
        "variant": mi.variant(),
        "scene": scene_hash,
        "sensor": digest(*content(view.sensor)),
        "size": [int(x) for x in film.size()],
        "crop": [int(x) for x in (*film.crop_offset(), *film.crop_size())],
        "integrator": digest(*content(view.integrator)),
        "importance": digest(wanted.tobytes()),
        **chosen,
    }


HASHED = ("scene", "sensor", "integrator", "importance")
FOLLOWS = {"size": ("crop", "sensor", "importance"), "crop": ("sensor", "importance")}
"""What is another one wherever something else is: a film's crop, what a sensor prints of its film, an image of weights.
Whether it would differ otherwise, too, nobody knows."""


def differences(own: dict[str, Any], other: dict[str, Any], but: Sequence[str] = ()) -> list[str]:
    """Return what differs between two identities, a clause each; what follows from another difference is left out."""
    changed = [
        name for name in (*own, *(name for name in other if name not in own)) if own.get(name) != other.get(name)
    ]
    changed.sort(key=lambda name: name not in FOLLOWS)
    implied = {name for cause in changed for name in FOLLOWS.get(cause, ())}
    found = []
    for name in changed:
        here, there = own.get(name), other.get(name)
        if name not in but and name not in implied:
            found.append(f"another {name}" if name in HASHED else f"{name} {there} there and {here} here")
    return found


class Keeper:
    """Keeps the state of one render in a file."""

    def __init__(self, path: Path, scene_hash: str, resume: bool, every: float = EVERY_SECONDS) -> None:
        """``resume``: go on from the file if there is one; ``every``: seconds between two writes."""
        self.path, self.scene_hash, self.resume, self.every = path, scene_hash, resume, every
        self.source: str | None = None
        """What the samples are of, if not of a seed alone."""
        self.complaints: list[str] = []
        self.resumed_from = self.kept = 0
        """Samples that were there at the start, and that the file has."""
        self.written = time.monotonic()
        self.took = 0.0
        self.writes = 0

    def bind(self, view: View, settings: Settings, wanted: NDArray[np.float64]) -> None:
        """Learn which render it is."""
        self.view, self.settings = view, settings
        self.identity = identity_of(view, settings, wanted, self.scene_hash)

    def load(self, beginning: State, empty: Estimate) -> State:
        """Return the state of the file, or ``beginning`` if there is none. Raises CheckpointError.

        ``empty``: another estimate without samples, for those that are held out.
        """
        if not self.resume or not self.path.exists():
            return beginning
        kept = read(self.path)
        if other := differences(self.identity, kept.identity):
            raise CheckpointError(
                f"Checkpoint '{self.path}' is of another render: {'; '.join(other)}. "
                "Resume it as it was begun, or name another file."
            )
        if "generator" not in kept.plain:
            raise CheckpointError(f"'{self.path}' is a merge; it can be merged further, but not rendered on from.")
        try:
            beginning.unpack(kept.arrays, kept.plain, empty)
        except (ValueError, KeyError, TypeError, AttributeError, OverflowError):
            raise CheckpointError(f"'{self.path}' is a damaged checkpoint; remove it to begin anew.") from None
        self.resumed_from = self.kept = beginning.done
        return beginning

    def save_if_due(self, state: State, at_once: bool = False) -> None:
        """Write the file if it is time. That it cannot be written is kept as a complaint: the render goes on."""
        pause = max(self.every, self.took / LONGEST_SHARE)
        if at_once or time.monotonic() - self.written >= pause:
            self.save(state)

    def in_words(self, total: int) -> str:
        """Return a sentence about what the file has of ``total`` samples."""
        if self.kept == 0:
            return f"There is no checkpoint '{self.path}' yet."
        share = 100 * self.kept / total
        return f"The checkpoint '{self.path}' has {share:.1f} % of the samples; go on with {option('resume')}."

    def save(self, state: State) -> None:
        """Write the file."""
        start = time.monotonic()
        frame = {name: getattr(self.view, name) for name in ("size", "border", "channels", "reach", "window")}
        arrays, plain = state.pack()
        try:
            write(
                Checkpoint(
                    path=self.path,
                    identity=self.identity,
                    frame={**frame, "kinds": [state.estimate.moments, state.estimate.peaks]},
                    plain=plain,
                    arrays=arrays,
                    settings=self.settings.model_dump(),
                    sources=[self.source or f"seed {self.settings.seed}"],
                )
            )
            self.complaints.clear()
            self.kept = state.done
        except OutputError as error:
            self.complaints[:] = [f"{error} {self.what_is_there(state)}"]
        self.written = time.monotonic()
        self.took = self.written - start
        self.writes += 1

    def what_is_there(self, state: State) -> str:
        """Return a sentence about the file after it could not be written."""
        if self.kept:
            share = 100 * self.kept / max(state.done, 1)
            return f"The last checkpoint that could be written is still there, with {share:.3g} % of the samples."
        if self.path.exists():
            return "What was there before is still there; of this render there is no checkpoint."
        return "There is no checkpoint."


def open_keeper(
    path: Path, scene_hash: str, resume: bool, overwrite: bool = False, every: float = EVERY_SECONDS
) -> Keeper:
    """Return a keeper for a file that can be written. Raises OutputError."""
    atomic.check_output(path, overwrite or resume, suffixes=())
    return Keeper(path, scene_hash, resume and not overwrite, every)

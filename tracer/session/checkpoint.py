"""Checkpoints: the state of a render in a file, to go on from after whatever has happened, or to be merged.

A file holds the sums of all samples so far and what decisions depend on. As samples are keyed, a render that goes on
from it is the one that was never stopped. It is written beside the old one and takes its place when it is whole; it
holds numbers and JSON only, nothing that runs when it is read.
"""

from __future__ import annotations

import json
import zipfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from tracer.core.version import release
from tracer.errors import CheckpointError
from tracer.io import atomic
from tracer.scene.fingerprint import content, digest
from tracer.scene.view import View
from tracer.session.state import Arrays
from tracer.settings import Settings

FORMAT = 4
"""Changed when older files cannot be gone on from any more."""
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
    """Fields of ``PlainFrame``; ``kinds``: moments and peaks of the estimate; ``filter``: plain ``FilterShape``."""
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


def read(path: Path, advice: str = "remove it to begin anew") -> Checkpoint:
    """Return what a file holds. Raises CheckpointError, with ``advice``, if there is none or it is not whole."""
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
        raise CheckpointError(f"'{path}' is no checkpoint, or a damaged one; {advice}.") from None


def was_guided(path: Path) -> bool | None:
    """Return whether the integrator ``guided`` has drawn what a file holds; None if there is no such file.

    What is wrong with a file is for ``read`` to say.
    """
    try:
        with np.load(path, allow_pickle=False) as archive:
            return bool(json.loads(archive[HEADER].tobytes())["plain"]["guided"])
    except Exception:
        return None


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


def identity_of(view: View, settings: Settings, weights: NDArray[np.float64], scene_hash: str) -> dict[str, Any]:
    """Return what two renders must share to be parts of one, by a name that a person understands."""
    chosen = {name: value for name, value in settings.model_dump().items() if name not in MAY_CHANGE}
    film = view.film
    return {
        "version": release(),
        "Mitsuba": mi.__version__,
        "variant": mi.variant(),
        "scene": scene_hash,
        "sensor": digest(*content(view.sensor)),
        "size": [int(x) for x in film.size()],
        "crop": [int(x) for x in (*film.crop_offset(), *film.crop_size())],
        "integrator": digest(*content(view.integrator)),
        "importance": digest(weights.tobytes()),
        **chosen,
    }


HASHED = ("scene", "sensor", "integrator", "importance")
"""Entries of an identity that are hashes, which a message does not show."""
FOLLOWS = {"size": ("crop", "sensor", "importance"), "crop": ("sensor", "importance")}
"""Entries of an identity that always differ where another entry does: a film of another size has another crop, and its
sensor and the image of weights are others, too. A message leaves them out: nobody knows if they differ besides."""


def differences(identity: dict[str, Any], other_identity: dict[str, Any], but: Sequence[str] = ()) -> list[str]:
    """Return what differs between two identities, a clause each; what follows from another difference is left out."""
    changed = [
        name
        for name in (*identity, *(name for name in other_identity if name not in identity))
        if identity.get(name) != other_identity.get(name)
    ]
    changed.sort(key=lambda name: name not in FOLLOWS)
    implied = {name for cause in changed for name in FOLLOWS.get(cause, ())}
    clauses = []
    for name in changed:
        value, other_value = identity.get(name), other_identity.get(name)
        if name not in but and name not in implied:
            clauses.append(f"another {name}" if name in HASHED else f"{name} {other_value} there and {value} here")
    return clauses

"""What a worker must know to draw samples of a view, and what it must be made of to draw the same ones."""

from __future__ import annotations

import hashlib
import importlib
import importlib.metadata
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import tracer
from tracer.core.version import version
from tracer.errors import ClusterError, SettingsError
from tracer.scene.view import Crop, Size


@dataclass(frozen=True)
class Setup:
    """A scene, and how it is seen. A worker that has opened one keeps it open for all units of it."""

    scene: str
    """Path of the scene file where the client is; workers that find another one there, or none, take the bundle."""
    scene_hash: str
    variant: str
    define: tuple[tuple[str, str], ...] = ()
    sensor: int = 0
    integrator: str | None = None
    size: Size = None
    crop: Crop = None


@dataclass(frozen=True)
class RoundSettings:
    """What all units of a round have in common."""

    made_of: dict[str, str]
    """See ``software``."""
    criterion: str | None
    """Whose moments are gathered, None where it asks for none."""
    largest_pass: int
    seed: int
    scale: float
    """Of ray differentials."""


def make_setup(
    scene: Any, scene_hash: str, variant: str, define: dict[str, str] | None, sensor: Any, **seen: Any
) -> Setup:
    """Return a setup; ``seen``: its other fields. Raises SettingsError for what cannot be sent elsewhere."""
    if not isinstance(scene, str | Path):
        raise SettingsError("On a cluster a scene is a file: write this one to an XML file and name that.")
    if not isinstance(sensor, int):
        raise SettingsError("On a cluster a sensor is named by its number in the scene file.")
    if not isinstance(seen.get("integrator"), str | None):
        raise SettingsError("On a cluster an integrator is the scene file's, or the name of a plugin.")
    path = str(Path(scene).resolve())
    return Setup(path, scene_hash, variant, tuple(sorted((define or {}).items())), sensor, **seen)


@cache
def software() -> dict[str, str]:
    """Return what samples depend on beside the scene: versions, and a hash of our source."""
    found = {"tracer": version(), "tracer's source": source_hash()}
    return found | {name: importlib.metadata.version(name.lower()) for name in ("Mitsuba", "DrJit")}


def source_hash() -> str:
    """Return a hash of all Python files of tracer, wherever they are installed."""
    folders = [Path(each).resolve() for each in importlib.import_module("tracer.plugins").__path__]
    root = Path(tracer.__file__).resolve().parent
    sources = {f"plugins/{file.name}": file for folder in folders for file in folder.glob("*.py")}
    for file in root.rglob("*.py"):
        place = file.relative_to(root)
        if place.parts[0] not in ("plugins", "scenes"):  # beside it in a checkout, in it where it is installed
            sources[place.as_posix()] = file
    digest = hashlib.sha256()
    for name, file in sorted(sources.items()):
        digest.update(name.encode() + b"\0" + file.read_bytes())
    return digest.hexdigest()[:16]


def require_same(theirs: dict[str, str], ours: dict[str, str], worker: str) -> None:
    """Raise ClusterError unless a worker is made of what the client is made of."""
    for name, own in ours.items():
        if theirs.get(name) != own:
            raise ClusterError(
                f"Worker {worker} has {name} {theirs.get(name)}, and the client {own}: they would not draw the "
                "same samples; install the same on both."
            )

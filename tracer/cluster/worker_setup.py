"""What a worker must know to draw samples of a view, and which software it must have to draw the same samples."""

from __future__ import annotations

import hashlib
import importlib
import importlib.metadata
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import tracer
from tracer.core.version import release
from tracer.errors import ClusterError, SettingsError
from tracer.scene.view import Crop, Size
from tracer.session.state import Arrays


@dataclass(frozen=True)
class Setup:
    """A scene, and how it is seen. A worker keeps the scene of a setup open for all units with this setup."""

    scene: str
    """Path of the scene file on the client. A worker without a file there, or with another one, uses the bundle."""
    scene_hash: str
    """Hash of the scene with all of its files."""
    variant: str
    """Mitsuba variant."""
    define: tuple[tuple[str, str], ...] = ()
    """Names and values of the scene's $parameters."""
    sensor: int = 0
    """Number of the sensor in the scene, from 0."""
    integrator: str | None = None
    """Plugin in place of the scene's integrator; None: the scene's own."""
    size: Size = None
    """As for ``tracer.scene.view.open_scene``."""
    crop: Crop = None
    """As for ``tracer.scene.view.open_scene``."""


@dataclass(frozen=True)
class RoundSettings:
    """What all units of a round have in common."""

    made_of: dict[str, str]
    """Software of the client, see ``software``."""
    criterion: str | None
    """Criterion whose moments are gathered; None if it asks for none."""
    largest_pass: int
    """Most samples of a pass."""
    seed: int
    """Seed of the samples."""
    scale: float
    """Scale of ray differentials."""
    guided: bool = False
    """Whether the integrator is ``guided`` in place of ``path``."""
    guide: Arrays | None = None
    """Chances of lights, as ``LightChances.pack`` returns them; None: all have the same."""


def make_setup(
    scene: Any, scene_hash: str, variant: str, define: dict[str, str] | None, sensor: Any, **view_fields: Any
) -> Setup:
    """Return a setup; ``view_fields``: its other fields. Raises SettingsError for values that cannot be sent."""
    if not isinstance(scene, str | Path):
        raise SettingsError("On a cluster a scene is a file: write this one to an XML file and name that.")
    if not isinstance(sensor, int):
        raise SettingsError("On a cluster a sensor is named by its number in the scene file.")
    if not isinstance(view_fields.get("integrator"), str | None):
        raise SettingsError("On a cluster an integrator is the scene file's, or the name of a plugin.")
    path = str(Path(scene).resolve())
    return Setup(path, scene_hash, variant, tuple(sorted((define or {}).items())), sensor, **view_fields)


@cache
def software() -> dict[str, str]:
    """Return the software that samples depend on, by name: versions, and a hash of tracer's source."""
    own_software = {"tracer": release(), "tracer's source": source_hash()}
    return own_software | {name: importlib.metadata.version(name.lower()) for name in ("Mitsuba", "DrJit")}


def source_hash() -> str:
    """Return a hash of all Python files of tracer, wherever they are installed."""
    folders = [Path(folder).resolve() for folder in importlib.import_module("tracer.plugins").__path__]
    root = Path(tracer.__file__).resolve().parent
    sources = {f"plugins/{file.name}": file for folder in folders for file in folder.glob("*.py")}
    for file in root.rglob("*.py"):
        place = file.relative_to(root)
        if place.parts[0] not in ("plugins", "scenes"):  # in a checkout these two folders are not within the package
            sources[place.as_posix()] = file
    digest = hashlib.sha256()
    for name, file in sorted(sources.items()):
        digest.update(name.encode() + b"\0" + file.read_bytes())
    return digest.hexdigest()[:16]


def require_same(theirs: dict[str, str], ours: dict[str, str], worker: str) -> None:
    """Raise ClusterError unless the software of a ``worker``, ``theirs``, is that of the client, ``ours``."""
    for name, our_version in ours.items():
        if theirs.get(name) != our_version:
            raise ClusterError(
                f"Worker {worker} has {name} {theirs.get(name)}, and the client {our_version}: they would not draw the "
                "same samples; install the same on both."
            )

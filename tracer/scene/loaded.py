"""A scene that is loaded once and rendered several times, with the hash that identifies it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tracer.scene.fingerprint import fingerprint
from tracer.scene.load import load, require_scene


@dataclass(frozen=True)
class LoadedScene:
    """An ``mi.Scene`` and the file that it comes from."""

    path: Path
    """The scene file."""
    define: dict[str, str]
    """Values of the $parameters of the file."""
    scene_hash: str
    """``fingerprint`` of the file as it was when it was loaded, even if the file is edited later."""
    scene: Any
    """The ``mi.Scene``."""


def load_scene(path: Path, define: dict[str, str] | None = None) -> LoadedScene:
    """Load a scene file. Raises SceneError if it cannot be loaded or holds something other than a scene."""
    scene_hash = fingerprint(path, define)
    return LoadedScene(path, define or {}, scene_hash, require_scene(path, load(path, define=define)))

"""Reference pictures, kept by content: what the scene consists of and every setting that changes the picture."""

from __future__ import annotations

import hashlib
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from tracer import files
from tracer.loop import ProgressCallback, render
from tracer.metadata import metadata, version
from tracer.scene import Size
from tracer.source import fingerprint

SEED = 1000003
"""Far from the seeds that are measured."""
FACTOR = 64
"""A reference takes this many times the samples of the largest budget measured against it."""


@dataclass(frozen=True)
class Reference:
    """A picture close enough to the truth to measure others by."""

    image: NDArray[np.float32]
    """(H, W, C)."""
    stderr: NDArray[np.float32]
    """(H, W, C): its own standard error, as estimated."""
    spp: int


def cache_folder() -> Path:
    """Return the folder of kept references: ``$TRACER_CACHE``, else ``tracer`` in the user's cache folder."""
    home = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(os.environ.get("TRACER_CACHE") or Path(home) / "tracer") / "references"


def cache_key(source: Any, integrator: str | None, sensor: int, size: Size, spp: int) -> str:
    """Return the name under which a reference is kept: a hash of scene content, settings and versions."""
    parts = (fingerprint(source), integrator, sensor, size, spp, SEED, mi.variant(), mi.__version__, version())
    return hashlib.sha256(repr(parts).encode()).hexdigest()[:24]


def reference(
    source: Any,
    spp: int,
    *,
    integrator: str | None = None,
    sensor: int = 0,
    size: Size = None,
    progress: ProgressCallback | None = None,
) -> Reference:
    """Return a uniform rendering of ``source`` at ``spp`` samples per pixel, from the cache if it is there.

    Raises KeyboardInterrupt if ``progress`` stops it: half a reference is none.
    """
    path = cache_folder() / f"{cache_key(source, integrator, sensor, size, spp)}.exr"
    if not path.exists():
        scene_hash = fingerprint(source)
        settings: dict[str, Any] = {"spp": spp, "seed": SEED, "criterion": "uniform"}
        result = render(source, integrator=integrator, sensor=sensor, size=size, progress=progress, **settings)
        if not result.report.complete:
            raise KeyboardInterrupt
        path.parent.mkdir(parents=True, exist_ok=True)
        files.write_result(path, result, metadata(result, scene_hash))
    names, values, _ = files.read_exr(path)
    errors = [k for k, name in enumerate(names) if name.startswith("stderr.")]
    colours = [k for k, name in enumerate(names) if f"stderr.{name}" in names]
    return Reference(values[..., colours], values[..., errors], spp)

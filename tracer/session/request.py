"""What is asked of a session: one picture, how it is made, and where it goes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from tracer.core.wording import Tell, option, silent
from tracer.errors import SettingsError
from tracer.io import atomic
from tracer.io.exr import Chosen
from tracer.progress import ProgressCallback
from tracer.scene.fingerprint import fingerprint
from tracer.scene.loaded import LoadedScene
from tracer.scene.view import Crop, Size, View
from tracer.session.local_drawer import DrawerFor
from tracer.session.shards import Part
from tracer.settings import Settings

EVERY_SECONDS = 60.0
"""Between two writes of a checkpoint, unless it is asked for more or less often."""


@dataclass(frozen=True)
class CheckpointFile:
    """A file that the state of a render is kept in."""

    path: Path
    every: float = EVERY_SECONDS
    """Seconds between two writes."""
    resume: bool = False
    """Whether to go on from the file, if it is there."""
    overwrite: bool = False
    """Whether to begin anew and replace the file, if it is there."""

    @property
    def goes_on(self) -> bool:
        """Whether a render goes on from the file."""
        return self.resume and not self.overwrite and self.path.exists()


@dataclass(frozen=True)
class PictureFile:
    """A file that a picture is written to: EXR, or PNG."""

    path: Path
    overwrite: bool = False
    layers: Chosen = "all"
    origin: dict[str, Any] = field(default_factory=dict)
    """What the picture was asked for with, as plain values: the attribute "job" of an EXR; a PNG does not hold it."""


@dataclass(frozen=True)
class Request:
    """One picture: what is rendered, how, and where it goes. ``session.render.render_request`` carries it out."""

    scene: Any
    """Path of a scene file, dictionary, ``mi.Scene``, ``LoadedScene``, or a ``View`` that is open already."""
    settings: Settings | dict[str, Any] = field(default_factory=dict)
    """All of them, or those that are given; the others are then those of the scene's integrator, if it is
    ``adaptive``, or the defaults; ``spp`` is that of the scene's sampler, see ``View.asked_spp``."""

    sensor: Any = 0
    integrator: Any = None
    size: Size = None
    crop: Crop = None
    define: dict[str, str] | None = None
    """As for ``tracer.scene.view.open_scene``, like the four fields before it. A ``View`` that is open has its own."""

    importance: Any = None
    """Array (H, W) whose values multiply each pixel's importance, in place of the image file of the settings."""
    part: Part | None = None
    """Which part of the samples are drawn; None: all of them."""
    features: bool = False
    """Whether to return what the camera's rays hit first."""
    denoise: bool = False
    """Whether to take the noise out of the picture."""
    memory_limit: float | None = None
    """Most memory in GiB."""
    workers: Workers | None = None
    """Who draws, if not this process."""
    started: float | None = None
    """Value of ``time.perf_counter()`` from which a limit of time counts; None: from when it is carried out."""

    progress: ProgressCallback | None = None
    remark: Tell = silent
    """Hears, before the first sample, that a render is large or goes on from a checkpoint, in a sentence."""
    stage: Tell = silent
    """Hears what is being done whenever that changes and no samples tell of it, in a few words: "Opening the scene"."""
    checkpoint: CheckpointFile | None = None
    picture: PictureFile | None = None


Workers = Callable[[Request, str], DrawerFor]
"""From a request, and the hash of its scene, to who draws it; see ``tracer.cluster.remote_drawer``."""


def checkpoint_file(path: Path | None, every: float, resume: bool, overwrite: bool) -> CheckpointFile | None:
    """Return the checkpoint that is asked for, if any. Raises SettingsError where there is nothing to resume from."""
    if path is not None:
        return CheckpointFile(path, every, resume, overwrite)
    if resume:
        raise SettingsError(
            f"There is nothing to resume from: name the checkpoint with {option('checkpoint', 'FILE')}."
        )
    return None


def check_files(request: Request) -> None:
    """Raise OutputError if a file of a request cannot be written. Call it before the work, not after."""
    if request.picture is not None:
        resumes = request.checkpoint is not None and request.checkpoint.resume
        atomic.check_output(request.picture.path, request.picture.overwrite or resumes)
    if request.checkpoint is not None:
        file = request.checkpoint
        atomic.check_output(file.path, file.overwrite or file.resume, suffixes=())


def scene_hash_of(request: Request) -> str:
    """Return what identifies the scene of a request, "" where nobody asks for it. Raises SceneError."""
    scene = request.scene
    if isinstance(scene, LoadedScene):
        return scene.scene_hash
    if request.checkpoint is None and request.picture is None and request.workers is None:
        return ""
    return fingerprint(scene.scene if isinstance(scene, View) else scene, request.define)

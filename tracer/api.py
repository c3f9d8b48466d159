"""What a script calls: a scene in, a picture and all that is known about it out."""

from __future__ import annotations

import time
from contextlib import ExitStack
from pathlib import Path
from typing import Any

from tracer import backend
from tracer.checkpoint import EVERY_SECONDS, open_keeper
from tracer.fingerprint import fingerprint
from tracer.loop import Terms, render_view
from tracer.progress import ProgressCallback
from tracer.result import Result
from tracer.scene import Crop, Size, open_scene
from tracer.settings import make_settings


def render(
    scene: Any,
    *,
    integrator: Any = None,
    sensor: int = 0,
    size: Size = None,
    crop: Crop = None,
    define: dict[str, str] | None = None,
    progress: ProgressCallback | None = None,
    importance: Any = None,
    checkpoint: str | Path | None = None,
    checkpoint_every: float = EVERY_SECONDS,
    resume: bool = False,
    memory_limit: float | None = None,
    features: bool = False,
    denoise: bool = False,
    cluster: Any = None,
    started: float | None = None,
    **settings: Any,
) -> Result:
    """Render ``scene`` (path of an XML file, dictionary, or ``mi.Scene``) and return picture, counts and errors.

    ``sensor``: number or ``mi.Sensor``; ``size``, ``crop``: see ``tracer.scene``; ``define``: values of the $parameters
    of a file. ``importance``: array (H, W) or image file whose values multiply the importance of each pixel.
    ``checkpoint``: file to keep the state in, every ``checkpoint_every`` seconds and at the end; ``resume``: go on from
    it if it is there. ``memory_limit``: most memory in GiB; passes are made as small as that asks for.
    ``features``: whether to return what the camera's rays hit first; ``denoise``: whether to take the noise out of the
    picture with the help of that. ``cluster``: draw on workers: their number on this machine, the address of a Dask
    scheduler, or a ``distributed.Client``; the picture is the same, and the scene must be a file. ``started``: value of
    ``time.perf_counter()`` from which a limit of time counts, instead of now.

    Further keywords are those of ``tracer.settings.Settings``: spp, noise, time, seed, criterion, objective, exposure,
    pilot_spp, min_spp, max_spp, cost, block, unbiased, shape_weights; where the scene's integrator is ``adaptive``, its
    parameters are the defaults. Sets the Mitsuba variant ``llvm_ad_rgb`` unless one is active. Raises the errors of
    ``tracer.errors``.
    """
    started = time.perf_counter() if started is None else started
    backend.activate()
    if isinstance(importance, str | Path):
        settings["importance"], importance = str(importance), None
    keeper = None
    if checkpoint is not None:
        keeper = open_keeper(Path(checkpoint), fingerprint(scene, define), resume, every=checkpoint_every)
    with ExitStack() as stack:
        drawer = None
        if cluster is not None:
            from tracer.cluster.hire import hire

            seen = {"integrator": integrator, "size": size, "crop": crop}
            drawer = stack.enter_context(hire(cluster))(scene, fingerprint(scene, define), define, sensor, **seen)
        view = stack.enter_context(open_scene(scene, sensor, integrator, size, crop, define))
        chosen = make_settings(**{**view.settings, **settings})
        terms = Terms(progress, keeper, started, memory_limit, features, denoise, drawer)
        return render_view(view, chosen, terms, importance)

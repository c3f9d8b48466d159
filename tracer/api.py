"""The function that a script calls: from a scene to a picture and all that is known about it."""

from __future__ import annotations

import inspect
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

from tracer import criteria
from tracer.cluster import hired
from tracer.core import backend
from tracer.core.plain_values import plain
from tracer.core.suggest import did_you_mean
from tracer.errors import SettingsError
from tracer.progress import ProgressCallback
from tracer.result import Result
from tracer.scene.view import Crop, Size
from tracer.session.render import render_request
from tracer.session.request import EVERY_SECONDS, Request, check_files, checkpoint_file
from tracer.settings import Settings
from tracer.viewpoint.showcase import is_mesh_file, require_scene_file, showcase


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
    overwrite: bool = False,
    memory_limit: float | None = None,
    features: bool = False,
    denoise: bool = False,
    cluster: Any = None,
    started: float | None = None,
    **settings: Any,
) -> Result:
    """Render ``scene`` (path of an XML file, dictionary, or ``mi.Scene``) and return picture, counts and errors.

    The path of a mesh file shows the mesh from its best view in a neutral light, see ``tracer.viewpoint.showcase``.
    An ``mi.Scene`` that is rendered again unchanged is prepared faster than the first time.
    ``sensor``: number or ``mi.Sensor``; ``size``, ``crop``: see ``tracer.scene.view``; ``define``: values of the
    $parameters of a file. ``importance``: array (H, W) or image file whose values multiply each pixel's importance.
    ``checkpoint``: file in which the state is kept, every ``checkpoint_every`` seconds and at the end; ``resume``: go
    on from it if it exists; ``overwrite``: begin anew and replace it. ``memory_limit``: most memory in GiB; passes are
    made small enough for it, and lights are learned from fewer paths. ``features``: whether to return what the camera's
    rays hit first; ``denoise``: whether to take the noise out of the picture, with the help of these features.
    ``cluster``: draw on workers, given as their number on this machine, the address of a Dask scheduler, or a
    ``distributed.Client``; the picture is the same, and the scene must be a file. ``started``: value of
    ``time.perf_counter()`` from which a time limit counts; None: now.

    Further keywords are those of ``tracer.settings.Settings``: spp, noise, time, seed, criterion, objective, exposure,
    pilot_spp, min_spp, max_spp, cost, block, guide, unbiased, shape_weights. If the scene's integrator is ``adaptive``,
    its parameters are the defaults. ``criterion`` may also be a function from ``tracer.criteria.Evidence`` to
    importance (H, W); a function without a registered name cannot be combined with a checkpoint. Sets the Mitsuba
    variant ``llvm_ad_rgb`` unless one is active. Raises the errors of ``tracer.errors``.
    """
    started = time.perf_counter() if started is None else started
    require_keywords(settings)
    require_terms(progress, checkpoint_every, memory_limit, define)
    if "criterion" in settings:
        settings["criterion"] = criterion_name(settings["criterion"], checkpoint)
    if isinstance(importance, str | Path):
        settings["importance"], importance = str(importance), None
    path = None if checkpoint is None else Path(checkpoint)
    request = Request(
        scene,
        settings,
        sensor=sensor,
        integrator=integrator,
        size=size,
        crop=crop,
        define=define,
        importance=importance,
        features=features,
        denoise=denoise,
        memory_limit=memory_limit,
        started=started,
        progress=progress,
        checkpoint=checkpoint_file(path, checkpoint_every, resume, overwrite),
    )
    check_files(request)  # before workers are started
    backend.activate()
    if is_mesh_file(scene):
        if cluster is not None:
            require_scene_file(scene)
        request = replace(request, scene=showcase(Path(scene)))
    with hired(cluster) as workers:
        return render_request(replace(request, workers=workers))


def criterion_name(criterion: Any, checkpoint: Any) -> Any:
    """Return the name of a criterion, which may be a function.

    Raises SettingsError for a function that is not registered if there is a ``checkpoint``, which must name it.
    """
    name = criteria.name_of(criterion)
    if checkpoint is not None and criteria.is_function(name):
        raise SettingsError(
            "criterion: a checkpoint cannot tell one function from another; give it a name with "
            "tracer.criteria.criterion, or leave out checkpoint."
        )
    return name


def require_keywords(settings: dict[str, Any]) -> None:
    """Raise SettingsError for a keyword that ``render`` does not have; the message offers the nearest that it has."""
    parameters = [name for name in inspect.signature(render).parameters if name != "settings"]
    unknown = next((name for name in settings if name not in Settings.model_fields), None)
    if unknown is not None:
        hint = did_you_mean(unknown, [*parameters, *Settings.model_fields])
        raise SettingsError(f"There is no setting '{unknown}'{hint}")


def require_terms(progress: Any, checkpoint_every: Any, memory_limit: Any, define: Any) -> None:
    """Raise SettingsError for an argument of ``render`` that has the wrong type or is out of range."""
    if progress is not None and not callable(progress):
        raise SettingsError(
            "progress: give a function that is called with a tracer.Progress after every pass, "
            f"such as tracer.live.notebook() (was {progress!r})."
        )
    if not is_number(checkpoint_every) or checkpoint_every < 0:
        raise SettingsError(f"checkpoint_every: write seconds, 0 or more (was {checkpoint_every!r}).")
    if memory_limit is not None and (not is_number(memory_limit) or memory_limit <= 0):
        raise SettingsError(f"memory_limit: write GiB, more than 0 (was {memory_limit!r}).")
    if define is not None and not isinstance(define, dict):
        raise SettingsError(f'define: write {{"name": "value"}} (was {define!r}).')


def is_number(value: Any) -> bool:
    """Return whether a value is a real number, of Python or of another library; True and False are none."""
    return isinstance(plain(value), int | float) and not isinstance(plain(value), bool)

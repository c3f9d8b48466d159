"""What a script calls: a scene in, a picture and all that is known about it out."""

from __future__ import annotations

import inspect
import time
from contextlib import ExitStack
from pathlib import Path
from typing import Any

from tracer import criteria
from tracer.core import backend
from tracer.core.plain_values import plain
from tracer.core.suggest import nearest
from tracer.errors import SettingsError
from tracer.progress import ProgressCallback
from tracer.result import Result
from tracer.scene.fingerprint import fingerprint
from tracer.scene.view import Crop, Size, open_scene
from tracer.session.checkpoint import EVERY_SECONDS, open_keeper
from tracer.session.render_loop import render_view
from tracer.session.terms import Terms
from tracer.settings import Settings, make_settings


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

    ``sensor``: number or ``mi.Sensor``; ``size``, ``crop``: see ``tracer.scene.view``; ``define``: values of the
    $parameters of a file. ``importance``: array (H, W) or image file whose values multiply each pixel's importance.
    ``checkpoint``: file to keep the state in, every ``checkpoint_every`` seconds and at the end; ``resume``: go on from
    it if it is there; ``overwrite``: begin anew and replace it. ``memory_limit``: most memory in GiB; passes are as
    small as that asks for. ``features``: whether to return what the camera's rays hit first; ``denoise``: whether to
    take the noise out of the picture with the help of that. ``cluster``: draw on workers: their number on this machine,
    the address of a Dask scheduler, or a ``distributed.Client``; the picture is the same, and the scene must be a file.
    ``started``: value of ``time.perf_counter()`` from which a limit of time counts, instead of now.

    Further keywords are those of ``tracer.settings.Settings``: spp, noise, time, seed, criterion, objective, exposure,
    pilot_spp, min_spp, max_spp, cost, block, unbiased, shape_weights; where the scene's integrator is ``adaptive``, its
    parameters are the defaults. ``criterion`` may also be a function from ``tracer.criteria.Evidence`` to importance
    (H, W); without a name it cannot be combined with a checkpoint. Sets the Mitsuba variant ``llvm_ad_rgb`` unless one
    is active. Raises the errors of ``tracer.errors``.
    """
    started = time.perf_counter() if started is None else started
    require_keywords(settings)
    require_terms(progress, checkpoint, checkpoint_every, resume, memory_limit, define)
    backend.activate()
    if "criterion" in settings:
        settings["criterion"] = criterion_name(settings["criterion"], checkpoint)
    if isinstance(importance, str | Path):
        settings["importance"], importance = str(importance), None
    keeper = None
    if checkpoint is not None:
        keeper = open_keeper(Path(checkpoint), fingerprint(scene, define), resume, overwrite, every=checkpoint_every)
    with ExitStack() as stack:
        drawer = None
        if cluster is not None:
            from tracer.cluster.remote_drawer import open_remote_drawer

            seen = {"integrator": integrator, "size": size, "crop": crop}
            drawer = stack.enter_context(open_remote_drawer(plain(cluster)))(
                scene, fingerprint(scene, define), define, sensor, **seen
            )
        view = stack.enter_context(open_scene(scene, sensor, integrator, size, crop, define))
        chosen = make_settings(**{**view.settings, **settings})
        terms = Terms(progress, keeper, started, memory_limit, features, denoise, drawer)
        return render_view(view, chosen, terms, importance)


def criterion_name(criterion: Any, checkpoint: Any) -> Any:
    """Return the name of a criterion that may be a function. Raises SettingsError where a name of its own is needed."""
    name = criteria.name_of(criterion)
    if checkpoint is not None and criteria.is_function(name):
        raise SettingsError(
            "criterion: a checkpoint cannot tell one function from another; give it a name with "
            "tracer.criteria.criterion, or leave out checkpoint."
        )
    return name


def require_keywords(settings: dict[str, Any]) -> None:
    """Raise SettingsError for a keyword that ``render`` does not have, with the nearest that it has."""
    own = [name for name in inspect.signature(render).parameters if name != "settings"]
    unknown = next((name for name in settings if name not in Settings.model_fields), None)
    if unknown is not None:
        hint = nearest(unknown, [*own, *Settings.model_fields])
        raise SettingsError(f"There is no setting '{unknown}'" + (f", did you mean '{hint}'?" if hint else "."))


def require_terms(
    progress: Any, checkpoint: Any, checkpoint_every: Any, resume: Any, memory_limit: Any, define: Any
) -> None:
    """Raise SettingsError for what is not of the kind that ``render`` asks for."""
    if progress is not None and not callable(progress):
        raise SettingsError(
            "progress: give a function that is called with a tracer.Progress after every pass, "
            f"such as tracer.live.notebook() (was {progress!r})."
        )
    if resume and checkpoint is None:
        raise SettingsError("There is nothing to resume from: name the file with checkpoint=.")
    if not is_number(checkpoint_every) or checkpoint_every < 0:
        raise SettingsError(f"checkpoint_every: write seconds, 0 or more (was {checkpoint_every!r}).")
    if memory_limit is not None and (not is_number(memory_limit) or memory_limit <= 0):
        raise SettingsError(f"memory_limit: write GiB, more than 0 (was {memory_limit!r}).")
    if define is not None and not isinstance(define, dict):
        raise SettingsError(f'define: write {{"name": "value"}} (was {define!r}).')


def is_number(value: Any) -> bool:
    """Return whether a value is a real number."""
    return isinstance(plain(value), int | float) and not isinstance(plain(value), bool)

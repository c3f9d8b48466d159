"""The function that a script calls: from a scene to a picture and all that is known about it."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from time import perf_counter as now
from typing import Any, Literal, Never

from numpy.typing import ArrayLike

from tracer import criteria
from tracer.cluster import hired
from tracer.core import backend
from tracer.core.arrays import Floats
from tracer.core.plain_values import plain
from tracer.core.protocols import DaskClient, Integrator, Scene, Sensor
from tracer.core.suggest import did_you_mean
from tracer.criteria import Criterion, Evidence
from tracer.errors import SettingsError
from tracer.progress import ProgressCallback
from tracer.result import Result
from tracer.scene.view import Crop, Size
from tracer.session.render import render_request
from tracer.session.request import EVERY_SECONDS, Request, check_files, checkpoint_file
from tracer.viewpoint.showcase import is_mesh_file, require_scene_file, showcase


def render(
    scene: str | Path | dict[str, Any] | Scene,
    *,
    integrator: str | dict[str, Any] | Integrator | None = None,
    sensor: int | Sensor = 0,
    size: Size = None,
    crop: Crop = None,
    define: dict[str, str] | None = None,
    spp: int | None = None,
    noise: float | None = None,
    noise_share: float | None = None,
    time: float | None = None,
    seed: int | None = None,
    criterion: str | Path | Criterion | Callable[[Evidence], Floats] | None = None,
    objective: Literal["relative", "absolute", "display"] | None = None,
    exposure: float | None = None,
    importance: str | Path | ArrayLike | None = None,
    shape_weights: Mapping[str, float] | Mapping[int, float] | str | None = None,
    guide: bool | None = None,
    unbiased: bool | None = None,
    min_spp: int | None = None,
    max_spp: int | None = None,
    pilot_spp: int | None = None,
    cost: Literal["none", "root", "work"] | None = None,
    block: int | None = None,
    denoise: bool = False,
    features: bool = False,
    checkpoint: str | Path | None = None,
    checkpoint_every: float = EVERY_SECONDS,
    resume: bool = False,
    overwrite: bool = False,
    progress: ProgressCallback | None = None,
    memory_limit: float | None = None,
    cluster: int | str | DaskClient | None = None,
    started: float | None = None,
    **unknown: Never,
) -> Result:
    """Render a scene, and return its picture, the samples and the error of every pixel, and a report.

    Example::

        import tracer

        result = tracer.render("scene.xml", spp=64)  # or noise=0.05, or time=60
        result.image  # (H, W, C) float32, linear
        result.save("scene.exr")

    What is rendered:
        scene: path of a Mitsuba scene file (XML), a dictionary as for mi.load_dict, or an mi.Scene, which is prepared
            faster when it is rendered again unchanged. The path of a mesh file shows the mesh from its best view.
        integrator: plugin name, dictionary or mi.Integrator instead of the scene's.
        sensor: number of the scene's sensor, from 0, or an mi.Sensor.
        size: width in pixels (the aspect is kept), or (width, height). Default: the film's.
        crop: x, y, width and height in pixels of the part that is rendered. Default: the film's.
        define: values of the $parameters of a scene file, by name.

    When to stop; the first that is reached ends the render:
        spp: mean samples per pixel, 1 to 2^24. Default: as many as the scene's sampler has; 64 if that is 4, which
            Mitsuba takes where a scene says nothing. With noise or time it is a bound: 4096 or 65536 by default.
        noise: error, as a part of the pixel's brightness: 0.05 is 5 %. Default: no target.
        noise_share: share of the pixels that are to be within noise. Default: 0.95.
        time: seconds, start-up included. Default: no limit.

    Where the samples go. None means what the scene's integrator says if it is "adaptive", else the default:
        criterion: rule that decides, a name such as "fused" or "uniform" (tracer.criteria.names() has all of them), a
            Python file that defines one, a tracer.criteria.Criterion, or a function from tracer.criteria.Evidence to
            the importance of each pixel (H, W), >= 0. Default: "fused".
        objective: which error is to be small: "relative" to the brightness, "absolute", or on the "display" of a
            screen. Default: "relative".
        exposure: stops by which the picture will be brightened before it is looked at, -64 to 64. Default: 0.
        importance: image file or array (H, W) >= 0, a mask or weights, that multiplies the importance.
        shape_weights: factors 0 to 10^6 of the importance where shapes are seen, by their id or number: {"lamp": 4}.
        guide: whether to learn, before the first sample, which lights matter where. Default: where it may pay.
        unbiased: whether samples that decide are left out of the picture. Default: False.
        min_spp, max_spp: least and most samples of any pixel. Default: an eighth of spp, and 32 times spp.
        pilot_spp: pilot rays per pixel, and samples of the first round. Default: chosen by the budget.
        cost: what a sample is taken to cost: the same everywhere, "none"; the "work" of its path; or the "root" of
            that, between both. Default: "root".
        block: side, 1 to 64 pixels, of the squares over which complexity is measured. Default: 1.
        seed: seed of all random numbers, 0 to 2^32 - 1; the same seed gives the same picture. Default: 0.

    What else is made, and how:
        denoise: whether to take the noise out of the picture with Open Image Denoise.
        features: whether to return what the camera's rays hit first: albedo, normal, depth and shape.
        checkpoint: file in which the state is kept while the picture is rendered, and at the end.
        checkpoint_every: seconds between two writes of it. Default: 60.
        resume: whether to go on from the checkpoint if it exists.
        overwrite: whether to begin anew and replace the checkpoint.
        progress: function that is called with a tracer.Progress after every pass, and returns False to stop.
        memory_limit: most memory in GiB; passes are made small enough for it.
        cluster: workers that draw: their number on this machine, the address of a Dask scheduler, or a
            distributed.Client. The picture is the same, and the scene must be a file. Default: this process draws.
        started: value of time.perf_counter() from which time counts. Default: now.

    Sets the Mitsuba variant llvm_ad_rgb unless one is active. Mistakes raise the errors of tracer.errors, whose message
    is one sentence; a checkpoint cannot be combined with a criterion that has no registered name.
    """
    started = now() if started is None else started
    require_keywords(unknown)
    require_terms(progress, checkpoint_every, memory_limit, define)
    given: dict[str, Any] = {
        "spp": spp,
        "noise": noise,
        "noise_share": noise_share,
        "time": time,
        "seed": seed,
        "criterion": criterion_name(criterion, checkpoint),
        "objective": objective,
        "exposure": exposure,
        "shape_weights": shape_weights,
        "guide": guide,
        "unbiased": unbiased,
        "min_spp": min_spp,
        "max_spp": max_spp,
        "pilot_spp": pilot_spp,
        "cost": cost,
        "block": block,
    }
    if isinstance(importance, str | Path):
        given["importance"], importance = str(importance), None
    settings = {name: value for name, value in given.items() if value is not None}
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


def criterion_name(
    criterion: str | Path | Criterion | Callable[[Evidence], Floats] | None, checkpoint: str | Path | None
) -> Any:
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


def require_keywords(unknown: Iterable[str]) -> None:
    """Raise SettingsError if there is any keyword that ``render`` does not have; it offers the nearest that it has."""
    name = next(iter(unknown), None)
    if name is not None:
        parameters = [parameter for parameter in inspect.signature(render).parameters if parameter != "unknown"]
        raise SettingsError(f"There is no setting '{name}'{did_you_mean(name, parameters)}")


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

"""Carry out a job: load, render and write picture after picture."""

from __future__ import annotations

import itertools
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

from tracer import live
from tracer.core import backend
from tracer.core.wording import option
from tracer.errors import SceneError, SettingsError, WriteError
from tracer.image.colour import display
from tracer.io import exr
from tracer.jobs.job import Job, Shot, check_frames, check_outputs, shots_of
from tracer.progress import ProgressCallback
from tracer.result import Result
from tracer.scene.fingerprint import fingerprint
from tracer.scene.load import describe, load
from tracer.scene.view import open_scene, pick_sensor
from tracer.session import checkpoint, memory, output
from tracer.session.checkpoint import Keeper
from tracer.session.output import metadata
from tracer.session.render_loop import render_view
from tracer.session.shards import parse_part, share
from tracer.session.terms import DrawerFor, Terms
from tracer.settings import check_settings, make_settings

Hire = Callable[..., DrawerFor]
"""See ``tracer.cluster.remote_drawer``."""
Tell = Callable[[str], None]
"""Shows a sentence to a person."""


def perform(
    job: Job, progress: ProgressCallback | None = None, started: float | None = None, tell: Tell = lambda text: None
) -> Iterator[tuple[Shot, Result]]:
    """Yield each picture as it is written, and what it is of; one that a person has stopped is the last.

    ``started``: as for ``tracer.render``, for the first picture. ``tell`` hears of large jobs before they begin. What
    can be checked before the first ray is. Raises the errors of ``tracer.errors``.
    """
    check_settings(**job.settings)
    if job.resume and job.checkpoint is None:
        raise SettingsError(
            f"There is nothing to resume from: name the checkpoint with {option('checkpoint', 'FILE')}."
        )
    if job.workers is not None and job.scheduler is not None:
        raise SettingsError("Name workers or a scheduler, not both.")
    check_frames(job)
    check_outputs(list(shots_of(job, 1)), job)
    backend.activate(job.variant)
    with ExitStack() as stack:
        yield from pictures(job, hired(job, stack), progress, started, tell)


def hired(job: Job, stack: ExitStack) -> Hire | None:
    """Return how workers are found that draw until ``stack`` closes; None if this process draws."""
    if job.workers is None and job.scheduler is None:
        return None
    from tracer.cluster.remote_drawer import open_remote_drawer

    return stack.enter_context(open_remote_drawer(job.workers or job.scheduler))


def pictures(
    job: Job, hire: Hire | None, progress: ProgressCallback | None, started: float | None, tell: Tell
) -> Iterator[tuple[Shot, Result]]:
    """Yield picture after picture."""
    for (path, _), several in itertools.groupby(shots_of(job, 1), lambda shot: (shot.scene, shot.define)):
        define = next(several).define
        scene_hash = fingerprint(path, define)  # of what is rendered, even if the file is edited meanwhile
        scene = load(path, define=define)
        if scene.class_name() != "Scene":
            raise SceneError(f"{describe(path)} holds a {scene.class_name()}, not a scene; wrap it in <scene>.")
        shots = [shot for shot in shots_of(job, len(scene.sensors())) if (shot.scene, shot.define) == (path, define)]
        check_outputs(shots, job)
        for shot in shots:
            pick_sensor(scene, shot.sensor, path)
        for shot in shots:
            result = picture(scene, scene_hash, shot, job, hire, progress, started, tell)
            started = None
            yield shot, result
            if not result.report.complete:
                return


def picture(
    scene: Any,
    scene_hash: str,
    shot: Shot,
    job: Job,
    hire: Hire | None,
    progress: ProgressCallback | None,
    started: float | None,
    tell: Tell,
) -> Result:
    """Render and write one picture."""
    started = time.perf_counter() if started is None else started
    keeper: Keeper | None = None
    if shot.checkpoint is not None:
        keeper = checkpoint.open_keeper(
            shot.checkpoint, scene_hash, job.resume, job.overwrite, every=job.checkpoint_every
        )
    if shot.live is not None or job.tev is not None:
        shown = live.tev(Path(shot.name).name, job.tev) if job.tev is not None else None
        progress = live.together(progress, live.png(shot.live) if shot.live is not None else None, shown)
    drawer = None
    if hire is not None:
        seen = {"integrator": job.integrator, "size": job.size, "crop": job.crop}
        drawer = hire(shot.scene, scene_hash, shot.define, shot.sensor, **seen)
    with open_scene(scene, shot.sensor, job.integrator, job.size, job.crop) as view:
        exr.check_channels(view.channels)
        settings = make_settings(**{**view.settings, **job.settings})
        if job.part is not None:
            part = parse_part(job.part)
            if keeper is not None:
                keeper.source = part.source(settings.seed)
            settings = make_settings(**{**settings.model_dump(), **share(settings, part)})
        needed = memory.need(view, settings, job.features, job.denoise, keeps=keeper is not None)
        if needed.total(size := memory.largest_pass(needed, job.memory)) > memory.LARGE:
            tell(memory.in_words(needed, size))
        terms = Terms(progress, keeper, started, job.memory, job.features, job.denoise, drawer)
        result = render_view(view, settings, terms)
    own = job.model_dump(mode="json", exclude={"settings", "overwrite", "resume"}, exclude_none=True)
    if shot.output is not None:
        if shot.output.suffix.lower() == ".exr" and job.layers == "all" and (renamed := output.renamed_layers(result)):
            result.report.note(f"Layers of tracer have the names of AOVs, which are written as {', '.join(renamed)}.")
        try:
            output.write_result(shot.output, result, {**metadata(result, scene_hash), "job": own}, job.layers)
        except WriteError as error:
            raise WriteError(f"{error} {kept(keeper)}".rstrip()) from None
    if shot.live is not None:
        try:
            exr.write_png(shot.live, display(result.rgb))
        except WriteError as error:  # a picture of progress, of what is written already
            result.report.unwritten.append(str(error))
    return result


def kept(keeper: Keeper | None) -> str:
    """Return a sentence about samples that a checkpoint has, if it has all."""
    if keeper is None or keeper.complaints or not keeper.kept:
        return ""
    return f"All samples are in the checkpoint '{keeper.path}'; make room and go on with {option('resume')}."

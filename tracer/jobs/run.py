"""Carry out a job: load, render and write picture after picture."""

from __future__ import annotations

import itertools
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

from tracer import live
from tracer.cluster import hired
from tracer.core import backend
from tracer.core.wording import Tell, silent
from tracer.errors import SettingsError, WriteError
from tracer.image.colour import display
from tracer.io import exr
from tracer.jobs.job import Job, Shot, check_frames, check_outputs, request_for, shots_of
from tracer.progress import ProgressCallback
from tracer.result import Result
from tracer.scene.loaded import LoadedScene, load_scene
from tracer.scene.view import pick_sensor
from tracer.session.render import render_request
from tracer.session.request import Request
from tracer.settings import check_settings


def perform(
    job: Job, progress: ProgressCallback | None = None, started: float | None = None, tell: Tell = silent
) -> Iterator[tuple[Shot, Result]]:
    """Yield each picture and its result as soon as it is written; a picture that a person has stopped is the last.

    ``started``: as for ``tracer.render``, for the first picture. ``tell`` is called with a remark before a large job
    begins. Mistakes are looked for before the first ray, as far as possible. Raises the errors of ``tracer.errors``.
    """
    check_settings(**job.settings)
    if job.workers is not None and job.scheduler is not None:
        raise SettingsError("Name workers or a scheduler, not both.")
    check_frames(job)
    check_outputs(list(shots_of(job, 1)), job)
    backend.activate(job.variant)
    started = time.perf_counter() if started is None else started
    with hired(job.workers or job.scheduler) as workers:
        for shot, scene in shots_with_scenes(job):
            request = request_for(job, shot, scene)
            request = replace(request, progress=progress, remark=tell, workers=workers, started=started)
            result = render_shot(job, shot, request)
            started = None
            yield shot, result
            if not result.report.complete:
                return


def shots_with_scenes(job: Job) -> Iterator[tuple[Shot, LoadedScene]]:
    """Yield the pictures of a job with their scenes; successive pictures of the same scene share the loaded scene."""
    for (path, define), _ in itertools.groupby(shots_of(job, 1), lambda shot: (shot.scene, shot.define)):
        scene = load_scene(path, define)
        shots_of_all_sensors = shots_of(job, len(scene.scene.sensors()))
        shots = [shot for shot in shots_of_all_sensors if (shot.scene, shot.define) == (path, define)]
        check_outputs(shots, job)
        for shot in shots:
            pick_sensor(scene.scene, shot.sensor, path)
        for shot in shots:
            yield shot, scene


def render_shot(job: Job, shot: Shot, request: Request) -> Result:
    """Render and write a single picture, and show it while it renders if the job asks for it."""
    if shot.live is not None or job.tev is not None:
        viewer = live.tev(Path(shot.name).name, job.tev) if job.tev is not None else None
        live_picture = live.png(shot.live) if shot.live is not None else None
        request = replace(request, progress=live.together(request.progress, live_picture, viewer))
    result = render_request(request)
    if shot.live is not None:
        try:
            exr.write_png(shot.live, display(result.rgb))
        except WriteError as error:  # no reason to fail: the picture itself is written already
            result.report.unwritten.append(str(error))
    return result

"""Carry out a job: load, render and write picture after picture."""

from __future__ import annotations

import itertools
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
from tracer.jobs.job import Job, JobPicture, check_frames, check_outputs, pictures_of, request_for
from tracer.progress import ProgressCallback
from tracer.result import Result
from tracer.scene.loaded import LoadedScene, load_scene
from tracer.scene.view import pick_sensor
from tracer.session.render import render_request
from tracer.session.request import Request, checkpoint_file
from tracer.settings import check_settings
from tracer.viewpoint.showcase import is_mesh_file, require_scene_file, showcase


def perform(
    job: Job,
    progress: ProgressCallback | None = None,
    started: float | None = None,
    tell: Tell = silent,
    stage: Tell = silent,
) -> Iterator[tuple[JobPicture, Result]]:
    """Yield each picture and its result as soon as it is written; a picture that a person has stopped is the last.

    ``started``: as for ``tracer.render``, for the first picture. ``tell`` is called with a remark before a large job
    begins, and ``stage`` as in ``Request``. Mistakes are looked for before the first ray, as far as possible. Raises
    the errors of ``tracer.errors``.
    """
    check_settings(**job.settings)
    checkpoint_file(job.checkpoint, job.checkpoint_every, job.resume, job.overwrite)  # refuses to resume from nothing
    if job.workers is not None and job.scheduler is not None:
        raise SettingsError("Name workers or a scheduler, not both.")
    check_frames(job)
    check_outputs(list(pictures_of(job, 1)), job)
    backend.activate(job.variant)
    if job.workers or job.scheduler:
        require_scene_file(job.scene)
    if job.workers or job.scheduler:
        stage("Waiting for workers")
    with hired(job.workers or job.scheduler) as workers:
        for picture, scene in pictures_with_scenes(job, stage):
            request = request_for(job, picture, scene)
            request = replace(request, progress=progress, remark=tell, stage=stage, workers=workers, started=started)
            result = render_picture(job, picture, request)
            started = None
            yield picture, result
            if not result.report.complete:
                return


def pictures_with_scenes(job: Job, stage: Tell = silent) -> Iterator[tuple[JobPicture, LoadedScene]]:
    """Yield the pictures of a job with their scenes; successive pictures of the same scene share the loaded scene."""
    for (path, define), _ in itertools.groupby(pictures_of(job, 1), lambda picture: (picture.scene, picture.define)):
        stage(f"Opening {path.name}")
        scene = showcase(Path(path)) if is_mesh_file(path) else load_scene(path, define)
        pictures_of_scene_files = pictures_of(job, len(scene.scene.sensors()))
        pictures = [picture for picture in pictures_of_scene_files if (picture.scene, picture.define) == (path, define)]
        check_outputs(pictures, job)
        for picture in pictures:
            pick_sensor(scene.scene, picture.sensor, path)
        for picture in pictures:
            yield picture, scene


def render_picture(job: Job, picture: JobPicture, request: Request) -> Result:
    """Render and write a single picture, and show it while it renders if the job asks for it."""
    if picture.live is not None or job.tev is not None:
        viewer = live.tev(Path(picture.name).name, job.tev) if job.tev is not None else None
        live_picture = live.png(picture.live) if picture.live is not None else None
        request = replace(request, progress=live.together(request.progress, live_picture, viewer))
    result = render_request(request)
    if picture.live is not None:
        try:
            exr.write_png(picture.live, display(result.rgb))
        except WriteError as error:  # no reason to fail: the picture itself is written already
            result.report.unwritten.append(str(error))
    return result

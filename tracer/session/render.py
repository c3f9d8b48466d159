"""The front door: carry out a request, whoever makes it."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any

import drjit as dr
import numpy as np

from tracer import criteria
from tracer.adaptive.importance_map import importance_weights
from tracer.adaptive.schedule import Schedule
from tracer.adaptive.stopping import Clock
from tracer.core.quantities import samples_in_words
from tracer.denoising.oidn import load as load_denoiser
from tracer.denoising.postprocess import draw_denoising_features
from tracer.errors import ClusterError, SettingsError
from tracer.guiding.effort import MOST_PATHS
from tracer.io import exr
from tracer.report import Report
from tracer.result import Result
from tracer.sampling.samples import make_sampler
from tracer.scene.loaded import LoadedScene
from tracer.scene.view import View, open_scene
from tracer.session import memory
from tracer.session.checkpoint import was_guided
from tracer.session.develop import finish
from tracer.session.first_look import FirstLook
from tracer.session.guidance import Terms, begin_guided, choose_by, is_guided, with_guide
from tracer.session.keeper import make_keeper
from tracer.session.local_drawer import Drawer, DrawerFor, LocalDrawer
from tracer.session.output import write_picture
from tracer.session.planner import Planner
from tracer.session.progress_reporter import ProgressReporter
from tracer.session.recorder import Recorder
from tracer.session.render_loop import Rendering
from tracer.session.request import Request, check_files, scene_hash_of
from tracer.session.shards import settings_of_part
from tracer.session.state import State
from tracer.settings import OPEN_SPP, Settings, make_settings

FEATURE_SECONDS, DENOISE_SECONDS = 6e-6, 4e-6
"""Seconds per pixel that drawing features and denoising take, kept back for the end where time is limited."""


def render_request(request: Request) -> Result:
    """Render one picture and write it where the request says. Raises the errors of ``tracer.errors``.

    All that can be refused is refused before the first sample. A Mitsuba variant must be active.
    """
    started = time.perf_counter() if request.started is None else request.started
    check_files(request)
    scene_hash = scene_hash_of(request)
    request.stage("Opening the scene")
    drawer_for = None if request.workers is None else request.workers(request, scene_hash)
    with open_view(request) as view:
        with begun(request, view, scene_hash, drawer_for, started) as rendering:
            result, keeper = complete(rendering, request), rendering.keeper
        del rendering  # its sums: writing takes memory of its own
    if request.picture is not None:
        request.stage(f"Writing {request.picture.path.name}")
        write_picture(request.picture, result, scene_hash, keeper)
    return result


@contextmanager
def open_view(request: Request) -> Iterator[View]:
    """Open the view that is asked for, if it is not."""
    if isinstance(request.scene, View):
        yield request.scene
        return
    source, define = request.scene, request.define
    if isinstance(source, LoadedScene):
        source, define = source.scene, None
    with open_scene(source, request.sensor, request.integrator, request.size, request.crop, define) as view:
        yield view


@contextmanager
def begun(
    request: Request,
    view: View,
    scene_hash: str | None = None,
    drawer_for: DrawerFor | None = None,
    started: float | None = None,
) -> Iterator[Rendering]:
    """Make all that the render of an open view needs, and let go of it at the end.

    ``scene_hash``: that of the request, if it is known; ``drawer_for``: makes who draws, if that is not this process;
    ``started``: as for ``Request``.
    """
    scene_hash = scene_hash_of(request) if scene_hash is None else scene_hash
    settings, samples_name = settings_of(request, view)
    file = request.checkpoint
    asked_view, view = view, with_guide(view, settings, was_guided(file.path) if file and file.goes_on else None)
    recorder = Recorder(Report(settings))
    clock = Clock(settings.time, recorder.start if started is None else started, view.pixel_count)
    clock.keep_back(view.pixel_count * (FEATURE_SECONDS * request.features + DENOISE_SECONDS * request.denoise))
    if request.picture is not None or request.part is not None:  # parts are written when they are merged
        exr.check_channels(view.channels)
    if request.denoise:
        load_denoiser()  # before the work, not after
    request.stage("Taking a first look")
    needed = memory.need(view, settings, request.features, request.denoise, file is not None)
    with dr.suspend_grad(), closing(make_drawer(request, view, settings, needed, drawer_for)) as drawer:
        remarks: list[str] = []
        weights = importance_weights(view, settings, make_sampler(), request.importance, remarks.append)
        criterion = criteria.get(settings.criterion)
        schedule = Schedule(settings, criterion, view.pixel_count, clock, view.object_count)
        state = State.beginning(drawer.empty(), settings)
        at_risk = drawer_for is not None
        keeper = make_keeper(request, asked_view, settings, weights, scene_hash, samples_name, at_risk)
        if keeper is not None:
            state = keeper.load(state, drawer.empty())
            if state.done:
                request.remark(f"Going on from {samples_in_words(state.done / view.pixel_count)} in the checkpoint.")
            state.plan_anew(schedule.budget)
        state.meter.counted = (weights > 0)[view.inner] if np.any(weights == 0) else None
        recorder.begin(state, remarks)
        if is_guided(view):
            request.stage("Learning which lights matter where")
        begin_guided(view, settings, recorder, state, terms_of_learning(request, needed))
        if keeper is not None and state.features is None:
            request.stage("Looking at albedo, normal and depth")
            with recorder.timing("seconds_features"):
                state.features = draw_denoising_features(view, make_sampler(), settings.seed)
        planner = Planner(view, settings, criterion, weights, FirstLook(view, settings, recorder), recorder)
        if criterion.needs_radiance and len(schedule.goals) == 1:
            recorder.report.note(schedule.why_uniform())
        reporter = ProgressReporter(request.progress, schedule, recorder)
        request.stage("Compiling the scene")
        try:
            yield Rendering(view, state, planner, drawer, schedule, keeper, reporter, recorder)
        finally:
            choose_by(view, None)  # what was learned is of this picture


def complete(rendering: Rendering, request: Request) -> Result:
    """Run a render that has begun to its end. Raises ClusterError, which says what is kept, if workers fail."""
    try:
        rendering.run()
        request.stage("Taking out the noise" if request.denoise else "Developing the picture")
        return finish(rendering, request.features, request.denoise)
    except ClusterError as error:
        raise type(error)(f"{error} {rendering.what_is_kept()}") from None


def settings_of(request: Request, view: View) -> tuple[Settings, str]:
    """Return the settings of a render, and what its samples are called in a checkpoint. Raises SettingsError."""
    given = request.settings
    settings = (
        given if isinstance(given, Settings) else make_settings(**with_spp_of_scene({**view.settings, **given}, view))
    )
    if request.part is None:
        return settings, f"seed {settings.seed}"
    part = make_settings(**{**settings.model_dump(), **settings_of_part(settings, request.part)})
    return part, request.part.source(settings.seed)


def with_spp_of_scene(given: dict[str, Any], view: View) -> dict[str, Any]:
    """Return settings that are given, with the samples of the scene's sampler if nothing given says when to stop."""
    if view.asked_spp is None or any(given.get(name) is not None for name in ("spp", *OPEN_SPP)):
        return given
    return {**given, "spp": view.asked_spp}


def terms_of_learning(request: Request, needed: memory.Need) -> Terms:
    """Return on which terms a render learns."""
    most_paths = memory.most_learning_paths(needed, request.memory_limit, MOST_PATHS)
    return Terms(keep=was_open(request), most_paths=most_paths)


def make_drawer(
    request: Request, view: View, settings: Settings, needed: memory.Need, drawer_for: DrawerFor | None
) -> Drawer:
    """Return who draws, in passes that fit into the memory. Raises SettingsError if no passes do."""
    largest_pass = memory.largest_pass(needed, request.memory_limit)
    if needed.total(largest_pass) > memory.LARGE:
        request.remark(memory.in_words(needed, largest_pass))
    criterion = criteria.get(settings.criterion)
    if drawer_for is not None:
        if criterion.moments is not None and not criterion.is_built_in:
            raise SettingsError(
                f"The criterion '{criterion.name}' measures samples as they are drawn, which workers cannot do for a "
                "criterion that does not come with tracer: render without workers."
            )
        return drawer_for(view, criterion, largest_pass)
    return LocalDrawer(view, criterion.moments, largest_pass, keep=was_open(request))


def was_open(request: Request) -> bool:
    """Return whether the scene of a request was open before; else there is no next render of it."""
    return not isinstance(request.scene, str | Path | dict)

"""The end of a render: from sums to the picture, and all that is known about it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tracer.core.arrays import Singles
from tracer.core.quantities import samples_in_words
from tracer.denoising.postprocess import draw_denoising_features, see, without_noise
from tracer.denoising.refilter import FilterShape
from tracer.film import bias
from tracer.result import Result
from tracer.sampling.samples import make_sampler
from tracer.scene.view import View
from tracer.session.render_loop import Rendering

FEWEST_TO_DENOISE = 8
"""Samples per pixel below which a person is warned that a denoised picture will have spots."""


def finish(rendering: Rendering, features: bool, denoise: bool) -> Result:
    """Keep what was drawn, develop it, and tell the caller of the end."""
    state, report = rendering.state, rendering.recorder.report
    report.stopped_by = rendering.schedule.stopped_by
    if rendering.keeper is not None:
        rendering.keeper.save(state)
        report.unwritten += rendering.keeper.complaints
        report.notes = [*report.notes, *rendering.keeper.complaints]
    with rendering.recorder.timing("seconds_adding"):
        state.estimate = state.estimate.here()
    if state.held_out is not None and (state.allocation is not None or not report.complete):
        state.estimate.merge(state.held_out.here())
        report.note("Not unbiased, as it was stopped: the samples that decided are in the picture.")
    result = develop(rendering, features, denoise)
    rendering.reporter.tell_the_end(state, result.image, result.samples)
    return result


def develop(rendering: Rendering, features: bool, denoise: bool) -> Result:
    """Return the picture and all that is known about it."""
    view, state, schedule, recorder = rendering.view, rendering.state, rendering.schedule, rendering.recorder
    settings, report = schedule.settings, recorder.report
    with recorder.timing("seconds_developing"):
        image, stderr = state.estimate.develop()
        statistics = state.estimate.statistics()
    if schedule.noise is not None:  # the last round may have been cut short
        schedule.noise = state.meter.look(view, settings, image, stderr)
    entropy = rendering.planner.first_look.complexity.shape_entropy if state.looked else None
    drawn = view, make_sampler(), settings.seed
    with recorder.timing("seconds_features"):
        seen = see(*drawn, statistics.count) if features else None
    unbiased = state.unbiased_mean(statistics) if rendering.planner.loses_light else None
    bright = bias.with_lost_light(view, image, stderr, statistics, unbiased)
    report.light_given_back = bias.light_added(bright, image, view.colour_channels)
    noisy = None
    if denoise:
        noisy = bright[..., : view.colour_channels]
        with recorder.timing("seconds_denoising"):
            denoising_features = state.features or draw_denoising_features(*drawn)
            clean = without_noise(view, FilterShape.of(view.film.rfilter()), denoising_features, image, statistics)
        bright = bias.with_lost_light(view, clean, stderr, statistics, unbiased)
    report.elsewhere = rendering.drawer.describe()
    report.describe(view, statistics, state.done, schedule.noise)
    if denoise and report.spp < FEWEST_TO_DENOISE:
        report.note(
            f"Denoised from {samples_in_words(report.spp)}: with fewer than {FEWEST_TO_DENOISE}, noise can hardly be "
            "told from what is there, and spots stay; allow more samples or time, or make the picture smaller."
        )
    if not view.scene.emitters() and not np.any(bright[..., : view.colour_channels]):
        report.note("The picture is black, as the scene has no emitter: add a light, or something that shines.")
    return Result(
        image=bright,
        samples=statistics.count[view.inner],
        stderr=stderr,
        complexity=layer(view, entropy),
        importance=layer(view, state.importance),
        cost=statistics.work[view.inner],
        noisy=noisy,
        seen=seen,
        channels=list(view.channels),
        window=view.window,
        seconds=recorder.seconds,
        report=report,
    )


def layer(view: View, values: NDArray | None) -> Singles:
    """Return the part of ``values`` (grid) that is in the image; zeros if there are none."""
    return (np.zeros(view.grid) if values is None else values)[view.inner].astype(np.float32)

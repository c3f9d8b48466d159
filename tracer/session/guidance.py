"""Let the integrator of a render learn which lights matter where, before the first sample is drawn."""

from __future__ import annotations

import atexit
import re
from dataclasses import replace
from functools import lru_cache
from typing import Any

import mitsuba as mi
import numpy as np

from tracer.core.arrays import Floats
from tracer.guiding.learn import Lesson, brightness, learn, path_noise, path_weights
from tracer.guiding.slots import slots_of
from tracer.guiding.table import LightChances, LightTable
from tracer.guiding.training import Paths, Trials, joined
from tracer.scene.view import View
from tracer.session.recorder import Recorder
from tracer.session.recordings import recorded_training
from tracer.session.state import State
from tracer.settings import Settings

LOOK_KEY, TRAINING_KEY = 0x100C, 0x7EAC
"""Keep samples that teach apart from those that make the picture."""
LOOK_SHARE, TRAINING_SHARE = 0.015, 0.06
"""Parts of the samples of a picture that are drawn to find out whether there is anything to learn, and to learn it."""
MOST_LOOK_PATHS, MOST_PATHS = 1 << 18, 1 << 20
"""Most paths of these two."""
LEAST_PATHS = 1 << 11
"""Fewest paths from which anything is learned."""
FIXED_PATHS = 1 << 16
"""Number of paths that take as long as the part of learning that does not depend on their number."""
DEARER = 1.08
"""How many times as long a path is taken to take whose lights are chosen by a table; it was 1.05 to 1.2 times."""
WORTH_A_LOOK = 1.04
"""Factor by which the variance must be expected to fall after a first look for more paths to be drawn. It falls further
than expected, as what one half of the paths has taught is judged by the other."""
OPEN_SPP = 64
"""Samples per pixel for which a picture learns that ends with a noise target or a time, if not fewer are allowed."""
MANY_LIGHTS, HOPE, HOPE_FOR_MANY = 16, 1.25, 3.0
"""Factor by which the variance may be hoped to fall before anything is known, in general, and with so many lights."""


def pays(gain: float, path_count: int, taught: int) -> bool:
    """Return whether a picture of ``path_count`` paths is better for its time if the variance falls ``gain``-fold.

    ``taught``: paths that learning takes.
    """
    return gain * path_count > DEARER * path_count + taught + FIXED_PATHS


def with_guide(view: View, settings: Settings) -> View:
    """Return a view whose integrator can learn about lights, if that is asked for and possible; else the same view.

    The setting ``guide`` asks for it; left out, the integrator ``guided`` does.
    """
    if is_guided(view) or (settings.guide and view.integrator.class_name() == "PathIntegrator"):
        view = guided_view(view)
        choose_by(view, None)
    return view


def is_guided(view: View) -> bool:
    """Return whether the integrator of a view is ``guided``. Every variant has a class of its own of that name."""
    return type(getattr(view, "integrator", None)).__name__ == "GuidedIntegrator"


def guided_view(view: View) -> View:
    """Return a view with the integrator ``guided`` in place of ``path``."""
    path = view.integrator
    return view if is_guided(view) else replace(view, integrator=guided_like(path, path.hide_emitters))


def choose_by(view: View, learned: LightChances | None) -> None:
    """Let the integrator, if it is ``guided``, choose lights by what was learned; None: all with the same chance."""
    if not is_guided(view):
        return
    scene = view.scene
    view.integrator.learned = learned
    view.integrator.table = None if learned is None else LightTable.of(scene, slots_of(scene), learned)


def packed_guide(view: View) -> dict[str, Any] | None:
    """Return what the integrator of a view chooses lights by, as arrays; None: all with the same chance."""
    learned: LightChances | None = view.integrator.learned if is_guided(view) else None
    return None if learned is None else learned.pack()


@lru_cache(maxsize=4)
def guided_like(path: Any, hide_emitters: bool) -> Any:
    """Return an integrator ``guided`` with the parameters of a ``path``, which tells them only as text.

    It is the same one for the same ``path``, so that what is recorded of it can be used again.
    """
    numbers = {name: int(value) for name, value in re.findall(r"(max_depth|rr_depth) = (\d+)", str(path))}
    numbers = {name: -1 if value >= 2**31 else value for name, value in numbers.items()}
    return mi.load_dict({"type": "guided", **numbers, "hide_emitters": hide_emitters})


atexit.register(guided_like.cache_clear)  # before Mitsuba is unloaded


def begin_guided(view: View, settings: Settings, recorder: Recorder, state: State, keep: bool) -> None:
    """Learn about lights if the view can and nothing is drawn yet, or take over what the state has learned.

    ``keep``: as for ``learn_lights``.
    """
    if not is_guided(view):
        if settings.guide:
            name = view.integrator.class_name()
            recorder.report.note(f"Not guided: that takes the integrator 'path' or 'guided', and this is a {name}.")
        return
    if state.done == 0 and state.guide is None and settings.guide is not False:
        with recorder.timing("seconds_guiding"):
            spp = min(settings.spp, OPEN_SPP) if settings.is_open else settings.spp
            lesson = learn_lights(view, spp, settings.seed, settings.objective, settings.exposure, keep)
        if lesson is not None:
            state.guide = lesson.learned
            recorder.report.note(
                f"Guided: {lesson.path_count} paths have taught which lights matter where; the variance is expected to "
                f"fall {lesson.gain:.2f}-fold."
            )
    choose_by(view, state.guide)


def learn_lights(
    view: View, spp: int, seed: int, objective: str = "relative", exposure: float = 0.0, keep: bool = False
) -> Lesson | None:
    """Return what a few paths of a guided view teach, or None if that is not worth the time it takes to use it.

    ``spp``: samples per pixel that the picture will have; ``objective``, ``exposure``: see ``tracer.settings``;
    ``keep``: whether the next render of the scene may use what is recorded in this one.
    """
    plan = slots_of(view.scene) if view.scene.emitters() else None
    total = spp * view.pixel_count
    look_count, most = min(int(LOOK_SHARE * total), MOST_LOOK_PATHS), min(int(TRAINING_SHARE * total), MOST_PATHS)
    if plan is None or len(plan.stock) < 2 or look_count < LEAST_PATHS or not all_alike(view.scene):
        return None
    if not pays(HOPE if len(plan.order) < MANY_LIGHTS else HOPE_FOR_MANY, total, most):
        return None

    with recorded_training(view, keep) as trainer:

        def weighed(learned: LightChances, path_count: int, key: int) -> tuple[Paths, Floats, Trials, Floats]:
            table = LightTable.of(view.scene, plan, learned)
            paths, trials = trainer.train(table, (seed ^ key) & 0xFFFFFFFF, path_count)
            level = brightness(paths.pixel, paths.radiance, view.grid)
            weight = path_weights(objective, exposure, level)
            return paths, weight, trials, np.square(trials.given) * weight[trials.path]

        nothing = LightChances.stock(plan)
        paths, weight, trials, squares = weighed(nothing, look_count, LOOK_KEY)
        noise, path_count = path_noise(paths, weight), paths.pixel.size
        lesson = learn(trials, squares, path_count, noise, plan)
        more = most - path_count
        if lesson is not None and lesson.gain > WORTH_A_LOOK and more > 0:
            paths, _, further, further_squares = weighed(lesson.learned, more, TRAINING_KEY)
            trials, squares = joined(trials, path_count, further), np.concatenate([squares, further_squares])
            path_count += paths.pixel.size
            lesson = learn(trials, squares, path_count, noise, plan)
    return lesson if lesson is not None and pays(lesson.gain, total, 0) else None


def all_alike(scene: Any) -> bool:
    """Return whether Mitsuba chooses all lights with the same chance: a person may have given them weights."""
    return len({light.sampling_weight() for light in scene.emitters()}) == 1

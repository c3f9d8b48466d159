"""Let the integrator of a render learn which lights matter where, before the first sample is drawn."""

from __future__ import annotations

import atexit
import re
from collections.abc import Hashable
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, Protocol, cast

import mitsuba as mi

from tracer.core.protocols import Integrator
from tracer.guiding.chosen import choose
from tracer.guiding.effort import (
    FIRST_COST,
    LEARNING_COST,
    LEAST_PATHS,
    MANY_LIGHTS,
    MOST_PATHS,
    LearningCurve,
    block_length,
    is_worth_a_look,
    look_paths,
    pays,
)
from tracer.guiding.evidence import Judgement, Taught, error_left
from tracer.guiding.learn import Lesson, learn
from tracer.guiding.slots import SlotPlan, slots_of
from tracer.guiding.table import LightChances, LightTable
from tracer.scene.view import View
from tracer.session.not_guided import NOT_WORTH_IT, is_path, why_not_guided
from tracer.session.recorder import Recorder
from tracer.session.recordings import recorded_training
from tracer.session.state import State
from tracer.settings import Settings

GUIDED = "GuidedIntegrator"
"""Name of the class of the integrator ``guided``: every variant has a class of its own of that name."""
MOST_LOST = 0.04
"""Part of the time of a picture that a look may take which nobody has asked for: it may be in vain."""
LEAST_UNASKED, LEAST_SECONDS = 1 << 21, 60.0
"""Fewest paths of a picture of many lights that learns unasked, and fewest seconds of a picture that has a limit. A
look in vain then takes up to a third of the time; but with many lights most are not, and the variance falls to half or
less."""
LEARNING_SPP = 16
"""Samples per pixel for which a picture learns that ends with a noise target or a time, if not fewer are allowed."""


def with_guide(view: View, settings: Settings, was_guided: bool | None = None) -> View:
    """Return a view whose integrator can learn about lights, if that is asked for and possible; else the same view.

    The setting ``guide`` asks for it, or the integrator ``guided``. If it is left out, ``path`` learns where a look in
    vain would not be felt. ``was_guided``: whether the render that is gone on with did; None for a new one.
    """
    learns = learns_for(view, settings) if was_guided is None else was_guided
    if is_guided(view) or (is_path(view.integrator) and learns):
        view = guided_view(view)
        choose_by(view, None)
    return view


def learns_for(view: View, settings: Settings) -> bool:
    """Return whether a new render looks for something to learn."""
    if not settings.guide:
        return learns_unasked(view, settings)
    return is_worth_a_look(learning_spp(settings) * view.pixel_count, len(view.scene.emitters()))


def learns_unasked(view: View, settings: Settings) -> bool:
    """Return whether to look for something to learn although nobody has asked for it.

    The criterion "uniform" is what others are measured by: there only who asks for it learns.
    """
    is_short = settings.time is not None and settings.time < LEAST_SECONDS
    if settings.guide is not None or settings.criterion == "uniform" or is_short:
        return False
    total, light_count = learning_spp(settings) * view.pixel_count, len(view.scene.emitters())
    is_unfelt = LEARNING_COST * 2 * look_paths(total) + FIRST_COST <= MOST_LOST * total
    return (light_count >= MANY_LIGHTS and total >= LEAST_UNASKED) or (light_count > 0 and is_unfelt)


def learning_spp(settings: Settings) -> int:
    """Return the samples per pixel for which a picture learns."""
    return min(settings.spp, LEARNING_SPP) if settings.is_open else settings.spp


class Guided(Integrator, Protocol):
    """What the integrator ``guided`` has beside others."""

    max_depth: int
    """Most vertices of a path."""
    table: LightTable | None
    """By which it chooses lights; None: all with the same chance."""
    learned: LightChances | None
    """The same as arrays."""


def is_guided(view: View) -> bool:
    """Return whether the integrator of a view is ``guided``, or has it nested in it, as ``aov`` may."""
    return guided_of(view) is not None


def guided_of(view: View) -> Guided | None:
    """Return the integrator ``guided`` of a view or the first one nested in its integrator; None if there is none."""
    integrator = getattr(view, "integrator", None)
    if integrator is None or type(integrator).__name__ == GUIDED:
        return cast(Guided | None, integrator)
    nested = (part for part in mi.traverse(integrator).hierarchy if type(part).__name__ == GUIDED)
    return cast(Guided | None, next(nested, None))


def require_guided(view: View) -> Guided:
    """Return the integrator ``guided`` of a view, which must have one."""
    guided = guided_of(view)
    if guided is None:
        raise ValueError("the view has no integrator 'guided'")
    return guided


def guided_view(view: View) -> View:
    """Return a view with the integrator ``guided`` in place of ``path``."""
    path = view.integrator
    return view if is_guided(view) else replace(view, integrator=guided_like(cast(Hashable, path), path.hide_emitters))


def choose_by(view: View, learned: LightChances | None, plan: SlotPlan | None = None) -> None:
    """Let the integrator, if it is ``guided``, choose lights by what was learned; None: all with the same chance.

    ``plan``: the slots of the scene, if they are known.
    """
    guided = guided_of(view)
    if guided is None:
        return
    scene = view.scene
    guided.learned = learned
    guided.table = None if learned is None else LightTable.of(scene, plan or slots_of(scene), learned)


def packed_guide(view: View) -> dict[str, Any] | None:
    """Return what the integrator of a view chooses lights by, as arrays; None: all with the same chance."""
    guided = guided_of(view)
    learned = None if guided is None else guided.learned
    return None if learned is None else learned.pack()


@lru_cache(maxsize=4)
def guided_like(path: Hashable, hide_emitters: bool) -> Any:
    """Return an integrator ``guided`` with the parameters of a ``path``, which tells them only as text.

    It is the same one for the same ``path``, so that what is recorded of it can be used again.
    """
    numbers = {name: int(value) for name, value in re.findall(r"(max_depth|rr_depth) = (\d+)", str(path))}
    numbers = {name: -1 if value >= 2**31 else value for name, value in numbers.items()}
    return mi.load_dict({"type": "guided", **numbers, "hide_emitters": hide_emitters})


atexit.register(guided_like.cache_clear)  # before Mitsuba is unloaded


@dataclass(frozen=True)
class Terms:
    """On which terms a render learns."""

    keep: bool = False
    """Whether the next render of the scene may use what is recorded in this one."""
    most_paths: int = MOST_PATHS
    """From how many paths it may learn."""


def begin_guided(view: View, settings: Settings, recorder: Recorder, state: State, terms: Terms) -> None:
    """Learn about lights if the view can and nothing is drawn yet, or take over what the state has learned."""
    if not is_guided(view):
        if settings.guide:
            recorder.report.note(why_not_guided(view))
        return
    state.guided = True
    if state.done == 0 and state.guide is None and settings.guide is not False:
        with recorder.timing("seconds_guiding"):
            spp = learning_spp(settings)
            lesson = learn_lights(view, spp, settings.seed, settings.objective, settings.exposure, terms)
        if lesson is not None:
            state.guide = lesson.learned
            recorder.report.note(
                f"Guided: {lesson.path_count} paths have taught which lights matter where; the variance is expected to "
                f"fall {lesson.gain:.2f}-fold."
            )
            choose_by(view, lesson.learned, lesson.plan)
            return
        if settings.guide:
            recorder.report.note(NOT_WORTH_IT)
    choose_by(view, state.guide)


def learn_lights(
    view: View,
    spp: int,
    seed: int,
    objective: str = "relative",
    exposure: float = 0.0,
    terms: Terms = Terms(),
) -> Lesson | None:
    """Return what a few paths of a guided view teach, or None if that is not worth the time it takes to use it.

    ``spp``: samples per pixel that the picture will have; ``objective``, ``exposure``: see ``tracer.settings``.
    """
    view = replace(view, integrator=require_guided(view))
    plan = slots_of(view.scene) if view.scene.emitters() else None
    total = spp * view.pixel_count
    teachers = judges = min(look_paths(total), terms.most_paths) // 2
    if plan is None or len(plan.stock) < 2 or teachers < LEAST_PATHS or not all_alike(view.scene):
        return None
    if not is_worth_a_look(total, len(plan.order)):
        return None

    block = block_length(judges, spp)
    lesson: Lesson | None = None
    taught: Taught | None = None
    judgements: list[Judgement] = []
    curve = LearningCurve(most_paths=terms.most_paths)
    with recorded_training(view, terms.keep) as trainer:
        while teachers > 0:
            known = 0 if taught is None else taught.path_count
            chosen = choose(view.grid, judges // (2 * block), block, known // 2, teachers // 2)
            table = LightTable.of(view.scene, plan, LightChances.stock(plan) if lesson is None else lesson.learned)
            paths, trials = trainer.train(table, seed, len(judgements), chosen)
            taught = Taught.of(paths, trials, view.grid, objective, exposure).after(taught)
            judgements.append(Judgement.of(paths))
            lesson = learn(taught, plan)
            if lesson is None:
                return None
            measured = error_left(judgements[0], judgements[-1], view.grid, objective, exposure)
            curve.add(taught.path_count, 1 / lesson.gain, *measured)
            teachers = curve.further_paths(total)
    is_sure = len(judgements) > 1 and pays(curve.believed_gain(len(plan.order)), total)
    return replace(lesson, gain=curve.gain()) if lesson is not None and is_sure else None


def all_alike(scene: Any) -> bool:
    """Return whether Mitsuba chooses all lights with the same chance: a person may have given them weights."""
    return len({light.sampling_weight() for light in scene.emitters()}) == 1

"""Recordings of how samples are drawn, kept from one render of a scene to the next.

To record a scene of 1000 shapes takes two seconds; to draw a small picture with the recording, a quarter of one. Dr.Jit
takes arrays that have changed since then as inputs, but not the numbers of the scene that are no arrays. So a recording
serves again only if all parameters that Mitsuba tells of the scene are the same objects as before.

A recording keeps its scene in memory. Mitsuba's objects cannot be referenced weakly, so whenever Python collects
garbage, and before every render, recordings of scenes that nobody else holds are let go.
"""

from __future__ import annotations

import atexit
import gc
import sys
import threading
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, closing, contextmanager
from dataclasses import dataclass
from typing import Any

import drjit as dr
import mitsuba as mi

from tracer.guiding.training import Trainer
from tracer.sampling.recordable import Recordable
from tracer.sampling.samples import Moments, Recorded, make_sampler
from tracer.scene.view import View

MOST_KEPT = 6
"""Most recordings that are kept, those used last."""


@dataclass(frozen=True)
class Subject:
    """What a recording is made of."""

    view: View
    purpose: Any
    """What the recording is for: the moments that are gathered, or the class ``Trainer``."""
    frame: tuple
    """Size and place of the picture, and its channels."""
    parameters: dict[str, Any]
    """The parameters of the scene; holding them keeps the number of a variable from being given to another one."""
    marks: dict[str, Any]
    """What tells each of the parameters apart from another value, see ``mark``."""

    @staticmethod
    def of(view: View, purpose: Any) -> Subject:
        """Return what a recording of a view would be made of now."""
        frame = (view.size, view.border, tuple(view.grid_origin), view.window, tuple(view.channels))
        parameters = parameters_of(view)
        return Subject(view, purpose, frame, parameters, {name: mark(value) for name, value in parameters.items()})

    def is_another_state_of(self, other: Subject) -> bool:
        """Return whether both are the same, but for the values of parameters."""
        mine, others = self.view, other.view
        same = mine.scene is others.scene and mine.sensor is others.sensor and mine.integrator is others.integrator
        return same and self.purpose is other.purpose and self.frame == other.frame


@dataclass(frozen=True)
class Recording:
    """How samples of a subject are drawn."""

    subject: Subject
    recorded: Recordable


kept: list[Recording] = []
"""Recordings that are not in use, those used last at the end."""
lock = threading.RLock()  # a collection of garbage may begin while the lock is held
in_use = 0
"""Number of kept recordings that are in use."""


def recorded_drawing(view: View, moments: Moments | None, keep: bool) -> AbstractContextManager[Recorded]:
    """Yield what draws samples of a view. ``keep``: whether the next render of its scene may use it again."""
    return in_use_of(view, moments, lambda: Recorded(view, make_sampler(), moments), keep)


def recorded_training(view: View, keep: bool) -> AbstractContextManager[Trainer]:
    """Yield what follows the paths from which a view learns about lights; ``keep``: as for ``recorded_drawing``."""
    return in_use_of(view, Trainer, lambda: Trainer(view, make_sampler()), keep)


@contextmanager
def in_use_of(view: View, purpose: Any, make: Callable[[], Recordable], keep: bool) -> Iterator[Any]:
    """Yield what ``make`` returns, or what it has returned before for this view and purpose."""
    if keep:
        recording = take(view, purpose, make)
        try:
            yield recording.recorded
        finally:
            give_back(recording)
    else:
        with closing(make()) as recorded:
            yield recorded


def take(view: View, purpose: Any, make: Callable[[], Recordable]) -> Recording:
    """Return a recording for a view, one that was kept if there is one; whoever takes it gives it back."""
    global in_use
    let_go_of_unused()
    subject = Subject.of(view, purpose)
    with lock:
        in_use += 1
        for found in [recording for recording in kept if recording.subject.is_another_state_of(subject)]:
            kept.remove(found)
            if found.subject.marks == subject.marks:
                found.recorded.reopen(view, make_sampler())
                return found
            found.recorded.close()
    return Recording(subject, make())


def give_back(recording: Recording) -> None:
    """Keep a recording that was taken, if it can be used again."""
    global in_use
    with lock:
        in_use -= 1
        if recording.recorded.recordable:
            recording.recorded.rest()
            kept.append(recording)
        else:
            recording.recorded.close()
        while len(kept) > MOST_KEPT:
            kept.pop(0).recorded.close()


def is_tracing() -> bool:
    """Return whether a recording or a loop is being traced, in which Dr.Jit must not let go of another recording."""
    return bool(dr.flag(dr.JitFlag.FreezingScope) or dr.flag(dr.JitFlag.SymbolicScope))


def let_go_of_unused() -> None:
    """Let go of the recordings of scenes that nobody else holds, unless something is being traced."""
    if is_tracing():
        return
    with lock:
        views = {id(recording.subject.view): recording.subject.view for recording in kept}
        own = Counter(id(view.scene) for view in views.values())
        del views
        for recording in list(kept):
            scene = recording.subject.view.scene
            # Beside our own views, this name and the argument of the function refer to the scene.
            if sys.getrefcount(scene) <= own[id(scene)] + 2:
                kept.remove(recording)
                recording.recorded.close()


@atexit.register
def let_go_of_all() -> None:
    """Let go of all recordings; at exit this happens before Mitsuba is unloaded."""
    with lock:
        while kept:
            kept.pop().recorded.close()


def parameters_of(view: View) -> dict[str, Any]:
    """Return the parameters that Mitsuba tells of scene, sensor and integrator."""
    parameters: dict[str, Any] = {}
    for number, part in enumerate((view.scene, view.sensor, view.integrator)):
        told = mi.traverse(part)
        parameters.update({f"{number} {name}": told[name] for name in told.keys()})  # noqa: SIM118
    return parameters


def mark(value: Any) -> Any:
    """Return what tells a parameter apart from another value: a number itself, an array by its variable in Dr.Jit."""
    kind = type(value)
    if kind not in markers:
        markers[kind] = marker_of(kind)
    return markers[kind](value)


markers: dict[type, Callable[[Any], Any]] = {}
"""For each type of parameters, the function that marks it."""


def marker_of(kind: type) -> Callable[[Any], Any]:
    """Return the function that marks values of a type."""
    if kind in (bool, int, float, str):
        return lambda value: value
    if hasattr(kind, "matrix"):
        return lambda value: mark(value.matrix)
    if dr.is_tensor_v(kind):
        return lambda value: (tuple(value.shape), value.array.index)
    if dr.is_array_v(kind) and dr.is_jit_v(kind):
        if dr.depth_v(kind) == 1:
            return lambda value: value.index
        return lambda value: tuple(mark(value[k]) for k in range(len(value)))
    return repr


def tidy(phase: str, information: dict[str, int]) -> None:
    """Let go of what nobody uses when Python collects garbage, unless something is being drawn."""
    # To free arrays of Dr.Jit while another thread draws can block both threads, see ``tracer.core.device.to_host``.
    if phase == "stop" and kept and in_use == 0 and threading.current_thread() is threading.main_thread():
        let_go_of_unused()


gc.callbacks.append(tidy)

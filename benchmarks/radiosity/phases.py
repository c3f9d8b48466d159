"""Where the time of a solution by radiosity goes: processor seconds of each phase, and of a picture of it."""

from __future__ import annotations

from time import process_time
from typing import Any

import drjit as dr
import mitsuba as mi

from benchmarks.harness import Announce
from benchmarks.radiosity.scenes import Example
from benchmarks.radiosity.solutions import image

PHASES = {
    "cutting": "cutting into patches",
    "lights": "rays to lights",
    "rays": "rays between patches",
    "rounds": "rounds",
    "looks": "looks that guide",
    "step": "shooting",
    "picture": "a picture",
}
"""Heading of each phase, by the first word of its progress."""
METHODS = ("gathering", "shooting")
"""Methods that are measured."""
SPP = 16
"""Samples per pixel of the picture."""


class Stopwatch:
    """Processor seconds of phases; called with the progress of a solution."""

    def __init__(self) -> None:
        self.seconds = dict.fromkeys(PHASES, 0.0)
        self.phase, self.begin = "cutting", process_time()

    def __call__(self, text: str, done: int = 0, total: int = 1) -> None:
        """End a phase, and begin that whose progress begins with its name."""
        dr.sync_thread()
        now = process_time()
        self.seconds[self.phase] += now - self.begin
        word = text.split()[0]
        self.phase, self.begin = {"round": "rounds", "ready": "picture"}.get(word, word), now


def step_count() -> int:
    """Return the number of steps of a scene."""
    return len(METHODS)


def phases(example: Example, announce: Announce) -> list[dict[str, Any]]:
    """Return the processor seconds of each phase by both methods, once all kernels are compiled."""
    rows = []
    for method in METHODS:
        announce(f"{example.name}, phases of {method}")
        integrator = mi.load_dict({"type": "radiosity", "size": example.size, "method": method})
        integrator.prepare_scene(example.scene)
        image(example, integrator, SPP, 0)
        integrator.scene = None  # so that it is solved again, now that all is compiled
        stopwatch = Stopwatch()
        integrator.prepare_scene(example.scene, stopwatch)
        image(example, integrator, SPP, 1)
        stopwatch("end")
        rows.append({"scene": example.name, "method": method, "seconds": stopwatch.seconds})
    return rows

"""After how many views one solution is cheaper than paths, in processor time, at the same error of pictures."""

from __future__ import annotations

from time import process_time
from typing import Any

import mitsuba as mi
import numpy as np

from benchmarks.harness import Announce
from benchmarks.radiosity.scenes import Example
from benchmarks.radiosity.solutions import image
from tracer.core.arrays import Floats

SPP, TURNS, TRUTH = 16, 3, 512
"""Samples per pixel of pictures, turns in which both draw them, and samples per pixel of the pictures they tend to."""


def step_count() -> int:
    """Return the number of steps of a scene."""
    return 1


def views(example: Example, announce: Announce) -> dict[str, Any]:
    """Return seconds and errors of pictures by radiosity and by paths, and the views after which radiosity is cheaper.

    The error of each is the noise against its own picture of many samples, so that the bias of patches, which
    ``bias`` tells apart, is left out. Seconds are those of all processors. ``number`` is None if paths stay cheaper.
    """
    announce(f"{example.name}, views of one solution")
    radiosity = mi.load_dict({"type": "radiosity", "size": example.size})
    path = mi.load_dict({"type": "path", "max_depth": 64, "rr_depth": 64})
    radiosity.prepare_scene(example.scene)
    radiosity.scene = None  # so that it is solved again, now that all is compiled
    start = process_time()
    radiosity.prepare_scene(example.scene)
    solved = process_time() - start
    integrators = {"radiosity": radiosity, "paths": path}
    truths = {name: image(example, integrator, TRUTH, 90) for name, integrator in integrators.items()}
    seconds: dict[str, list[float]] = {name: [] for name in integrators}
    errors: dict[str, list[float]] = {name: [] for name in integrators}
    for seed in range(TURNS + 1):
        for name, integrator in integrators.items():
            start = process_time()
            picture = image(example, integrator, SPP, seed)
            if seed:  # the first turn compiles
                seconds[name].append(process_time() - start)
                errors[name].append(mean_square(picture, truths[name]))
    drawn = {name: float(np.median(seconds[name])) for name in integrators}
    error = {name: float(np.mean(errors[name])) for name in integrators}
    as_exact = drawn["radiosity"] * error["radiosity"] / error["paths"]
    saved = drawn["paths"] - as_exact
    bias = float(np.mean(np.abs(truths["radiosity"] - truths["paths"])) / truths["paths"].mean())
    number = int(np.ceil(solved / saved)) if saved > 0 else None
    return {
        "scene": example.name,
        "solved": solved,
        "radiosity": as_exact,
        "paths": drawn["paths"],
        "bias": bias,
        "number": number,
    }


def mean_square(picture: Floats, truth: Floats) -> float:
    """Return the mean squared difference of two pictures."""
    return float(np.mean((picture - truth) ** 2))

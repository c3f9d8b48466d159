"""After how many views one solution is cheaper than paths, in processor time, at the same error of pictures."""

from __future__ import annotations

from collections.abc import Sequence
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
HALVES = (90, 91)
"""Seeds of the two pictures of ``TRUTH`` samples, whose noise is independent."""


def step_count() -> int:
    """Return the number of steps of a scene."""
    return 1


def views(example: Example, announce: Announce) -> dict[str, Any]:
    """Return seconds and errors of pictures by radiosity and by paths, and the views after which radiosity is cheaper.

    ``noise`` is the error of paths and ``apart`` the bias of the solution, both as root mean squares over the mean of
    the picture. Radiosity is given as many samples as make bias and noise together as small as the noise of paths;
    its seconds are None if its bias alone is larger. Seconds are those of all processors. ``number`` is None if paths
    stay cheaper.
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
    halves = {
        name: [image(example, integrator, TRUTH, seed) for seed in HALVES] for name, integrator in integrators.items()
    }
    truths = {name: np.mean(pictures, axis=0) for name, pictures in halves.items()}
    seconds: dict[str, list[float]] = {name: [] for name in integrators}
    errors: dict[str, list[float]] = {name: [] for name in integrators}
    for seed in range(TURNS + 1):
        for name, integrator in integrators.items():
            start = process_time()
            picture = image(example, integrator, SPP, seed)
            if seed:  # the first turn compiles
                seconds[name].append(process_time() - start)
                errors[name].append(float(np.mean((picture - truths[name]) ** 2)))
    drawn = {name: float(np.median(seconds[name])) for name in integrators}
    error = {name: float(np.mean(errors[name])) for name in integrators}
    bias = squared_bias(halves["radiosity"], halves["paths"])
    as_exact = seconds_as_exact(drawn["radiosity"], error["radiosity"], bias, error["paths"])
    brightness = float(truths["paths"].mean())
    return {
        "scene": example.name,
        "solved": solved,
        "radiosity": as_exact,
        "paths": drawn["paths"],
        "noise": float(np.sqrt(error["paths"])) / brightness,
        "apart": float(np.sqrt(bias)) / brightness,
        "number": break_even(solved, as_exact, drawn["paths"]),
    }


def squared_bias(biased: Sequence[Floats], exact: Sequence[Floats]) -> float:
    """Return the mean squared difference of what pictures tend to, from two pictures of each with independent noise.

    The noise of the first pair has nothing to do with that of the second, so that it averages out of the product.
    """
    first, second = (one - other for one, other in zip(biased, exact, strict=True))
    return max(float(np.mean(first * second)), 0.0)


def seconds_as_exact(drawn: float, error: float, bias: float, target: float) -> float | None:
    """Return the seconds of a picture whose squared bias and squared error by noise add up to ``target``.

    A picture that took ``drawn`` seconds has the squared ``error`` by noise. None if the ``bias`` alone is too large.
    """
    return drawn * error / (target - bias) if bias < target else None


def break_even(solved: float, view: float | None, paths: float) -> int | None:
    """Return the number of views from which on a solution and its views take less than views by paths, if there is one.

    ``solved``, ``view``, ``paths``: seconds of the solution, of a view of it, and of a view by paths.
    """
    return None if view is None or view >= paths else int(np.ceil(solved / (paths - view)))

"""Whole solutions and pictures, with guided and with evenly spread rays, and against the path tracer."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import astuple
from time import perf_counter
from typing import Any

import mitsuba as mi
import numpy as np

from benchmarks.harness import Announce, ratio_over_seeds
from benchmarks.radiosity.scenes import Example
from tracer.core.arrays import Floats
from tracer.radiosity.gathering import solve
from tracer.radiosity.guide import Guidance
from tracer.radiosity.meshing import cut
from tracer.radiosity.shooting import shoot

SEEDS = 4
"""Number of seeds."""
RAYS = 256
"""Rays a patch."""
SPP = 64
"""Samples per pixel of a picture."""
SIZES = (0.8, 0.4, 0.2, 0.1)
"""Longest edges of patches, for the comparison with paths."""
PATHS = 2048
"""Samples per pixel of the picture of a path tracer."""
SHOWS = ("patches", "smooth", "gather")
"""Values of the parameter ``show`` that are compared with paths."""


def step_count() -> int:
    """Return the number of steps of a scene: its solutions by gathering and by shooting, and its pictures."""
    return 2 + 1


def cornell_step_count() -> int:
    """Return the number of steps of the Cornell box: paths, pictures of patches, many patches."""
    return 1 + len(SIZES) * len(SHOWS) + 1


def solutions(example: Example, announce: Announce) -> list[dict[str, Any]]:
    """Return the gains of guidance in gathering and in shooting, from the error over all patches."""
    patches = cut(example.scene, example.size)
    distinct = Guidance("distinct", 4.0)
    solvers_by_method: dict[str, tuple[Callable[[int, int], Any], Callable[[int, int], Any]]] = {
        "gathering": (
            lambda rays, seed: solve(patches, rays, 1e-4, seed, True),
            lambda rays, seed: solve(patches, rays, 1e-4, seed, True, Guidance()),
        ),
        "shooting": (
            lambda rays, seed: shoot(patches, rays, 1e-4, seed),
            lambda rays, seed: shoot(patches, rays, 1e-4, seed, distinct),
        ),
    }
    rows = []
    for name, solvers in solvers_by_method.items():
        announce(f"{example.name}, {name}")
        truth = solvers[0](16 * RAYS, 77).radiosity
        errors, seconds = [], []
        for solver in solvers:
            solver(RAYS, 50)
            start = perf_counter()
            results = [solver(RAYS, seed).radiosity for seed in range(SEEDS)]
            seconds.append((perf_counter() - start) / SEEDS)
            errors.append([float(np.mean((result - truth) ** 2)) for result in results])
        rows.append(
            {
                "scene": example.name,
                "method": name,
                "patches": len(patches),
                "rays": RAYS,
                "equal_rays": astuple(ratio_over_seeds(errors[1], errors[0])),
                "seconds": seconds,
            }
        )
    return rows


def pictures(example: Example, announce: Announce) -> dict[str, Any]:
    """Return the gain of guided final gathers in a picture, at equal samples."""
    announce(f"{example.name}, final gather")
    integrators = [
        mi.load_dict({"type": "radiosity", "size": example.size, "spread": spread}) for spread in ("evenly", "guided")
    ]
    truth = np.mean([image(example, integrator, 32 * SPP, 90) for integrator in integrators], axis=0)
    errors, seconds = [], []
    for integrator in integrators:
        image(example, integrator, SPP, 50)
        start = perf_counter()
        images = [image(example, integrator, SPP, seed) for seed in range(SEEDS)]
        seconds.append((perf_counter() - start) / SEEDS)
        errors.append([float(np.mean((picture - truth) ** 2)) for picture in images])
    gain = astuple(ratio_over_seeds(errors[1], errors[0]))
    return {"scene": example.name, "spp": SPP, "equal_samples": gain, "seconds": seconds}


def image(example: Example, integrator: Any, spp: int, seed: int) -> Floats:
    """Return a picture (H, W, 3)."""
    picture = mi.render(example.scene, integrator=integrator, spp=spp, seed=seed)
    return np.array(picture, np.float64)[..., :3]


def against_paths(example: Example, announce: Announce) -> list[dict[str, Any]]:
    """Return how pictures of smaller and smaller patches differ from the picture of a path tracer."""
    announce(f"{example.name}, paths")
    path = mi.load_dict({"type": "path", "max_depth": 64, "rr_depth": 64})
    truth = image(example, path, PATHS, 3)
    rows = []
    for size in SIZES:
        differences = {}
        for show in SHOWS:
            announce(f"{example.name}, patches of {size:g}, {show}")
            integrator = mi.load_dict({"type": "radiosity", "size": size, "show": show, "rays": 1024})
            picture = image(example, integrator, 512, 5)
            differences[show] = float(np.mean(np.abs(picture - truth)) / truth.mean())
            differences[f"{show} mean"] = float(picture.mean() / truth.mean())
        rows.append({"scene": example.name, "size": size, "count": len(integrator.patches), **differences})
    return rows


def large(example: Example, announce: Announce) -> dict[str, Any]:
    """Return the cost of a solution of more than 20 000 patches."""
    announce(f"{example.name}, many patches")
    patches = cut(example.scene, 0.06)
    start = perf_counter()
    solution = solve(patches, RAYS, 1e-5, 0, True, Guidance())
    return {
        "patches": len(patches),
        "seconds": perf_counter() - start,
        "rays": solution.rays,
        "rounds": solution.rounds,
        "residual": solution.residual,
    }

"""Whole solutions and pictures, guided and not, and against the path tracer."""

from __future__ import annotations

from collections.abc import Callable
from time import perf_counter
from typing import Any

import mitsuba as mi
import numpy as np

from benchmarks.radiosity.convergence import gain
from benchmarks.radiosity.scenes import Example
from tracer.core.arrays import Floats
from tracer.radiosity.gathering import solve
from tracer.radiosity.guide import Guidance
from tracer.radiosity.meshing import cut
from tracer.radiosity.shooting import shoot

SEEDS = 4
RAYS = 256
SPP = 64
SIZES = (0.8, 0.4, 0.2, 0.1)


def solutions(example: Example, told: Callable[[str], None]) -> list[dict[str, Any]]:
    """Return what guidance gains in gathering and in shooting, by the error of all patches."""
    patches = cut(example.scene, example.size)
    distinct = Guidance("distinct", 4.0)
    ways: dict[str, tuple[Callable[[int, int], Any], Callable[[int, int], Any]]] = {
        "gathering": (
            lambda rays, seed: solve(patches, rays, 1e-4, seed, True),
            lambda rays, seed: solve(patches, rays, 1e-4, seed, True, Guidance()),
        ),
        "shooting": (
            lambda rays, seed: shoot(patches, rays, 1e-4, seed),
            lambda rays, seed: shoot(patches, rays, 1e-4, seed, distinct),
        ),
    }
    found = []
    for name, both in ways.items():
        told(f"{example.name}, {name}")
        truth = both[0](16 * RAYS, 77).radiosity
        errors, seconds = [], []
        for way in both:
            way(RAYS, 50)
            begin = perf_counter()
            results = [way(RAYS, seed).radiosity for seed in range(SEEDS)]
            seconds.append((perf_counter() - begin) / SEEDS)
            errors.append([float(np.mean((result - truth) ** 2)) for result in results])
        found.append(
            {
                "scene": example.name,
                "method": name,
                "patches": len(patches),
                "rays": RAYS,
                "equal_rays": gain(errors[1], errors[0]),
                "seconds": seconds,
            }
        )
    return found


def pictures(example: Example, told: Callable[[str], None]) -> dict[str, Any]:
    """Return what guided final gathers gain in a picture, at equal samples."""
    told(f"{example.name}, final gather")
    both = [mi.load_dict({"type": "radiosity", "size": example.size, "guided": guided}) for guided in (False, True)]
    truth = np.mean([image(example, integrator, 32 * SPP, 90) for integrator in both], axis=0)
    errors, seconds = [], []
    for integrator in both:
        image(example, integrator, SPP, 50)
        begin = perf_counter()
        found = [image(example, integrator, SPP, seed) for seed in range(SEEDS)]
        seconds.append((perf_counter() - begin) / SEEDS)
        errors.append([float(np.mean((each - truth) ** 2)) for each in found])
    return {"scene": example.name, "spp": SPP, "equal_samples": gain(errors[1], errors[0]), "seconds": seconds}


def image(example: Example, integrator: Any, spp: int, seed: int) -> Floats:
    """Return a picture (H, W, 3)."""
    made = mi.render(example.scene, integrator=integrator, spp=spp, seed=seed)
    return np.array(made, np.float64)[..., :3]


def against_paths(example: Example, told: Callable[[str], None]) -> list[dict[str, Any]]:
    """Return how pictures of smaller and smaller patches differ from those of a path tracer."""
    told(f"{example.name}, paths")
    path = mi.load_dict({"type": "path", "max_depth": 64, "rr_depth": 64})
    truth = image(example, path, 2048, 3)
    found = []
    for size in SIZES:
        differences = {}
        for show in ("patches", "smooth", "gather"):
            told(f"{example.name}, patches of {size:g}, {show}")
            integrator = mi.load_dict({"type": "radiosity", "size": size, "show": show, "rays": 1024})
            made = image(example, integrator, 512, 5)
            differences[show] = float(np.mean(np.abs(made - truth)) / truth.mean())
            differences[f"{show} mean"] = float(made.mean() / truth.mean())
        found.append({"scene": example.name, "size": size, "count": len(integrator.patches), **differences})
    return found


def large(example: Example, told: Callable[[str], None]) -> dict[str, Any]:
    """Return how long a solution of more than 20 000 patches takes."""
    told(f"{example.name}, many patches")
    patches = cut(example.scene, 0.06)
    begin = perf_counter()
    found = solve(patches, RAYS, 1e-5, 0, True, Guidance())
    return {
        "patches": len(patches),
        "seconds": perf_counter() - begin,
        "rays": found.rays,
        "rounds": found.rounds,
        "residual": found.residual,
    }

"""Error of irradiance against rays and time, guided and not."""

from __future__ import annotations

from dataclasses import astuple, dataclass, replace
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np

from benchmarks.harness import Announce, ratio_over_seeds
from benchmarks.radiosity.scenes import Example
from tracer.core.arrays import Floats
from tracer.radiosity.gathering import solve
from tracer.radiosity.groups import Groups, Points, alone, neighbours
from tracer.radiosity.guide import Guidance, division_for, make_guide
from tracer.radiosity.hemisphere import Division, Kind, See
from tracer.radiosity.irradiance import gather
from tracer.radiosity.lattice import evenly
from tracer.radiosity.meshing import cut
from tracer.radiosity.patches import Patches, by_face
from tracer.radiosity.strata import Strata
from tracer.radiosity.warp import warped

RAYS = (64, 256, 1024)
SEEDS = 5
TRUTH = 1 << 14
THRESHOLDS: dict[Kind, float] = {"entropy": 1.0, "distinct": 4.0, "deviation": 0.6}
OWN = Division("distinct", 2.5, 1, 4)
"""The paper's way: every point looks for itself, with four rays through each triangle."""


@dataclass(frozen=True)
class Method:
    """One way to gather."""

    name: str
    kind: Kind | None = None
    strata: bool = False
    own: bool = False


METHODS = (
    Method("evenly"),
    Method("each for itself, strata", "distinct", True, True),
    Method("distinct, strata", "distinct", True),
    Method("deviation, strata", "deviation", True),
    *(Method(f"{kind}, warp", kind) for kind in THRESHOLDS),
)


@dataclass(frozen=True)
class Place:
    """Points of a scene that is solved, and what is true there."""

    example: Example
    patches: Patches
    groups: Groups
    single: Groups
    see: See
    truth: Floats
    radiosity: Floats


class Gathered(NamedTuple):
    """What one method finds."""

    irradiance: Floats
    rays: float
    """A point, those that looked too."""
    guided: float
    """Share of the points."""


@dataclass(frozen=True)
class Curve:
    """What one method did in one scene."""

    scene: str
    method: str
    rays: int
    errors: list[float]
    """Mean squared error over the mean squared, of each seed."""
    seconds: float
    traced: float
    """Rays a point, those that looked too."""
    guided: float


def prepare(example: Example) -> Place:
    """Solve a scene, and find its irradiance with many rays."""
    patches = cut(example.scene, example.size)
    radiosity = solve(patches, 512, 1e-5, lights=True).radiosity
    see = patches.see(radiosity if example.lights else radiosity - patches.emitted)
    dark = np.flatnonzero(patches.emitted.max(axis=1) == 0)
    points = Points(patches.centres[dark], patches.normals[dark])
    single = alone(points)
    truth = gather(see, single, TRUTH, seed=99).irradiance
    return Place(example, patches, neighbours(points, Guidance().members), single, see, truth, radiosity)


def gathered(place: Place, method: Method, rays: int, seed: int) -> Gathered | None:
    """Return what one method finds; None where a look is too dear."""
    if method.kind is None:
        return Gathered(gather(place.see, place.single, rays, evenly, seed).irradiance, rays, 0.0)
    guidance = Guidance(method.kind, THRESHOLDS[method.kind])
    if method.own:
        guidance = replace(guidance, members=1, worth=0.0, overall=0.0)
        return guided(place, place.single, OWN, guidance, rays, seed, method.strata)
    division = division_for(guidance, rays)
    return None if division is None else guided(place, place.groups, division, guidance, rays, seed, method.strata)


def guided(
    place: Place, groups: Groups, division: Division, guidance: Guidance, rays: int, seed: int, strata: bool = False
) -> Gathered | None:
    """Return what guided rays find, those that looked among them; None where they would be most of all."""
    guide = make_guide(by_face(place.patches, place.see), groups, division, guidance, place.patches.faces, 1000 + seed)
    looked = guide.regions.rays / len(groups.points)
    left = rays - round(looked)
    if left < rays / 3:
        return None
    way = Strata(guide) if strata else warped(guide)
    irradiance = gather(place.see, groups, left, way, seed, guide.guided).irradiance
    return Gathered(irradiance, left + looked, float(guide.guided.mean()))


def step_count() -> int:
    """Return how many steps a scene has."""
    return len(RAYS) * SEEDS


def measure(place: Place, announce: Announce) -> list[Curve]:
    """Return the errors of all methods. They take turns, so that a machine that slows down does so for all."""
    scale = float(np.mean(place.truth)) ** 2
    curves = []
    for rays in RAYS:
        # The first time a method gathers is not timed: it compiles.
        possible = [method for method in METHODS if gathered(place, method, rays, 50) is not None]
        errors: dict[str, list[float]] = {method.name: [] for method in possible}
        seconds: dict[str, list[float]] = {method.name: [] for method in possible}
        traced: dict[str, tuple[float, float]] = {}
        for seed in range(SEEDS):
            announce(f"{place.example.name}, {rays} rays, seed {seed}")
            for method in possible:
                begin = perf_counter()
                result = gathered(place, method, rays, seed)
                seconds[method.name].append(perf_counter() - begin)
                assert result is not None
                errors[method.name].append(float(np.mean((result.irradiance - place.truth) ** 2)) / scale)
                traced[method.name] = result.rays, result.guided
        for method in possible:
            name = method.name
            took = float(np.median(seconds[name]))
            curves.append(Curve(place.example.name, name, rays, errors[name], took, *traced[name]))
    return curves


def in_as_much_time(curves: list[Curve], curve: Curve) -> list[float]:
    """Return the errors of even rays, had there been as many as the curve's time is enough for.

    Time is compared at the same number of rays, and error falls along the line through all even rays of the scene.
    """
    evens = [other for other in curves if other.scene == curve.scene and other.method == "evenly"]
    same = next(even for even in evens if even.rays == curve.rays)
    logarithms = [float(np.mean(np.log(even.errors))) for even in evens]
    slope = float(np.polyfit(np.log([even.seconds for even in evens]), logarithms, 1)[0])
    factor = float((curve.seconds / same.seconds) ** slope)
    return [error * factor for error in same.errors]


def gains_over_even(curves: list[Curve]) -> list[dict[str, Any]]:
    """Return the gains of all guided methods over even rays."""
    rows = []
    for curve in curves:
        if curve.method == "evenly":
            continue
        even = next(
            other for other in curves if (other.scene, other.method, other.rays) == (curve.scene, "evenly", curve.rays)
        )
        rows.append(
            {
                "scene": curve.scene,
                "method": curve.method,
                "rays": curve.rays,
                "traced": curve.traced,
                "guided": curve.guided,
                "seconds": curve.seconds,
                "error": float(np.sqrt(np.mean(curve.errors))),
                "equal_rays": astuple(ratio_over_seeds(curve.errors, even.errors)),
                "equal_time": astuple(ratio_over_seeds(curve.errors, in_as_much_time(curves, curve))),
            }
        )
    return rows

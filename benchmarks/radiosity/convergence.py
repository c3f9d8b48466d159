"""Error of irradiance against rays and against time, with guided and with evenly spread rays."""

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
"""Numbers of rays a point."""
SEEDS = 5
"""Number of seeds."""
TRUTH = 1 << 14
"""Rays a point of the reference."""
THRESHOLDS: dict[Kind, float] = {"entropy": 1.0, "distinct": 4.0, "deviation": 0.6}
"""Threshold of each kind of complexity that is compared."""
OWN = Division("distinct", 2.5, 1, 4)
"""Division as in the paper: every point looks for itself, with four rays through each triangle."""


@dataclass(frozen=True)
class Method:
    """A way to gather."""

    name: str
    kind: Kind | None = None
    """Kind of complexity that guides the rays; None for evenly spread rays."""
    strata: bool = False
    """Whether the rays are spread in strata; otherwise their lattice is warped."""
    own: bool = False
    """Whether every point looks for itself, instead of its group."""


METHODS = (
    Method("evenly"),
    Method("each for itself, strata", "distinct", True, True),
    Method("distinct, strata", "distinct", True),
    Method("deviation, strata", "deviation", True),
    *(Method(f"{kind}, warp", kind) for kind in THRESHOLDS),
)
"""Methods that are compared."""


@dataclass(frozen=True)
class Place:
    """Points of a scene whose radiosity is solved, and the true irradiance there."""

    example: Example
    patches: Patches
    groups: Groups
    """Points in groups of neighbours."""
    single: Groups
    """Points in groups of one point each."""
    see: See
    """How rays see the solution."""
    truth: Floats
    """(N, 3): true irradiance of the points."""
    radiosity: Floats
    """(P, 3): radiosity of all patches."""


class Gathered(NamedTuple):
    """Irradiance that a method finds."""

    irradiance: Floats
    """(N, 3): irradiance of the points."""
    rays: float
    """Rays a point, including those that looked."""
    guided: float
    """Share of the points whose rays are guided."""


@dataclass(frozen=True)
class Curve:
    """Errors and costs of a method in a scene, at a number of rays."""

    scene: str
    method: str
    rays: int
    """Rays a point that the method was given."""
    errors: list[float]
    """Mean squared error over the squared mean, for each seed."""
    seconds: float
    """Median over seeds of the time to gather."""
    traced: float
    """Rays a point that were traced, including those that looked."""
    guided: float
    """Share of the points whose rays were guided."""


def prepare(example: Example) -> Place:
    """Return the points of a scene, with its solution and with the true irradiance from many rays."""
    patches = cut(example.scene, example.size)
    radiosity = solve(patches, 512, 1e-5, lights=True).radiosity
    see = patches.see(radiosity if example.lights else radiosity - patches.emitted)
    dark = np.flatnonzero(patches.emitted.max(axis=1) == 0)
    points = Points(patches.centres[dark], patches.normals[dark])
    single = alone(points)
    truth = gather(see, single, TRUTH, seed=99).irradiance
    return Place(example, patches, neighbours(points, Guidance().members), single, see, truth, radiosity)


def gathered(place: Place, method: Method, rays: int, seed: int) -> Gathered | None:
    """Return the irradiance that a method finds; None if there are too few rays for a look."""
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
    """Return the irradiance that guided rays find; None if rays that look would take more than two thirds of all."""
    guide = make_guide(by_face(place.patches, place.see), groups, division, guidance, place.patches.faces, 1000 + seed)
    look_rays = guide.regions.rays / len(groups.points)
    gathering_rays = rays - round(look_rays)
    if gathering_rays < rays / 3:
        return None
    way = Strata(guide) if strata else warped(guide)
    irradiance = gather(place.see, groups, gathering_rays, way, seed, guide.guided).irradiance
    return Gathered(irradiance, gathering_rays + look_rays, float(guide.guided.mean()))


def step_count() -> int:
    """Return the number of steps of a scene."""
    return len(RAYS) * SEEDS


def measure(place: Place, announce: Announce) -> list[Curve]:
    """Return the curves of all methods. Methods take turns, so that a machine that slows down does so for all."""
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
                start = perf_counter()
                result = gathered(place, method, rays, seed)
                seconds[method.name].append(perf_counter() - start)
                assert result is not None
                errors[method.name].append(float(np.mean((result.irradiance - place.truth) ** 2)) / scale)
                traced[method.name] = result.rays, result.guided
        for method in possible:
            name = method.name
            median_seconds = float(np.median(seconds[name]))
            curves.append(Curve(place.example.name, name, rays, errors[name], median_seconds, *traced[name]))
    return curves


def in_as_much_time(curves: list[Curve], curve: Curve) -> list[float]:
    """Return the errors that as many evenly spread rays would have as fit into the time of the curve.

    Time is compared at the same number of rays, and the error is taken to fall along the line, in logarithms, through
    the errors of evenly spread rays of the scene.
    """
    even_curves = [candidate for candidate in curves if candidate.scene == curve.scene and candidate.method == "evenly"]
    even_curve = next(even for even in even_curves if even.rays == curve.rays)
    logarithms = [float(np.mean(np.log(even.errors))) for even in even_curves]
    slope = float(np.polyfit(np.log([even.seconds for even in even_curves]), logarithms, 1)[0])
    factor = float((curve.seconds / even_curve.seconds) ** slope)
    return [error * factor for error in even_curve.errors]


def gains_over_even(curves: list[Curve]) -> list[dict[str, Any]]:
    """Return the gains of all guided methods over evenly spread rays."""
    rows = []
    for curve in curves:
        if curve.method == "evenly":
            continue
        even = next(
            candidate
            for candidate in curves
            if (candidate.scene, candidate.method, candidate.rays) == (curve.scene, "evenly", curve.rays)
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

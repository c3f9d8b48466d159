"""The paper's rules for the rays of a patch, beside random rays, a lattice and guided rays (figures 11 and 12)."""

from __future__ import annotations

from dataclasses import astuple, dataclass
from typing import Any

import numpy as np

from benchmarks.harness import Announce, ratio_over_seeds
from benchmarks.radiosity.convergence import METHODS, Gathered, Place, gathered
from tracer.radiosity.guide import Guide
from tracer.radiosity.irradiance import gather
from tracer.radiosity.lattice import evenly, randomly
from tracer.radiosity.paper import PaperRays, PaperRules, paper_guide
from tracer.radiosity.patches import by_face

RAYS = (64, 256)
"""Numbers of rays a point."""
SEEDS = 3
"""Number of seeds."""
DEPTHS = (1, 2, 3, 4)
"""Largest numbers of times that a triangle is split."""
CLASSICAL, LATTICE, OURS = "random rays", "lattice", "guided"
"""Names of what the paper's rules are compared with; the first is the baseline."""


@dataclass(frozen=True)
class Published:
    """The paper's rules, in a form that is measured."""

    depth: int
    right: bool
    """Whether energies are made right."""
    are_looks_free: bool
    """Whether rays that look are not counted, as if the complexity of each triangle were known."""

    @property
    def name(self) -> str:
        """Name in tables."""
        energies = "energies made right" if self.right else "as printed"
        return f"{energies}, depth {self.depth}" + (", looks free" if self.are_looks_free else "")


FORMS = [Published(depth, right, free) for right in (False, True) for free in (False, True) for depth in DEPTHS]
"""All that are measured."""


def looked(place: Place, depth: int, seed: int) -> Guide:
    """Return the triangles of all points after rays have looked."""
    see = by_face(place.patches, place.see)
    return paper_guide(see, place.single, PaperRules(depth=depth), place.patches.faces, 1000 + seed)


def by_rules(place: Place, form: Published, guide: Guide, rays: int, seed: int) -> Gathered | None:
    """Return the irradiance that the paper's rules find; None if looks would take more than two thirds of the rays."""
    look_rays = guide.regions.rays / len(place.single.points)
    gathering_rays = rays if form.are_looks_free else rays - round(look_rays)
    if gathering_rays < rays / 3:
        return None
    irradiance = gather(place.see, place.single, gathering_rays, PaperRays(guide, form.right), seed).irradiance
    traced = gathering_rays if form.are_looks_free else gathering_rays + look_rays
    return Gathered(irradiance, traced, float(guide.guided.mean()))


def by_ours(place: Place, rays: int, seed: int) -> Gathered | None:
    """Return the irradiance that guided rays find, as tracer guides them by default; None for too few rays."""
    ours = next(method for method in METHODS if method.name == "deviation, warp")
    return gathered(place, ours, rays, seed)


def step_count() -> int:
    """Return the number of steps of a scene."""
    return 1 + len(RAYS)


def measure(place: Place, announce: Announce) -> list[dict[str, Any]]:
    """Return a row for every method and number of rays: the gain over random rays, and the bias of the mean."""
    announce(f"{place.example.name}, looks by the paper's rules")
    guides = {(depth, seed): looked(place, depth, seed) for depth in DEPTHS for seed in range(SEEDS)}
    rows = []
    for rays in RAYS:
        announce(f"{place.example.name}, the paper's rules, {rays} rays")
        found: dict[str, list[Gathered | None]] = {
            CLASSICAL: [plain(place, randomly, rays, seed) for seed in range(SEEDS)],
            LATTICE: [plain(place, evenly, rays, seed) for seed in range(SEEDS)],
            OURS: [by_ours(place, rays, seed) for seed in range(SEEDS)],
        }
        for form in FORMS:
            found[form.name] = [by_rules(place, form, guides[form.depth, seed], rays, seed) for seed in range(SEEDS)]
        classical = errors(place, found[CLASSICAL])
        for name, results in found.items():
            if name == CLASSICAL or any(result is None for result in results):
                continue
            rows.append(
                {
                    "scene": place.example.name,
                    "rays": rays,
                    "method": name,
                    "gain": astuple(ratio_over_seeds(errors(place, results), classical)),
                    "bias": bias(place, results),
                }
            )
    return rows


def plain(place: Place, way: Any, rays: int, seed: int) -> Gathered:
    """Return the irradiance that rays find which nobody guides."""
    return Gathered(gather(place.see, place.single, rays, way, seed).irradiance, rays, 0.0)


def errors(place: Place, results: list[Gathered | None]) -> list[float]:
    """Return the mean squared error of each result over the squared mean."""
    scale = float(np.mean(place.truth)) ** 2
    return [float(np.mean((result.irradiance - place.truth) ** 2)) / scale for result in results if result is not None]


def bias(place: Place, results: list[Gathered | None]) -> float:
    """Return how much brighter the points are on average than they should be, as a share."""
    means = [float(np.mean(result.irradiance)) for result in results if result is not None]
    return float(np.mean(means) / np.mean(place.truth)) - 1

"""The paper's rules with few rays, as its scenes were lit, in rooms of thousands of patches."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import astuple, dataclass
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from benchmarks.harness import Announce, ratio_over_seeds
from benchmarks.paper.methods import LATTICE, OURS, by_ours, plain
from benchmarks.paper.scenes import in_corner
from benchmarks.radiosity.convergence import Gathered, Place
from tracer.core.arrays import Floats
from tracer.radiosity.guide import Guide
from tracer.radiosity.hemisphere import Kind
from tracer.radiosity.irradiance import gather
from tracer.radiosity.lattice import evenly, lattice, random_numbers, randomly
from tracer.radiosity.paper import PaperRays, PaperRules, paper_guide
from tracer.radiosity.patches import by_face
from tracer.radiosity.strata import SPARE

RAYS = (8, 16, 32)
"""Numbers of rays a point."""
SEEDS = 3
"""Number of seeds."""
COSINE, UNIFORM = "random rays", "uniform rays"
"""Both baselines: random rays distributed as the cosine, and with even density over the hemisphere."""
KNOWN = 64
"""Rays through each triangle that find its complexity so well that it counts as known."""
MOST_LEFT_OUT = 0.5
"""Share of points with more triangles than rays, from which on the rules are not measured."""


@dataclass(frozen=True)
class Looked:
    """A way to learn the complexity of triangles."""

    name: str
    depth: int
    look: int
    """Rays through each triangle."""
    is_free: bool
    """Whether these rays are not counted."""
    kind: Kind = PaperRules().kind
    """Kind of complexity, see ``Division``."""
    threshold: float = PaperRules().threshold
    """Complexity above which a triangle is split."""


LOOKS = (
    Looked("depth 0, known", 0, KNOWN, True),
    Looked("depth 1, known", 1, KNOWN, True),
    Looked("depth 2, known", 2, KNOWN, True),
    Looked("depth 1, 4 looks free", 1, 4, True),
    Looked("depth 0, 1 look", 0, 1, False),
)
"""All ways that are measured. With one look the complexity of a triangle is always 1, so that all get as many rays."""
OTHER_KINDS: dict[str, tuple[Kind, float]] = {"entropy": ("entropy", 1.0), "C(V)": ("viewpoint_complexity", 1.0)}
"""Kinds of complexity that the paper defines beside the number of faces, and thresholds, by their names in tables."""
OTHER_LOOKS = (
    Looked("faces, depth 0, 4 looks", 0, 4, False),
    *(Looked(f"{name}, depth 1, known", 1, KNOWN, True, *kind) for name, kind in OTHER_KINDS.items()),
    *(Looked(f"{name}, depth 0, 4 looks", 0, 4, False, *kind) for name, kind in OTHER_KINDS.items()),
)
"""Ways that are measured with other kinds of complexity, and one with the number of faces beside them."""
OTHER_RAYS = (32,)
"""Numbers of rays a point with other kinds of complexity."""


def uniformly(point: Any, ray_index: Any, rays: Any, seed: int) -> tuple[Any, Any]:
    """Return independent directions of even density, each weighted by its cosine (a ``Way``)."""
    bits, _, _ = lattice(point, ray_index, rays, seed)
    local = mi.warp.square_to_uniform_hemisphere(mi.Point2f(*random_numbers(bits, ray_index)))
    return local, 2 * dr.pi * local.z / mi.Float(rays)


def step_count(ray_counts: Sequence[int]) -> int:
    """Return the number of steps of a scene."""
    return 1 + len(ray_counts)


def measure(
    place: Place, looks: Sequence[Looked], ray_counts: Sequence[int], announce: Announce
) -> list[dict[str, Any]]:
    """Return a row for every method and number of rays: gains over both kinds of random rays, and in each part.

    "typical" is the gain in the median over patches of the squared error, which a few bright patches do not rule.
    """
    announce(f"{place.example.name}, complexity by the paper's rules")
    guides = {(look.name, seed): looked(place, look, seed) for look in looks for seed in range(SEEDS)}
    rows = []
    for rays in ray_counts:
        announce(f"{place.example.name}, the paper's rules, {rays} rays")
        found: dict[str, list[Gathered | None]] = {
            COSINE: [plain(place, randomly, rays, seed) for seed in range(SEEDS)],
            UNIFORM: [plain(place, uniformly, rays, seed) for seed in range(SEEDS)],
            LATTICE: [plain(place, evenly, rays, seed) for seed in range(SEEDS)],
            OURS: [by_ours(place, rays, seed) for seed in range(SEEDS)],
        }
        for is_right, energies in ((False, "as printed"), (True, "energies right")):
            for look in looks:
                found[f"{energies}, {look.name}"] = [
                    by_rules(place, look, guides[look.name, seed], is_right, rays, seed) for seed in range(SEEDS)
                ]
        errors = {
            name: [squared_errors(place, result) for result in results if result is not None]
            for name, results in found.items()
            if all(result is not None for result in results)
        }
        rows += [{"scene": place.example.name, "rays": rays, **row} for row in rows_of(errors, place)]
    return rows


def looked(place: Place, look: Looked, seed: int) -> Guide:
    """Return the triangles of all points after rays have looked."""
    rules = PaperRules(look.kind, look.threshold, look.depth, look.look)
    return paper_guide(by_face(place.patches, place.see), place.single, rules, place.patches.faces, 1000 + seed)


def by_rules(place: Place, look: Looked, guide: Guide, is_right: bool, rays: int, seed: int) -> Gathered | None:
    """Return the irradiance that the paper's rules find; None if few rays are left, or most points have too few."""
    spent = 0 if look.is_free else round(guide.regions.rays / len(place.single.points))
    if rays - spent < rays / 3 or np.mean(np.diff(guide.first) * SPARE > rays - spent) > MOST_LEFT_OUT:
        return None
    irradiance = gather(place.see, place.single, rays - spent, PaperRays(guide, is_right), seed).irradiance
    return Gathered(irradiance, rays, 1.0)


def squared_errors(place: Place, result: Gathered) -> Floats:
    """Return the squared error (N,) of each point, mean of the channels."""
    return np.asarray(np.mean((result.irradiance - place.truth) ** 2, axis=1), np.float64)


def rows_of(errors: dict[str, list[Floats]], place: Place) -> list[dict[str, Any]]:
    """Return a row for each method but the baseline."""
    dark = place.patches.emitted.max(axis=1) == 0
    near = in_corner(place.patches.centres[dark])

    def gain(method: str, baseline: str, points: Any = slice(None), average: Any = np.mean) -> tuple[float, ...]:
        mine, theirs = ([average(error[points]) for error in errors[name]] for name in (method, baseline))
        return astuple(ratio_over_seeds(mine, theirs))

    return [
        {
            "method": name,
            "gain": gain(name, COSINE),
            "over_uniform": gain(name, UNIFORM),
            "typical": gain(name, COSINE, average=np.median),
            "typical_over_uniform": gain(name, UNIFORM, average=np.median),
            "in_corner": gain(name, COSINE, near),
            "elsewhere": gain(name, COSINE, ~near),
            "points": int(dark.sum()),
        }
        for name in errors
        if name != COSINE
    ]

"""Paths of a scene with what each of their choices has given: of a light, of a direction, and to go on."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from tracer.core.arrays import Floats, Indices
from tracer.core.device import to_host, upload
from tracer.guiding.chosen import Chosen, choose
from tracer.guiding.slots import SlotPlan, plan_slots
from tracer.guiding.table import LightChances, LightTable
from tracer.guiding.training import VERTICES, Paths, Trainer, Trials, joined, keys_of, seeded_rays
from tracer.sampling.samples import make_sampler
from tracer.scene.view import View
from tracer.session.guidance import require_guided

DEPTHS = (1, 2, 3, 4, 5, 6, 8, 12)
"""Lengths at which paths are cut, so that differences tell what each part of a path gives; beyond the last, the rest
is one part."""
BINS = 4
"""Steps along each side of the unit square from which directions are made."""
PER_VERTEX = 4
"""Dimensions that the integrator draws at each vertex: for a light, a lobe, a direction, and the roulette."""


@dataclass(frozen=True)
class Choices:
    """Paths, with what their choices have given."""

    paths: Paths
    lights: Trials
    """Shadow rays of the first vertices."""
    directions: list[Trials]
    """For each of the first vertices, directions in which paths went on; the slot is the bin of the direction."""
    steps: Floats
    """(parts, paths): what each part of a path has given; the parts end at ``DEPTHS``."""
    costs: Floats
    """(parts,): mean number of vertices in each part."""


def follow(view: View, plan: SlotPlan, seed: int, path_count: int) -> Choices:
    """Follow about ``path_count`` paths, all lights of which have the same chance. The view has the integrator guided.

    All ends of the same path are drawn with the same numbers, so that differences between them are its parts.
    """
    chosen = choose(view.grid, 0, 1, 0, path_count // 2)
    limit = require_guided(view).max_depth
    ends = [depth for depth in DEPTHS if depth < limit]
    cut: list[Floats] = []
    for depth in ends:
        with guided_to(view, depth) as shorter:
            cut.append(trained(shorter, plan, seed, chosen)[0].radiance)
    paths, trials = trained(view, plan, seed, chosen)
    steps = np.diff(np.stack([0 * paths.radiance, *cut, paths.radiance]), axis=0)
    inputs = [upload(mi.UInt32, values) for values in (chosen.pixel, chosen.sequence, chosen.index)]
    bins = direction_bins(view, seed, inputs)
    vertices = vertex_counts(view, seed, inputs)
    bounds = [*ends, max(int(vertices.max(initial=0)), *ends) + 1]
    alive = np.array([(vertices >= number).mean() for number in range(1, bounds[-1] + 1)])
    costs = np.array([part.sum() for part in np.split(alive, ends)])
    directions = []
    for k, lights in enumerate(trials):
        path = lights.path
        by_light = lights.given / lights.chance
        further = steps[k + 1 :, path].sum(axis=0) - by_light if k + 1 < len(steps) else 0 * by_light
        chance = np.full(len(path), BINS**-2.0)
        slot = bins[k][path]
        directions.append(Trials(path, lights.position, lights.normal, slot, chance, chance * further))
    return Choices(paths, joined(trials), directions, steps, costs)


@contextmanager
def guided_to(view: View, depth: int) -> Iterator[View]:
    """Yield a view whose paths end at a depth."""
    integrator = require_guided(view)
    own = integrator.max_depth
    integrator.max_depth = depth
    try:
        yield replace(view)
    finally:
        integrator.max_depth = own


def trained(view: View, plan: SlotPlan, seed: int, chosen: Chosen) -> tuple[Paths, list[Trials]]:
    """Return paths of a view along which all lights have the same chance, and the trials at each vertex."""
    trainer = Trainer(view, make_sampler())
    try:
        return trainer.train(LightTable.of(view.scene, plan, LightChances.stock(plan)), seed, 0, chosen)
    finally:
        trainer.close()
        require_guided(view).table = None


def direction_bins(view: View, seed: int, inputs: list[Any]) -> list[Indices]:
    """Return, for each of the first vertices, the bin (paths,) of the number that makes the direction of each path.

    ``inputs``: pixel, sequence and index of each path (mi.UInt32), see ``Chosen``.
    """
    sampler = make_sampler()
    seeded_rays(view, sampler, keys_of(seed, 0), *inputs)
    bins = []
    for _ in range(VERTICES):
        sampler.next_2d()
        sampler.next_1d()
        bins.append(to_host(bin_of(sampler.next_2d()), (-1,)).astype(np.uint32))
        sampler.next_1d()
    return bins


def vertex_counts(view: View, seed: int, inputs: list[Any]) -> Indices:
    """Return the number of vertices (paths,) of each path."""
    sampler = make_sampler()
    ray, _ = seeded_rays(view, sampler, keys_of(seed, 0), *inputs)
    of_camera = mi.UInt32(sampler.dimension)
    view.integrator.sample(view.scene, sampler, ray)
    return to_host((sampler.dimension - of_camera) // PER_VERTEX, (-1,))


def bin_of(number: Any) -> Any:
    """Return the bin (mi.UInt32) of a point in the unit square (mi.Point2f)."""
    step = dr.minimum(mi.Vector2u(number * BINS), BINS - 1)
    return step.y * BINS + step.x


def plan_of_directions() -> SlotPlan:
    """Return the bins of directions as parts of one sky, which a guide could choose among."""
    nowhere = np.full((1, 3), np.inf)
    return plan_slots(np.array([BINS]), -nowhere, nowhere)

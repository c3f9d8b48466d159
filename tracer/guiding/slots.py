"""Slots: what a guide chooses among. A slot is a light, a part of a large light, or a group of lights near each other.

The sampler's number that chooses a slot is stretched, so that it goes on to choose the light of a group, and the place
within a part. Of a light that is cut into parts the first number chooses the column, and the second one the row: a
sequence that fills the unit square evenly still does.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from tracer.core.arrays import Floats, Indices, Integers
from tracer.core.device import upload

MOST_SLOTS = 256
"""Most slots of a scene; where there are more lights, they are put into groups."""
SKY_SIDE, LIGHT_SIDE = 8, 4
"""Most parts along each side of the unit square from which places on the sky, or on another large light, are made."""
PROBES = 4
"""Steps along each side of a part in which its ends are looked for."""
ONE = 1.0 - 2.0**-24
"""Largest float32 below 1."""


@dataclass(frozen=True)
class SlotPlan:
    """The slots of a scene."""

    order: Indices
    """(lights,): numbers of the lights in ``mi.Scene.emitters``, those of a slot next to each other."""
    first: Indices
    """(slots,): place in ``order`` of the first light of each slot."""
    count: Indices
    """(slots,): number of lights of each slot."""
    side: Indices
    """(slots,): parts along each side into which the light of the slot is cut."""
    part: Indices
    """(slots,): which part of its light a slot is, column by column."""
    centre: Floats
    """(slots, 3): in the middle of the lights of each slot."""
    radius: Floats
    """(slots,): distance from there to their ends; infinite where lights have no place, as the sky."""

    @property
    def begin(self) -> Indices:
        """(lights,), by place in ``order``: first slot of each light."""
        return np.searchsorted(self.first, np.arange(len(self.order)), side="right").astype(np.uint32) - self.parts

    @property
    def parts(self) -> Indices:
        """(lights,), by place in ``order``: number of slots of each light; 1 for lights of a group."""
        last = np.searchsorted(self.first, np.arange(len(self.order)), side="right") - 1
        return (self.side[last] ** 2).astype(np.uint32)

    @property
    def stock(self) -> Floats:
        """(slots,): with which chance each is chosen if all lights have the same chance, and so have their parts."""
        return self.count / (len(self.order) * self.side.astype(float) ** 2)


def plan_slots(sides: Integers, low: Floats, high: Floats, most: int = MOST_SLOTS) -> SlotPlan:
    """Return the slots of lights.

    ``sides`` (lights,): parts along each side into which each may be cut; ``low``, ``high`` (lights, 3): corners of the
    box around each, infinite where it has no place. If there are more than ``most`` lights, those near each other share
    a slot, those without a place have their own, and none is cut.
    """
    light_count = len(sides)
    if light_count > most:
        centre, radius = balls(low, high)
        alone = np.flatnonzero(~np.isfinite(radius))[: most // 2]
        rest = np.delete(np.arange(light_count), alone)
        order = np.concatenate([alone, rest[np.argsort(morton(centre[rest]), kind="stable")]])
        groups = np.linspace(len(alone), light_count, most - len(alone) + 1).round().astype(np.int64)
        bounds = np.concatenate([np.arange(len(alone)), groups])
        low, high = np.minimum.reduceat(low[order], bounds[:-1]), np.maximum.reduceat(high[order], bounds[:-1])
        ones, zeros = np.ones(most, np.uint32), np.zeros(most, np.uint32)
        return SlotPlan(indices(order), indices(bounds[:-1]), indices(np.diff(bounds)), ones, zeros, *balls(low, high))
    sides = sides.copy()
    while (sides**2).sum() > most:
        sides[sides == sides.max()] //= 2
    parts = sides**2
    first, side = np.repeat(np.arange(light_count), parts), np.repeat(sides, parts)
    part = np.concatenate([np.arange(count) for count in parts]) if light_count else np.zeros(0)
    around = balls(low[first], high[first])
    return SlotPlan(
        indices(np.arange(light_count)),
        indices(first),
        indices(np.ones(len(first))),
        indices(side),
        indices(part),
        *around,
    )


def balls(low: Floats, high: Floats) -> tuple[Floats, Floats]:
    """Return centre (N, 3) and radius (N,) of balls around boxes with these corners (N, 3)."""
    has_place = np.isfinite(low).all(axis=-1, keepdims=True) & np.isfinite(high).all(axis=-1, keepdims=True)
    low, high = np.where(has_place, low, 0), np.where(has_place, high, np.inf)
    return np.where(has_place, 0.5 * (low + high), 0), 0.5 * np.sqrt(np.square(high - low).sum(axis=-1))


def indices(numbers: Any) -> Indices:
    """Return whole numbers as 32-bit ones."""
    return np.asarray(numbers, np.uint32)


def morton(points: Floats) -> Integers:
    """Return the place (N,) of points (N, 3) on a curve that fills space (Morton, 1966)."""
    low, extent = points.min(axis=0), np.ptp(points, axis=0).max()
    cell = np.clip((points - low) / max(extent, 1e-30) * 1023, 0, 1023).astype(np.int64)
    code = np.zeros(len(points), np.int64)
    for bit in range(10):
        for axis in range(3):
            code |= ((cell[:, axis] >> bit) & 1) << (3 * bit + axis)
    return code


def slots_of(scene: Any) -> SlotPlan:
    """Return the slots of the lights of an ``mi.Scene``."""
    lights = scene.emitters()
    sides, low, high = np.ones(len(lights), np.int64), np.zeros((len(lights), 3)), np.zeros((len(lights), 3))
    for k, light in enumerate(lights):
        if light.is_environment():
            sides[k], low[k], high[k] = SKY_SIDE, -np.inf, np.inf
            continue
        shape = light.get_shape()
        if shape is not None and shape.class_name() != "Sphere":  # whose parts are elsewhere from every point
            sides[k] = LIGHT_SIDE
        box = light.bbox()
        has_place = box.valid() and np.all(np.isfinite([*box.min, *box.max]))
        low[k], high[k] = ([*box.min], [*box.max]) if has_place else (-np.inf, np.inf)
    plan = plan_slots(sides, low, high)
    for place in np.flatnonzero(plan.parts > 1):
        light = lights[plan.order[place]]
        if not light.is_environment():
            mine = slice(plan.begin[place], plan.begin[place] + plan.parts[place])
            plan.centre[mine], plan.radius[mine] = balls(*part_boxes(light, int(plan.side[mine][0])))
    return plan


def part_boxes(light: Any, side: int) -> tuple[Floats, Floats]:
    """Return corners (side^2, 3) of a box around each part of an area light, from a grid of places on it.

    If the light cannot tell places, as those with some textures, all boxes are that of the whole light.
    """
    row, column = (values.ravel() / (PROBES * side) for values in np.indices((PROBES * side + 1, PROBES * side + 1)))
    number = mi.Point2f(upload(mi.Float, np.minimum(column, ONE)), upload(mi.Float, np.minimum(row, ONE)))
    try:
        place = np.array(light.sample_position(mi.Float(0.0), number)[0].p).T
    except RuntimeError:
        box = light.bbox()
        return np.tile(np.ravel(box.min), (side**2, 1)), np.tile(np.ravel(box.max), (side**2, 1))
    place = place.reshape(PROBES * side + 1, PROBES * side + 1, 3)
    parts = [
        place[PROBES * k : PROBES * k + PROBES + 1, PROBES * n : PROBES * n + PROBES + 1].reshape(-1, 3)
        for n in range(side)
        for k in range(side)
    ]
    return np.stack([part.min(axis=0) for part in parts]), np.stack([part.max(axis=0) for part in parts])


@dataclass
class Slots:
    """The slots of a scene on the device."""

    lights: Any
    """mi.EmitterPtr: the lights in the order of the plan."""
    place: Any
    """mi.UInt32, by the number that stands for a light in kernels: its place in that order."""
    of_light: Any
    """mi.UInt32, four numbers by place: first and last slot of each light, number of lights that share it, and 0."""
    of_slot: Any
    """mi.UInt32, four numbers by slot: place of its first light, number of its lights, parts along each side of its
    light, and which part it is."""
    slot_count: Any
    """mi.UInt32: number of slots."""
    steps: int
    """Steps of a search among the slots."""
    is_simple: bool
    """Whether each light has a slot of its own, the whole of it."""
    row_steps: int
    """Steps of a search among the rows of a light that is cut into parts; 0 if none is."""

    @classmethod
    def of(cls, scene: Any, plan: SlotPlan) -> Slots:
        """Put the slots of an ``mi.Scene`` on the device."""
        lights = scene.emitters()
        pointers = mi.EmitterPtr([lights[k] for k in plan.order])
        numbers = dr.reinterpret_array(mi.UInt32, pointers).numpy()
        place = np.zeros(int(numbers.max()) + 1, np.uint32)
        place[numbers] = np.arange(len(numbers))
        shared = plan.count[np.searchsorted(plan.first, np.arange(len(plan.order)), side="right") - 1]
        of_light = np.stack([plan.begin, plan.begin + plan.parts - 1, shared, 0 * shared], axis=-1)
        of_slot = np.stack([plan.first, plan.count, plan.side, plan.part], axis=-1)
        slot_count = len(plan.first)
        return cls(
            lights=pointers,
            place=upload(mi.UInt32, place),
            of_light=upload(mi.UInt32, of_light),
            of_slot=upload(mi.UInt32, of_slot),
            slot_count=dr.opaque(mi.UInt32, slot_count),
            steps=(slot_count - 1).bit_length(),
            is_simple=slot_count == len(plan.order),
            row_steps=int(plan.side.max(initial=1)).bit_length() - 1,
        )

    def place_of(self, light: Any) -> Any:
        """Return the place (mi.UInt32) of lights (mi.EmitterPtr) in the order of the plan; 0 where there is none."""
        number = dr.reinterpret_array(mi.UInt32, light)
        return dr.gather(mi.UInt32, self.place, number, number != 0)

    def slots_of_place(self, place: Any, active: Any) -> tuple[Any, Any, Any]:
        """Return first and last slot (mi.UInt32) of lights by place, and how many lights share them (mi.Float)."""
        first, last, shared, _ = dr.gather(mi.Vector4u, self.of_light, place, active)
        return first, last, mi.Float(shared)

    def column_of(self, slot: Any, active: Any) -> tuple[Any, Any]:
        """Return the first slot (mi.UInt32) of the column of parts that a slot is in, and how many it has."""
        _, _, side, part = dr.gather(mi.Vector4u, self.of_slot, slot, active)
        return slot - (part - part // dr.maximum(side, 1) * side), side

    def within(self, slot: Any, number: Any, active: Any) -> tuple[Any, Any, Any]:
        """Choose a light of each ``slot`` (mi.UInt32), and the place on it.

        ``number``: mi.Point2f, evenly in the unit square. Returns the place of the light in the order of the plan
        (mi.UInt32), the number that the light makes a direction of (mi.Point2f), and how many times as likely these
        are within the slot as if there were no parts and no group (mi.Float).
        """
        if self.is_simple:
            return slot, mi.Point2f(dr.minimum(number, ONE)), mi.Float(1.0)
        first, count, side, part = dr.gather(mi.Vector4u, self.of_slot, slot, active)
        stretched = number.x * mi.Float(count)
        chosen = dr.minimum(mi.UInt32(stretched), count - 1)
        x = stretched - mi.Float(chosen)
        column = part // dr.maximum(side, 1)
        width = dr.rcp(mi.Float(side))
        inner = mi.Point2f((mi.Float(column) + x) * width, (mi.Float(part - column * side) + number.y) * width)
        return first + chosen, dr.minimum(inner, ONE), dr.square(mi.Float(side)) / mi.Float(count)

"""The table by which lights are chosen: for each cell of space, the chance of each slot."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from tracer.core.arrays import Indices, Singles
from tracer.core.device import upload
from tracer.guiding.cells import CellFinder, Grid
from tracer.guiding.slots import ONE, SlotPlan, Slots


@dataclass(frozen=True)
class LightChances:
    """What a guide has learned, as arrays: they travel to workers and into checkpoints."""

    grid: Grid
    row: Indices
    """(cells,): row of ``chances`` that each cell uses."""
    chances: Singles
    """(rows, slots): chance of each slot; each row sums to 1, and none is 0. Row 0 is Mitsuba's own choice."""

    @classmethod
    def stock(cls, plan: SlotPlan) -> LightChances:
        """Return that all lights have the same chance everywhere.

        Boxes and rows are as many as no other array of a scene is likely to have entries: Dr.Jit records which arrays
        are equally long, and would record all anew for a table that differs in this.
        """
        grid = Grid(np.zeros(3), 1.0, (101, 1, 1))
        return cls(grid, np.zeros(grid.cell_count, np.uint32), np.tile(plan.stock, (5, 1)).astype(np.float32))

    def pack(self) -> dict[str, NDArray]:
        """Return all of it as arrays by name."""
        shape = np.array([*self.grid.low, self.grid.edge, *self.grid.boxes])
        return {"grid": shape, "row": self.row, "chances": self.chances}

    @classmethod
    def unpack(cls, arrays: dict[str, NDArray]) -> LightChances:
        """Return what was packed. Raises ValueError or KeyError for other arrays."""
        if arrays["grid"].shape != (7,):
            raise ValueError("this is no grid")
        x, y, z, edge, *boxes = (float(value) for value in arrays["grid"])
        grid = Grid(np.array([x, y, z]), edge, (int(boxes[0]), int(boxes[1]), int(boxes[2])))
        row, chances = arrays["row"], arrays["chances"]
        if row.shape != (grid.cell_count,) or chances.ndim != 2 or row.max() >= len(chances):
            raise ValueError("these chances are of another grid")
        return cls(grid, row, chances)


@dataclass
class Choice:
    """A light that was chosen for each point."""

    slot: Any
    """mi.UInt32"""
    light: Any
    """mi.EmitterPtr"""
    number: Any
    """mi.Point2f: what is left of the sampler's numbers, evenly in the unit square, to choose a place on the light."""
    slot_chance: Any
    """mi.Float: chance of the slot."""
    density: Any
    """mi.Float: divide by it what the light would give if it were the only one."""
    light_chance: Any
    """mi.Float: chance of the light, whichever its part."""


@dataclass
class LightTable:
    """Chances on the device: inputs of a kernel, which does not change when they do."""

    finder: CellFinder
    slots: Slots
    row: Any
    """mi.UInt32, by cell: its row."""
    sums: Any
    """mi.Float, by row and slot: chance of all slots up to this one."""

    @classmethod
    def of(cls, scene: Any, plan: SlotPlan, learned: LightChances) -> LightTable:
        """Put chances on the device."""
        sums = np.cumsum(learned.chances, axis=1, dtype=np.float64)
        sums = (sums / sums[:, -1:]).astype(np.float32)
        sums[:, -1] = 1
        row = upload(mi.UInt32, learned.row)
        return cls(CellFinder.of(learned.grid), Slots.of(scene, plan), row, upload(mi.Float, sums))

    def row_at(self, position: Any, normal: Any, active: Any = True) -> Any:
        """Return the first entry (mi.UInt32) of the row for surfaces at a position that look along a normal."""
        cell = self.finder.cell(position, normal)
        return dr.gather(mi.UInt32, self.row, cell, active) * self.slots.slot_count

    def choose(self, row: Any, number: Any, active: Any = True) -> Choice:
        """Choose a light by a row (mi.UInt32, see ``row_at``) and a sampler's numbers (mi.Point2f)."""
        slot, last = mi.UInt32(0), self.slots.slot_count - 1
        for step in reversed(range(self.slots.steps)):  # the number of slots whose sum is not above the number
            further = slot + (1 << step)
            is_below = dr.gather(mi.Float, self.sums, row + further - 1, active & (further <= last)) <= number.x
            slot = dr.select((further <= last) & is_below, further, slot)
        if self.slots.row_steps > 0:
            slot, chance, stretched = self.choose_row(row, slot, number, active)
        else:
            low, chance = self.interval(row, slot, slot, active)
            stretched = mi.Point2f((number.x - low) / chance, number.y)
        place, inner, share = self.slots.within(slot, stretched, active)
        light = dr.gather(mi.EmitterPtr, self.slots.lights, place, active)
        light_chance = chance if self.slots.is_simple else self.chance_of_place(row, place, active)
        return Choice(slot, light, inner, chance, chance * share, light_chance)

    def interval(self, row: Any, first: Any, last: Any, active: Any) -> tuple[Any, Any]:
        """Return the sum of the chances (mi.Float) of all slots before ``first``, and of those up to ``last``."""
        low = dr.gather(mi.Float, self.sums, row + first - 1, active & (first > 0))
        return low, dr.gather(mi.Float, self.sums, row + last, active) - low

    def choose_row(self, row: Any, slot: Any, number: Any, active: Any) -> tuple[Any, Any, Any]:
        """Choose another slot in the column of ``slot`` by the second number.

        Returns the slot (mi.UInt32), its chance (mi.Float), and what is left of both numbers (mi.Point2f).
        """
        first, side = self.slots.column_of(slot, active)
        low, width = self.interval(row, first, first + side - 1, active)
        step, target = mi.UInt32(0), number.y * width
        for power in reversed(range(self.slots.row_steps)):
            further = step + (1 << power)
            up_to = dr.gather(mi.Float, self.sums, row + first + further - 1, active & (further < side)) - low
            step = dr.select((further < side) & (up_to <= target), further, step)
        slot = first + step
        before, chance = self.interval(row, slot, slot, active)
        y = dr.select(side > 1, (target - (before - low)) / chance, number.y)
        return slot, chance, mi.Point2f((number.x - low) / width, dr.clip(y, 0.0, ONE))

    def chance_of(self, row: Any, light: Any, active: Any = True) -> Any:
        """Return the chance (mi.Float) with which a row chooses a light (mi.EmitterPtr), whichever its part."""
        return self.chance_of_place(row, self.slots.place_of(light), active)

    def chance_of_place(self, row: Any, place: Any, active: Any) -> Any:
        """Return the chance (mi.Float) of lights by their place in the order of the slots."""
        first, last, shared = place, place, mi.Float(1.0)
        if not self.slots.is_simple:
            first, last, shared = self.slots.slots_of_place(place, active)
        return self.interval(row, first, last, active)[1] / shared

"""Learn which lights matter where, and whether to use it, before the first sample of a picture is drawn."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tracer.core.arrays import Floats
from tracer.guiding.cells import Grid
from tracer.guiding.evidence import Taught
from tracer.guiding.fit import Tally, chances, slot_moments
from tracer.guiding.geometry import geometric_moments
from tracer.guiding.judge import Verdict, judge, sure_rows
from tracer.guiding.slots import SlotPlan
from tracer.guiding.table import LightChances

BOX_COUNT = 4096
"""Boxes of the finest grid."""
PARENT = 4
"""A box of the coarser grid has edges that are this many times as long."""
LEAST_GAIN = 1.05
"""Factor by which the second moment must fall for a cell to be guided."""
GROUP_BELIEF = 1.0
"""Weight of the verdict on a coarse cell, in verdicts on a fine cell in it of average weight."""
CAP = 0.999
"""Part of the squared errors of paths that count in full when a gain is foretold; larger ones count as this one."""


@dataclass(frozen=True)
class Lesson:
    """What was learned."""

    learned: LightChances
    gain: float
    """By which factor the weighted variance of the picture is expected to fall."""
    path_count: int
    """Number of paths that have taught it."""
    plan: SlotPlan
    """Of what the chances are."""


def learn(seen: Taught, plan: SlotPlan) -> Lesson | None:
    """Learn chances from what was seen; None if no light gave anything."""
    trials, squares = seen.trials, seen.squares
    if not squares.any():
        return None
    grid = Grid.around(trials.position, BOX_COUNT)
    found, cell = np.unique(grid.cells(trials.position, trials.normal), return_inverse=True)
    coarse = np.unique(grid.parents(PARENT)[found], return_inverse=True)[1]
    shape = len(found), len(plan.stock)
    middles, ways = (means(values, cell, len(found)) for values in (trials.position, trials.normal))
    geometry = geometric_moments(middles, ways, grid.edge, plan)
    half = trials.path % 2
    cap = float(np.quantile(seen.noise, CAP))
    size = squares / np.square(plan.stock[trials.slot])
    outcome = squares / trials.chance * np.minimum(1, cap / np.maximum(size, 1e-300))
    verdict = Verdict(np.zeros(len(found)), np.zeros(len(found)))
    for number in (0, 1):
        mine, other = half == number, half != number
        tally = Tally.of(cell[mine], trials.slot[mine], squares[mine], shape)
        own = chances(slot_moments(tally, geometry, [coarse], plan)[-1], plan)
        verdict += judge(own, plan.stock, cell[other], trials.slot[other], outcome[other])
    sure = sure_rows(verdict, coarse, LEAST_GAIN, GROUP_BELIEF)
    saved = float((verdict.stock - verdict.guided)[sure].sum())
    variance = seen.path_count * float(np.minimum(seen.noise, cap).mean())
    gain = variance / max(variance - saved, 0.1 * variance) if variance > 0 else 1.0
    tally = Tally.of(cell, trials.slot, squares, shape)
    everywhere, around, here = (chances(moments, plan) for moments in slot_moments(tally, geometry, [coarse], plan))
    rows = rows_for_cells(grid, found, coarse, sure, [everywhere, around, here], plan)
    return Lesson(rows, gain, seen.path_count, plan)


def means(values: Floats, cell: NDArray, cell_count: int) -> Floats:
    """Return the mean in each cell (cells, 3) of values (N, 3)."""
    sums = np.stack([np.bincount(cell, column, cell_count) for column in values.T], axis=-1)
    return sums / np.maximum(np.bincount(cell, minlength=cell_count), 1)[:, None]


def rows_for_cells(
    grid: Grid, found: NDArray, coarse: NDArray, sure: NDArray, levels: list[Floats], plan: SlotPlan
) -> LightChances:
    """Return a table: cells that are sure have their own row, cells without trials that of the larger cell around."""
    everywhere, around, here = levels
    sure_around = np.bincount(coarse, sure) * 2 > np.bincount(coarse)
    row = np.full(grid.cell_count, 1 if sure.mean() > 0.5 else 0, np.uint32)
    parents = grid.parents(PARENT)
    first_around, first_here = 2, 2 + len(around)
    row_of_parent = np.full(int(parents.max()) + 1, row[0], np.uint32)
    row_of_parent[parents[found]] = np.where(sure_around, first_around + np.arange(len(around)), 0)[coarse]
    row = row_of_parent[parents]
    row[found] = np.where(sure, first_here + np.arange(len(found)), 0)
    return LightChances(grid, row, np.concatenate([plan.stock[None], everywhere, around, here]).astype(np.float32))

"""From trials of lights to the chance of each in each cell.

The best chance of a light is in proportion to the square root of the second moment of what it gives (Neyman, 1934,
asked of lights). A cell has few trials of each light. So what is expected from distances comes first, see
``tracer.guiding.geometry``. By which factor that is wrong is learned for each slot from all trials, then for each slot
in large cells, and then in small ones: each time as if there had been a few trials more, with the outcome that was
expected before.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from tracer.core.arrays import Floats
from tracer.guiding.slots import SlotPlan

BELIEF = 4.0
"""Number of trials of each light that the opinion of a larger cell counts for."""
LEVEL_BELIEF = 1e-6
"""The same for how bright a cell is as a whole: it may be a thousand times as dark as the larger one."""
STOCK_SHARE = 0.1
"""Part of the chance that is given out as Mitsuba does, so that a light that no trial saw is found."""


@dataclass(frozen=True)
class Tally:
    """Outcomes of trials in cells."""

    count: Floats
    """(cells, slots): number of trials."""
    squares: Floats
    """(cells, slots): sum of the squares of what they gave."""

    @classmethod
    def of(cls, cell: NDArray, slot: NDArray, square: Floats, shape: tuple[int, int]) -> Tally:
        """Count trials by cell (N,) and slot (N,); ``shape``: number of cells, and of slots."""
        index = cell.astype(np.int64) * shape[1] + slot
        size = shape[0] * shape[1]
        count = np.bincount(index, minlength=size).astype(float)
        return cls(count.reshape(shape), np.bincount(index, square, size).astype(float).reshape(shape))


def slot_moments(tally: Tally, geometry: Floats, levels: Sequence[NDArray], plan: SlotPlan) -> list[Floats]:
    """Return second moments (cells, slots) on each level, the coarsest first: one cell, those of ``levels``, all cells.

    ``geometry`` (cells, slots): what is expected beforehand, up to a factor for each slot; ``levels``: for each level
    but the first and the last, the larger cell (cells,) of each cell.
    """
    zeros = np.zeros(len(tally.count), np.int64)
    groups = [zeros, *levels, np.arange(len(zeros))]
    expected, weight = tally.count * geometry, tally.count.sum(axis=1, keepdims=True) + 1e-3
    ratio = light_ratios(tally.squares.sum(axis=0), expected.sum(axis=0), (weight * geometry).mean(axis=0), plan)
    found, before = [], zeros
    for group in groups:
        parent = np.zeros(int(group.max()) + 1, np.int64)
        parent[group] = before
        typical = pooled(weight * geometry, group) / pooled(weight, group)
        ratio = corrected(ratio[parent], pooled(tally.squares, group), pooled(expected, group), typical)
        found.append(ratio * typical)
        before = group
    return found


def pooled(values: Floats, group: NDArray) -> Floats:
    """Return the sums over groups (groups, slots) of values (cells, slots); ``group`` (cells,): of each cell."""
    cells = np.arange(len(group))
    return csr_array((np.ones(len(group)), (group, cells)), shape=(int(group.max()) + 1, len(group))) @ values


def corrected(ratio: Floats, squares: Floats, expected: Floats, typical: Floats) -> Floats:
    """Return by which factor lights give more than geometry says (cells, slots); ``ratio``: what is thought so far.

    ``squares``, ``expected``: sums over trials of what they gave and of what geometry says; ``typical``: what geometry
    says of one trial. A cell may be dark as a whole: what is thought is first brought to its level.
    """
    mean = (typical * ratio).mean(axis=1, keepdims=True)
    level_seen = squares.sum(axis=1, keepdims=True) + LEVEL_BELIEF * mean
    level = level_seen / np.maximum((expected * ratio).sum(axis=1, keepdims=True) + LEVEL_BELIEF * mean, 1e-300)
    believed = BELIEF * typical
    return (squares + believed * level * ratio) / np.maximum(expected + believed, 1e-300)


def light_ratios(squares: Floats, expected: Floats, typical: Floats, plan: SlotPlan) -> Floats:
    """Return a first factor for each slot (1, slots): that of all slots of its lights.

    ``squares``, ``expected``, ``typical`` (slots,): as for ``corrected``.
    """
    light_count = int(plan.first.max()) + 1
    mean = squares.sum() / max(expected.sum(), 1e-300)
    seen, thought, usual = (np.bincount(plan.first, values, light_count) for values in (squares, expected, typical))
    believed = BELIEF * usual / max(typical.sum(), 1e-300) * expected.sum() / max(len(plan.first), 1)
    return ((seen + believed * mean) / np.maximum(thought + believed, 1e-300))[plan.first][None]


def chances(moments: Floats, plan: SlotPlan) -> Floats:
    """Return the chance of each slot (rows, slots) from second moments of what it gives (rows, slots)."""
    size = np.sqrt(moments)
    total = size.sum(axis=1, keepdims=True)
    stock = np.broadcast_to(plan.stock, size.shape)
    own = np.where(total > 0, size / np.maximum(total, 1e-300), stock)
    return (1 - STOCK_SHARE) * own + STOCK_SHARE * stock

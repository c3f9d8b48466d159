"""Whether what one half of the trials has taught helps the other half."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tracer.core.arrays import Floats, Mask


@dataclass(frozen=True)
class Verdict:
    """What other trials say of chances, in sums over all of their trials (rows,)."""

    stock: Floats
    """Second moment of what lights give where Mitsuba chooses among them."""
    guided: Floats
    """The same where the chances of each row choose."""

    def __add__(self, other: Verdict) -> Verdict:
        return Verdict(self.stock + other.stock, self.guided + other.guided)


def judge(chances: Floats, stock: Floats, row: NDArray, slot: NDArray, seen: Floats) -> Verdict:
    """Judge ``chances`` (rows, slots), next to ``stock`` (slots,), by trials that had no part in them.

    ``row``, ``slot`` (N,): of each trial; ``seen`` (N,): square of what it would have given if the choice had been
    certain, over the chance that it had: a trial stands for all in which another choice was made.
    """
    row_count = len(chances)
    mitsuba, guided = (np.bincount(row, seen / chance, row_count) for chance in (stock[slot], chances[row, slot]))
    return Verdict(mitsuba.astype(float), guided.astype(float))


def sure_rows(verdict: Verdict, parents: NDArray, least_gain: float, belief: float) -> Mask:
    """Return which rows (rows,) are sure to gain: the verdict on each is mixed with that on its parent.

    ``parents`` (rows,): group of each row, whose rows are judged together; ``belief``: part of the verdict on a group
    that counts for each of its rows.
    """
    group_count = int(parents.max(initial=-1)) + 1
    share = 1 / np.maximum(np.bincount(parents, minlength=group_count), 1)
    stock = verdict.stock + belief * (np.bincount(parents, verdict.stock, group_count) * share)[parents]
    guided = verdict.guided + belief * (np.bincount(parents, verdict.guided, group_count) * share)[parents]
    return stock > least_gain * guided

"""What a decision about the next round is made from, and what it says."""

from __future__ import annotations

from dataclasses import dataclass

from tracer.core.arrays import Counts, Floats, Singles


@dataclass(frozen=True)
class Decision:
    """The allocation of a round, and how it came about."""

    allocation: Counts
    """(H, W): samples that each pixel is to have after the round."""
    settled: bool = False
    """Whether the whole rest of the budget is allocated, as deciding again is not worth it."""
    note: str = ""
    """Sentence for a person about the decision; "" if there is nothing to say."""
    importance: Floats | None = None
    """(H, W): importance by which samples are allocated; None if all pixels are to have the same."""
    chance: Singles | None = None
    """(H, W): chance that each pixel had of a sample in this round; None if nothing was left to chance."""


@dataclass(frozen=True)
class Situation:
    """The state of a render in which a decision is made."""

    drawn: Counts
    """(H, W): samples that each pixel has so far."""
    goal: int
    """Samples of all pixels together that are to be drawn when the round ends."""
    total: int
    """Samples of the whole budget, of all pixels together."""
    may_settle: bool
    """Whether the rest of the budget may be allocated at once."""
    horizon: int | None = None
    """Samples in all within which a decision must pay off; None: those of the whole budget."""
    object_count: int = 0
    """Number of shapes and lights of the scene."""

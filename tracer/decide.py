"""From importance to an allocation: who gets the samples of the next round, and whether it is worth deciding at all."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter

from tracer import budget
from tracer.criteria import Criterion, Evidence
from tracer.settings import Settings

Floats = NDArray[np.float64]
Counts = NDArray[np.uint32]

RAYS_PER_DECISION = 3.5
"""What a round of its own costs, per pixel, in rays of a sample: statistics, importance, another pass. On eight scenes
of 49 000 pixels it took 10 to 16 ms with two threads, and a ray 50 to 130 ns."""


@dataclass(frozen=True)
class Decision:
    """Who gets what."""

    allocation: Counts
    """(H, W): samples that each pixel is to have."""
    settled: bool = False
    """Whether it shares out the whole rest of the budget, as deciding again is not worth it."""
    note: str = ""


@dataclass(frozen=True)
class Situation:
    """Where in a render a decision is made."""

    drawn: Counts
    """(H, W): samples so far."""
    goal: int
    """Samples that are to be there after the round."""
    total: int
    """Samples of the whole budget."""
    rounds_left: int
    """This one included."""
    may_settle: bool
    """Whether the rest of the budget may be given out at once."""


def decide(
    criterion: Criterion, evidence: Evidence, settings: Settings, now: Situation, generator: np.random.Generator
) -> Decision:
    """Return the allocation of the next round by a criterion."""
    importance = np.asarray(criterion.importance(evidence), np.float64)
    if not np.all(np.isfinite(importance)):  # radiance beyond what float32 can square
        importance = np.ones_like(importance)
    importance = importance * evidence.wanted
    if criterion.spends == "priority":
        return Decision(budget.serve(importance, now.goal, now.drawn, settings.most_samples, generator))
    if criterion.spends == "more":
        left = now.goal - int(now.drawn.sum(dtype=np.int64))
        room = np.maximum(settings.most_samples - now.drawn.astype(np.float64), 0.0)
        more = budget.fill(importance, left, 0.0, room)
        return Decision(now.drawn + budget.round_to_total(more, left, generator))
    goal, note = now.goal, ""
    if criterion.spends == "deviation" and evidence.statistics is not None:
        cost = cost_of_sample(evidence, settings)
        gain, overhead = predicted_gain(importance, cost), predicted_overhead(evidence, now)
        importance = importance / np.sqrt(cost)
        if gain < 1 + overhead:
            importance = evidence.wanted
            goal = now.total if now.may_settle else goal
            note = (
                f"Uniform beyond {now.drawn.mean():.3g} samples per pixel: to adapt the rest would gain a factor of "
                f"{gain:.3f}, to decide so would cost one of {1 + overhead:.3f}."
            )
    # The floor grows with the budget: reached at once, it could ask for more than is left to share out.
    least = np.where(evidence.wanted > 0, max(1.0, settings.least_samples * goal / now.total), 1.0)
    least = np.maximum(now.drawn, least)
    target = budget.fill(importance, goal, least, settings.most_samples)
    if criterion.spends == "deviation":  # others are as they say, and not as we would
        target = budget.suit_sequence(target, goal, least, settings.most_samples)
    return Decision(budget.round_to_total(target, goal, generator), bool(note) and now.may_settle, note)


def cost_of_sample(evidence: Evidence, settings: Settings) -> Floats:
    """Return what a sample of each pixel costs (H, W), relative: its rays, as far as they are known."""
    if settings.cost == "none" or evidence.statistics is None:
        return np.ones_like(evidence.weight)
    rays = uniform_filter(evidence.statistics.rays, 3, mode="nearest")
    return np.maximum(rays, 1.0).astype(np.float64)


def predicted_gain(deviation: Floats, cost: Floats | float = 1.0) -> float:
    """Return the gain over uniform sampling at equal cost, of n ~ s / sqrt(c), with s and c per pixel.

    The error sum s^2 / n times the cost sum n c is sum s^2 sum c if uniform, (sum s sqrt(c))^2 at best; with equal
    costs their ratio is 1 + CV^2 of s (Neyman, 1934).
    """
    best = float(np.mean(deviation * np.sqrt(cost))) ** 2
    return float(np.mean(deviation**2) * np.mean(cost)) / best if best > 0 else 1.0


def predicted_overhead(evidence: Evidence, now: Situation) -> float:
    """Return the part of the time of uniform sampling that the remaining decisions will take.

    Counted in rays, not in seconds, so that a picture does not depend on how busy the machine is.
    """
    assert evidence.statistics is not None
    rays = max(float(evidence.statistics.rays.mean()), 1.0) * now.total / now.drawn.size
    return now.rounds_left * RAYS_PER_DECISION / rays

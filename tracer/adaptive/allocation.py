"""From importance to an allocation: which pixels get the samples of the next round, and whether adapting pays."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter

from tracer.adaptive import budget
from tracer.core.arrays import Counts, Floats
from tracer.core.quantities import mean_count
from tracer.criteria import Criterion, Evidence
from tracer.film import bias
from tracer.film.estimate import Statistics
from tracer.settings import Settings

RAYS_PER_DECISION = 3.5
"""Cost of a decision (statistics, importance, another pass) per pixel, in rays of samples. On eight scenes of 49 000
pixels a decision took 10 to 16 ms with two threads, and a ray 50 to 130 ns."""
MOST_BY_CHANCE = 0.25
"""Largest part of a round that is given by chance, of its samples beyond one for every pixel that gets some."""
LEAST_THINNED = 0.25
"""Least factor by which the chances may be thinned for a round that lacks room for them. With less, nothing is left to
chance, as the few pixels picked would count too much."""


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
    chance: NDArray[np.float32] | None = None
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


def decide(
    criterion: Criterion, evidence: Evidence, settings: Settings, situation: Situation, generator: np.random.Generator
) -> Decision:
    """Return the decision of a criterion about the next round. Raises BudgetError if no allocation meets the bounds."""
    importance = np.asarray(criterion.importance(evidence), np.float64)
    if not np.all(np.isfinite(importance)):  # radiance beyond what float32 can square
        importance = np.ones_like(importance)
    importance = importance * evidence.wanted
    if criterion.spends == "priority":
        served = least_counts(evidence.wanted, settings, situation, 1).astype(np.uint32)
        counts = budget.serve(importance, situation.goal, served, settings.most_samples, generator)
        return Decision(counts, importance=importance)
    if criterion.spends == "more":
        drawn = situation.drawn.astype(np.float64)
        least = least_counts(evidence.wanted, settings, situation, 1) - drawn
        remaining = situation.goal - int(drawn.sum())
        added = budget.fill(importance, remaining, least, np.maximum(settings.most_samples - drawn, least))
        return Decision(situation.drawn + budget.round_to_total(added, remaining, generator), importance=importance)
    if criterion.spends == "deviation" and evidence.statistics is not None:
        cost = cost_of_sample(evidence.statistics)
        deviation, importance = importance, importance / np.sqrt(cost) if settings.cost == "rays" else importance
        gain = predicted_gain(deviation, importance, cost) / predicted_gain(deviation, evidence.wanted, cost)
        overhead = predicted_overhead(evidence.statistics, situation)
        if evidence.statistics.count.max() < 2:  # a single sample tells no deviation
            return Decision(share_out(evidence.wanted, evidence.wanted, settings, situation, True, generator))
        if gain < 1 + overhead:
            so_far = mean_count(situation.drawn.mean())
            note = (
                f"Uniform beyond {so_far} samples per pixel: to adapt the rest would gain a factor of "
                f"{gain:.3f}, to decide so would cost one of {1 + overhead:.3f}."
            )
            situation = replace(situation, goal=situation.total) if situation.may_settle else situation
            counts = share_out(evidence.wanted, evidence.wanted, settings, situation, True, generator)
            return Decision(counts, situation.may_settle, note)
    if criterion.spends == "deviation":
        return share_out_with_chances(importance, evidence.wanted, settings, situation, generator)
    counts = share_out(importance, evidence.wanted, settings, situation, False, generator)
    return Decision(counts, importance=importance)


def share_out_with_chances(
    importance: Floats, weights: Floats, settings: Settings, situation: Situation, generator: np.random.Generator
) -> Decision:
    """Allocate the samples of a round by importance; pixels that would get none may have some by chance.

    ``weights`` (H, W): what the person wants more of, see ``importance_map``. For the chances see ``tracer.film.bias``.
    """
    counts = share_out(importance, weights, settings, situation, True, generator)
    left_out = (counts == situation.drawn) & (weights > 0) & (situation.drawn < settings.most_samples)
    chance = np.where(left_out, bias.chances(importance), counts > situation.drawn)
    size = bias.samples_by_chance(situation.drawn)
    expected, remaining = (chance * size)[left_out].sum(), situation.goal - int(situation.drawn.sum())
    share = min(1.0, MOST_BY_CHANCE * (remaining - int((counts > situation.drawn).sum())) / max(expected, 1e-9))
    if expected == 0 or share < LEAST_THINNED:
        return Decision(counts, importance=importance, chance=(counts > situation.drawn).astype(np.float32))
    chance = np.where(left_out, chance * share, chance)
    picked = left_out & (generator.random(chance.shape) < chance)
    # Pixels that the allocation above gives samples still get one, and left-out pixels that are not picked get none:
    # otherwise the chances would differ from those stated.
    lower = situation.drawn + np.where(picked, size, counts > situation.drawn)
    upper = np.where(left_out & ~picked, situation.drawn, np.maximum(settings.most_samples, lower))
    least = least_counts(weights, settings, situation, settings.least_samples)
    if np.maximum(least, lower).sum() > situation.goal:
        return Decision(counts, importance=importance, chance=(counts > situation.drawn).astype(np.float32))
    counts = share_out(importance, weights, settings, situation, True, generator, (lower, upper))
    return Decision(counts, importance=importance, chance=chance.astype(np.float32))


def share_out(
    importance: Floats,
    weights: Floats,
    settings: Settings,
    situation: Situation,
    suits: bool,
    generator: np.random.Generator,
    bounds: tuple[Counts, Counts] | None = None,
) -> Counts:
    """Return counts (H, W) in proportion to importance, within bounds.

    ``suits``: whether most counts are made powers of two; ``bounds``: least and most counts, (H, W) each, in addition
    to those of the settings.
    """
    if np.ptp(importance) == np.ptp(situation.drawn) == 0 and situation.goal % importance.size == 0:
        return np.full(importance.shape, situation.goal // importance.size, np.uint32)
    least = least_counts(weights, settings, situation, settings.least_samples)
    most: Floats | int = settings.most_samples
    if bounds is not None:
        most = np.minimum(most, bounds[1]).astype(np.float64)
        least = np.minimum(np.maximum(least, bounds[0]), most)
    target = budget.fill(importance, situation.goal, least, most)
    if suits:  # other criteria are followed to the letter
        target = budget.suit_sequence(target, situation.goal, least, most)
    return budget.round_to_total(target, situation.goal, generator)


def least_counts(weights: Floats, settings: Settings, situation: Situation, default: int) -> Floats:
    """Return the least samples (H, W) that each pixel is to have: ``min_spp``, else ``default`` where weights are > 0.

    They grow with the samples spent, as all of them at once could need more than the round has. If they need more all
    the same, every pixel gets the same part of what it lacks.
    """
    grown = situation.goal / situation.total
    least = np.where(weights > 0, max(1.0, default * grown), 1.0)
    if settings.min_spp is not None:
        least = np.full(weights.shape, max(1.0, settings.min_spp * grown))
    drawn = situation.drawn.astype(np.float64)
    missing = np.maximum(np.floor(least) - drawn, 0.0)
    remaining = max(situation.goal - drawn.sum(), 0.0)
    if missing.sum() > remaining:  # a render that was stopped when only some pixels had their samples
        missing = np.floor(missing * (remaining / missing.sum()))
    return drawn + missing


def cost_of_sample(statistics: Statistics) -> Floats:
    """Return the cost of a sample of each pixel (H, W) in rays, averaged over 3 x 3 neighbours."""
    return np.maximum(uniform_filter(statistics.rays, 3, mode="nearest"), 1.0).astype(np.float64)


def predicted_gain(deviation: Floats, share: Floats, cost: Floats) -> float:
    """Return the gain over uniform sampling, at equal cost, of samples n in proportion to ``share``.

    With the deviation s and the cost c of each pixel it is sum s^2 sum c, which is error times cost if uniform, over
    sum s^2 / n times sum n c. With equal costs and n ~ s it is 1 + CV^2 of s (Neyman, 1934). It is taken at equal cost
    rather than at equal samples, as the samples that are spared may have cost next to nothing.
    """
    if not np.any(deviation > 0):
        return 1.0
    with np.errstate(divide="ignore", invalid="ignore"):  # 0 / 0 is not used; a pixel without a share makes the gain 0
        error = np.where(deviation > 0, deviation**2 / share, 0.0)
    return float(np.mean(deviation**2) * np.mean(cost) / (np.mean(error) * np.mean(share * cost)))


def predicted_overhead(statistics: Statistics, situation: Situation) -> float:
    """Return the part of the time of uniform sampling that this decision takes; later decisions can be spared.

    It is counted in rays, not in seconds, so that a picture does not depend on how busy the machine is.
    """
    rays = max(float(statistics.rays.mean()), 1.0) * (situation.horizon or situation.total) / situation.drawn.size
    return RAYS_PER_DECISION / rays


def relative(importance: NDArray[np.float64]) -> NDArray[np.float32]:
    """Return an importance (H, W) as a multiple of its mean; zeros if the mean is zero or not finite."""
    mean = float(importance.mean())
    return (importance / mean if 0 < mean < np.inf else np.zeros_like(importance)).astype(np.float32)

"""From importance to an allocation: who gets the samples of the next round, and whether it is worth deciding at all."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter

from tracer.adaptive import budget
from tracer.core.arrays import Floats
from tracer.core.quantities import mean_count
from tracer.criteria import Criterion, Evidence
from tracer.film import bias
from tracer.film.estimate import Statistics
from tracer.settings import Settings

Counts = NDArray[np.uint32]

RAYS_PER_DECISION = 3.5
"""What a round of its own costs, per pixel, in rays of a sample: statistics, importance, another pass. On eight scenes
of 49 000 pixels it took 10 to 16 ms with two threads, and a ray 50 to 130 ns."""
MOST_BY_CHANCE = 0.25
"""Largest part of the samples of a round, beyond one for every pixel that has some, that is given by chance."""
LEAST_THINNED = 0.25
"""Part of the chances that a round must have room for: with less, those few would count too much."""


@dataclass(frozen=True)
class Decision:
    """Who gets what."""

    allocation: Counts
    """(H, W): samples that each pixel is to have."""
    settled: bool = False
    """Whether it shares out the whole rest of the budget, as deciding again is not worth it."""
    note: str = ""
    importance: Floats | None = None
    """(H, W): by which they are shared out; None where all pixels are to have the same."""
    chance: NDArray[np.float32] | None = None
    """(H, W): with which each pixel has a sample in this round; None where that was not left to chance."""


@dataclass(frozen=True)
class Situation:
    """Where in a render a decision is made."""

    drawn: Counts
    """(H, W): samples so far."""
    goal: int
    """Samples that are to be there after the round."""
    total: int
    """Samples of the whole budget."""
    may_settle: bool
    """Whether the rest of the budget may be given out at once."""
    horizon: int | None = None
    """Samples in all over which a decision is to pay; None: those of the whole budget."""


def decide(
    criterion: Criterion, evidence: Evidence, settings: Settings, now: Situation, generator: np.random.Generator
) -> Decision:
    """Return the allocation of the next round by a criterion."""
    importance = np.asarray(criterion.importance(evidence), np.float64)
    if not np.all(np.isfinite(importance)):  # radiance beyond what float32 can square
        importance = np.ones_like(importance)
    importance = importance * evidence.wanted
    if criterion.spends == "priority":
        served = least_counts(evidence.wanted, settings, now, 1).astype(np.uint32)
        counts = budget.serve(importance, now.goal, served, settings.most_samples, generator)
        return Decision(counts, importance=importance)
    if criterion.spends == "more":
        drawn = now.drawn.astype(np.float64)
        least = least_counts(evidence.wanted, settings, now, 1) - drawn
        left = now.goal - int(drawn.sum())
        more = budget.fill(importance, left, least, np.maximum(settings.most_samples - drawn, least))
        return Decision(now.drawn + budget.round_to_total(more, left, generator), importance=importance)
    if criterion.spends == "deviation" and evidence.statistics is not None:
        cost = cost_of_sample(evidence.statistics)
        deviation, importance = importance, importance / np.sqrt(cost) if settings.cost == "rays" else importance
        gain = predicted_gain(deviation, importance, cost) / predicted_gain(deviation, evidence.wanted, cost)
        overhead = predicted_overhead(evidence.statistics, now)
        if evidence.statistics.count.max() < 2:  # of one sample nobody knows the deviation
            return Decision(share_out(evidence.wanted, evidence.wanted, settings, now, True, generator))
        if gain < 1 + overhead:
            so_far = mean_count(now.drawn.mean())
            note = (
                f"Uniform beyond {so_far} samples per pixel: to adapt the rest would gain a factor of "
                f"{gain:.3f}, to decide so would cost one of {1 + overhead:.3f}."
            )
            now = replace(now, goal=now.total) if now.may_settle else now
            counts = share_out(evidence.wanted, evidence.wanted, settings, now, True, generator)
            return Decision(counts, now.may_settle, note)
    if criterion.spends == "deviation":
        return share_out_with_chances(importance, evidence.wanted, settings, now, generator)
    counts = share_out(importance, evidence.wanted, settings, now, False, generator)
    return Decision(counts, importance=importance)


def share_out_with_chances(
    importance: Floats, wanted: Floats, settings: Settings, now: Situation, generator: np.random.Generator
) -> Decision:
    """Share out the samples of a round; pixels that would get none may have one by chance, see ``tracer.film.bias``."""
    counts = share_out(importance, wanted, settings, now, True, generator)
    left_out = (counts == now.drawn) & (wanted > 0) & (now.drawn < settings.most_samples)
    chance = np.where(left_out, bias.chances(importance), counts > now.drawn)
    size = bias.samples_by_chance(now.drawn)
    expected, left = (chance * size)[left_out].sum(), now.goal - int(now.drawn.sum())
    share = min(1.0, MOST_BY_CHANCE * (left - int((counts > now.drawn).sum())) / max(expected, 1e-9))
    if expected == 0 or share < LEAST_THINNED:
        return Decision(counts, importance=importance, chance=(counts > now.drawn).astype(np.float32))
    chance = np.where(left_out, chance * share, chance)
    picked = left_out & (generator.random(chance.shape) < chance)
    # Whoever had a sample has one still, and whoever was not picked has none, or the chance would be another one.
    lower = now.drawn + np.where(picked, size, counts > now.drawn)
    upper = np.where(left_out & ~picked, now.drawn, np.maximum(settings.most_samples, lower))
    least = least_counts(wanted, settings, now, settings.least_samples)
    if np.maximum(least, lower).sum() > now.goal:
        return Decision(counts, importance=importance, chance=(counts > now.drawn).astype(np.float32))
    counts = share_out(importance, wanted, settings, now, True, generator, (lower, upper))
    return Decision(counts, importance=importance, chance=chance.astype(np.float32))


def share_out(
    importance: Floats,
    wanted: Floats,
    settings: Settings,
    now: Situation,
    suits: bool,
    generator: np.random.Generator,
    bounds: tuple[Counts, Counts] | None = None,
) -> Counts:
    """Return counts (H, W) in proportion to importance, within bounds; ``suits``: most of them powers of two.

    ``bounds`` (H, W) each: least and most counts, beside those of the settings.
    """
    if np.ptp(importance) == np.ptp(now.drawn) == 0 and now.goal % importance.size == 0:
        return np.full(importance.shape, now.goal // importance.size, np.uint32)
    least = least_counts(wanted, settings, now, settings.least_samples)
    most: Floats | int = settings.most_samples
    if bounds is not None:
        most = np.minimum(most, bounds[1]).astype(np.float64)
        least = np.minimum(np.maximum(least, bounds[0]), most)
    target = budget.fill(importance, now.goal, least, most)
    if suits:  # other criteria are as they say, and not as we would
        target = budget.suit_sequence(target, now.goal, least, most)
    return budget.round_to_total(target, now.goal, generator)


def least_counts(wanted: Floats, settings: Settings, now: Situation, default: int) -> Floats:
    """Return the least samples (H, W) that each pixel is to have: ``min_spp``, else ``default`` where it is wanted.

    They grow with the budget: reached at once, they could ask for more than is left to share out. Where they do all the
    same, each is missed by the same part.
    """
    grown = now.goal / now.total
    least = np.where(wanted > 0, max(1.0, default * grown), 1.0)
    if settings.min_spp is not None:
        least = np.full(wanted.shape, max(1.0, settings.min_spp * grown))
    drawn = now.drawn.astype(np.float64)
    missing = np.maximum(np.floor(least) - drawn, 0.0)
    left = max(now.goal - drawn.sum(), 0.0)
    if missing.sum() > left:  # a render that was stopped where some pixels had their samples and others did not
        missing = np.floor(missing * (left / missing.sum()))
    return drawn + missing


def cost_of_sample(statistics: Statistics) -> Floats:
    """Return what a sample of each pixel costs (H, W): its rays, averaged over 3 x 3 neighbours."""
    return np.maximum(uniform_filter(statistics.rays, 3, mode="nearest"), 1.0).astype(np.float64)


def predicted_gain(deviation: Floats, share: Floats, cost: Floats) -> float:
    """Return the gain over uniform sampling of n ~ ``share`` at equal cost, with s and c per pixel.

    The error sum s^2 / n times the cost sum n c, against sum s^2 sum c if uniform. With equal costs and n ~ s that is
    1 + CV^2 of s (Neyman, 1934). At equal cost, not at equal samples: those spared may have cost next to nothing.
    """
    if not np.any(deviation > 0):
        return 1.0
    with np.errstate(divide="ignore", invalid="ignore"):  # 0 / 0 is not chosen; without a share the gain is 0
        error = np.where(deviation > 0, deviation**2 / share, 0.0)
    return float(np.mean(deviation**2) * np.mean(cost) / (np.mean(error) * np.mean(share * cost)))


def predicted_overhead(statistics: Statistics, now: Situation) -> float:
    """Return the part of the time of uniform sampling that this decision takes; later ones need not be made.

    Counted in rays, not in seconds, so that a picture does not depend on how busy the machine is.
    """
    rays = max(float(statistics.rays.mean()), 1.0) * (now.horizon or now.total) / now.drawn.size
    return RAYS_PER_DECISION / rays


def relative(importance: NDArray[np.float64]) -> NDArray[np.float32]:
    """Return an importance (H, W) as a multiple of its mean; zeros where that is not a number."""
    mean = float(importance.mean())
    return (importance / mean if 0 < mean < np.inf else np.zeros_like(importance)).astype(np.float32)

"""Share the samples of a round out to pixels by their importance, within bounds; some may be left to chance."""

from __future__ import annotations

from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from tracer.adaptive import budget
from tracer.adaptive.decision import Decision, Situation
from tracer.core.arrays import Counts, Floats
from tracer.core.device import to_host, upload
from tracer.core.reductions import sums
from tracer.film import bias
from tracer.settings import Settings

MOST_BY_CHANCE = 0.25
"""Largest part of a round that is given by chance, of its samples beyond one for every pixel that gets some."""
LEAST_THINNED = 0.25
"""Least factor by which the chances may be thinned for a round that lacks room for them. With less, nothing is left to
chance, as the few pixels picked would count too much."""


def share_out_with_chances(
    importance: Floats, weights: Floats, settings: Settings, situation: Situation, generator: np.random.Generator
) -> Decision:
    """Allocate the samples of a round by importance; pixels that would get none may have some by chance.

    ``weights`` (H, W): what the person wants more of, see ``importance_map``. For the chances see ``tracer.film.bias``.
    """
    shape = importance.shape
    drawn, values = upload(mi.UInt32, situation.drawn), upload(mi.Float64, importance)
    least = least_counts(weights, settings, situation, settings.least_samples)
    most = dr.opaque(mi.Float64, settings.most_samples, dr.width(values))
    target = budget.fill_about(values, situation.goal, least, most)
    rounded, shift = budget.powers_of_two(target, situation.goal, least, most)
    gets_samples = rounded(shift) > mi.Float64(drawn)
    left_out = ~gets_samples & upload(mi.Bool, weights > 0) & (drawn < dr.opaque(mi.UInt32, settings.most_samples))
    size = bias.samples_by_chance(drawn)
    chance = bias.chances(values)
    dr.eval(gets_samples, left_out, size, chance)
    expected, served_count = sums(dr.select(left_out, chance * size, mi.Float64(0)), number(gets_samples))
    remaining = situation.goal - int(situation.drawn.sum())
    share = min(1.0, MOST_BY_CHANCE * (remaining - served_count) / max(expected, 1e-9))
    if expected == 0 or share < LEAST_THINNED:
        return share_out_without_chances(importance, weights, settings, situation, generator)
    chance = dr.select(left_out, chance * dr.opaque(mi.Float64, share), number(gets_samples))
    picked = left_out & (upload(mi.Float64, generator.random(shape)) < chance)
    # Whoever is not left out gets at least one sample, and whoever is left out and not picked gets none: otherwise the
    # chances would differ from those stated.
    lower = mi.Float64(drawn) + dr.select(picked, mi.Float64(size), number(gets_samples))
    most = dr.maximum(dr.opaque(mi.Float64, settings.most_samples), lower)
    upper = dr.select(left_out & ~picked, mi.Float64(drawn), most)
    dr.eval(chance, lower, upper)
    if sums(dr.maximum(least, lower))[0] > situation.goal:
        return share_out_without_chances(importance, weights, settings, situation, generator)
    counts = shared_out(values, weights, settings, situation, True, generator, (lower, upper))
    return Decision(to_host(counts, shape), importance=importance, chance=to_host(mi.Float(chance), shape))


def share_out_without_chances(
    importance: Floats, weights: Floats, settings: Settings, situation: Situation, generator: np.random.Generator
) -> Decision:
    """Allocate the samples of a round by importance; nothing is left to chance."""
    counts = share_out(importance, weights, settings, situation, True, generator)
    return Decision(counts, importance=importance, chance=(counts > situation.drawn).astype(np.float32))


def number(mask: Any) -> Any:
    """Return 1 where an mi.Bool is true and 0 elsewhere, as mi.Float64."""
    return dr.select(mask, mi.Float64(1), mi.Float64(0))


def share_out(
    importance: Floats,
    weights: Floats,
    settings: Settings,
    situation: Situation,
    suits: bool,
    generator: np.random.Generator,
) -> Counts:
    """Return counts (H, W) in proportion to importance (H, W), within bounds; see ``shared_out``."""
    if np.ptp(importance) == np.ptp(situation.drawn) == 0 and situation.goal % importance.size == 0:
        return np.full(importance.shape, situation.goal // importance.size, np.uint32)
    counts = shared_out(upload(mi.Float64, importance), weights, settings, situation, suits, generator)
    return to_host(counts, importance.shape)


def shared_out(
    importance: Any,
    weights: Floats,
    settings: Settings,
    situation: Situation,
    suits: bool,
    generator: np.random.Generator,
    bounds: tuple[Any, Any] | None = None,
) -> Any:
    """Return counts (mi.UInt32) in proportion to importance (mi.Float64), within bounds, row by row.

    ``suits``: whether most counts are made powers of two; ``bounds``: least and most counts, mi.Float64 each, in
    addition to those of the settings.
    """
    least, most = least_counts(weights, settings, situation, settings.least_samples), float(settings.most_samples)
    if bounds is not None:
        most = dr.minimum(bounds[1], dr.opaque(mi.Float64, most))
        least = dr.minimum(dr.maximum(least, bounds[0]), most)
    if suits:  # other criteria are followed to the letter
        target = budget.fill_about(importance, situation.goal, least, most)
        counts = budget.suit_sequence(target, situation.goal, least, most)
    else:
        counts = budget.fill(importance, situation.goal, least, most)
    return budget.round_to_total(counts, situation.goal, generator)


def share_out_more(
    importance: Floats, weights: Floats, settings: Settings, situation: Situation, generator: np.random.Generator
) -> Counts:
    """Return counts (H, W) of which those beyond what is drawn are in proportion to importance, within bounds."""
    drawn = upload(mi.Float64, situation.drawn)
    least = least_counts(weights, settings, situation, 1) - drawn
    most = dr.maximum(dr.opaque(mi.Float64, settings.most_samples) - drawn, least)
    remaining = situation.goal - int(situation.drawn.sum())
    added = budget.fill(upload(mi.Float64, importance), remaining, least, most)
    return situation.drawn + to_host(budget.round_to_total(added, remaining, generator), importance.shape)


def least_counts(weights: Floats, settings: Settings, situation: Situation, default: int) -> Any:
    """Return the least samples that each pixel is to have: ``min_spp``, else ``default`` where weights (H, W) are > 0.

    They grow with the samples spent, as all of them at once could need more than the round has. If they need more all
    the same, every pixel gets the same part of what it lacks. The result is an mi.Float64, row by row.
    """
    grown = situation.goal / situation.total
    wanted_least = max(1.0, (default if settings.min_spp is None else settings.min_spp) * grown)
    other_least = 1.0 if settings.min_spp is None else wanted_least
    is_wanted, drawn = upload(mi.Bool, weights > 0), upload(mi.Float64, situation.drawn)
    least = dr.floor(dr.select(is_wanted, dr.opaque(mi.Float64, wanted_least), dr.opaque(mi.Float64, other_least)))
    missing = dr.maximum(least - drawn, 0.0)
    missing_sum, drawn_sum = sums(missing, drawn)
    remaining = max(situation.goal - drawn_sum, 0.0)
    if missing_sum > remaining:  # a render that was stopped when only some pixels had their samples
        missing = dr.floor(missing * dr.opaque(mi.Float64, remaining / missing_sum))
    return drawn + missing

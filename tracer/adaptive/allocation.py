"""From importance to an allocation: which pixels get the samples of the next round, and whether adapting pays."""

from __future__ import annotations

from dataclasses import replace

import drjit as dr
import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from tracer.adaptive import budget
from tracer.adaptive.decision import Decision, Situation
from tracer.adaptive.prediction import cost_of_sample, predicted_gain, predicted_overhead
from tracer.adaptive.sharing import least_counts, share_out, share_out_more, share_out_with_chances
from tracer.core.arrays import Singles
from tracer.core.device import to_host, upload
from tracer.core.quantities import mean_count
from tracer.criteria import Criterion, Evidence
from tracer.settings import Settings

EXPONENTS = {"none": 0.0, "root": 0.25, "work": 0.5}
"""By which power of its cost a sample's deviation is divided, see ``tracer.settings.Settings.cost``."""


def decide(
    criterion: Criterion, evidence: Evidence, settings: Settings, situation: Situation, generator: np.random.Generator
) -> Decision:
    """Return the decision of a criterion about the next round. Raises BudgetError if no allocation meets the bounds."""
    importance = criterion.evaluate(evidence)
    if not np.all(np.isfinite(importance)):  # radiance beyond what float32 can square
        importance = np.ones_like(importance)
    importance = importance * evidence.wanted
    if criterion.spends == "priority":
        least = least_counts(evidence.wanted, settings, situation, 1)
        served = to_host(least, importance.shape).astype(np.uint32)
        counts = budget.serve(importance, situation.goal, served, settings.most_samples, generator)
        return Decision(counts, importance=importance)
    if criterion.spends == "more":
        counts = share_out_more(importance, evidence.wanted, settings, situation, generator)
        return Decision(counts, importance=importance)
    if criterion.spends == "deviation" and evidence.statistics is not None:
        deviation, cost = upload(mi.Float64, importance), cost_of_sample(evidence.statistics)
        share = deviation * dr.power(cost, -EXPONENTS[settings.cost])
        gain = predicted_gain(share, upload(mi.Float64, evidence.wanted), deviation, cost)
        importance = to_host(share, importance.shape)
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


def relative(importance: NDArray[np.float64]) -> Singles:
    """Return an importance (H, W) as a multiple of its mean; zeros if the mean is zero or not finite."""
    mean = float(importance.mean())
    return (importance / mean if 0 < mean < np.inf else np.zeros_like(importance)).astype(np.float32)

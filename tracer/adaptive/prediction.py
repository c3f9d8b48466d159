"""Predict what an allocation gains over uniform sampling, and what it costs to decide."""

from __future__ import annotations

from typing import Any

import drjit as dr
import mitsuba as mi

from tracer.adaptive.decision import Situation
from tracer.core.device import upload
from tracer.core.reductions import sums
from tracer.core.smoothing import box, smoothed
from tracer.film.estimate import Statistics

WORK_OF_DECISION, WORK_OF_PIXEL, WORK_OF_OBJECT = 1e5, 3.5, 450.0
"""What a decision (statistics, importance, another pass) costs, in all, for each pixel, and for each shape and light of
the scene, all of which Dr.Jit visits before every pass; in the unit of ``tracer.sampling.work``. With two threads a
decision took 16 to 23 ms for 28 000 pixels and 90 ms for 262 000, an empty pass 8 ms for 54 shapes and lights and
180 ms for 2292, and the unit 65 to 192 ns."""


def cost_of_sample(statistics: Statistics) -> Any:
    """Return the cost of a sample of each pixel (mi.Float64, row by row), averaged over 3 x 3 neighbours."""
    height, width = statistics.work.shape
    (mean,) = smoothed(upload(mi.Float, statistics.work), (height, width), box(3))
    return mi.Float64(dr.maximum(mean, 1.0))


def predicted_gain(share: Any, other_share: Any, deviation: Any, cost: Any) -> float:
    """Return the gain at equal cost of samples n in proportion to ``share`` over samples as ``other_share`` has them.

    All are mi.Float64, one entry per pixel. With the deviation s and the cost c of each pixel, error times cost is
    sum s^2 / n times sum n c. With equal costs and n ~ s the gain over uniform sampling is 1 + CV^2 of s (Neyman,
    1934). It is taken at equal cost rather than at equal samples, as the samples that are spared may have cost next to
    nothing. A pixel with a deviation and without a share makes the gain 0.
    """
    errors = [dr.select(deviation > 0, dr.square(deviation) / n, mi.Float64(0)) for n in (share, other_share)]
    error, other_error, spent, other_spent = sums(*errors, share * cost, other_share * cost)
    return other_error * other_spent / (error * spent) if error > 0 else 1.0


def predicted_overhead(statistics: Statistics, situation: Situation) -> float:
    """Return the part of the time of uniform sampling that this decision takes; later decisions can be spared.

    It is counted as work, not in seconds, so that a picture does not depend on how busy the machine is.
    """
    work = max(float(statistics.work.mean()), 1.0) * (situation.horizon or situation.total)
    cost = WORK_OF_DECISION + WORK_OF_PIXEL * situation.drawn.size + cost_of_pass(situation.object_count)
    return cost / work


def cost_of_pass(object_count: int) -> float:
    """Return what a pass costs, in units of work, beside its samples; ``object_count``: number of shapes and lights."""
    return WORK_OF_OBJECT * object_count

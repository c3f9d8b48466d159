"""Measures of the channel between viewpoints and surfaces: how much a view tells, given all other views.

The average of each of the three over the views, with weights p(v), is the mutual information I(V; Z).
"""

from __future__ import annotations

import numpy as np

from tracer.complexity import measures
from tracer.core.arrays import Floats
from tracer.viewpoint.channel import Channel
from tracer.viewpoint.measures.areas import divergence
from tracer.viewpoint.measures.registry import measure
from tracer.viewpoint.observation import Sight


def channel_of(sight: Sight) -> Channel:
    """Return the channel of a view whose measure needs one."""
    assert sight.channel is not None
    return sight.channel


def sums_with(sight: Sight) -> Floats:
    """Return the sums (Z,) of the channel, each at least the projected area in this view, times the weights.

    With weights a surface is expected to be seen as much more as it counts more, which makes the mutual information
    Feixas's extended one (Feixas, Sbert and Gonzalez 2009, section 7). A channel of other viewpoints may lack surfaces
    that this view alone sees.
    """
    sums = channel_of(sight).sums.copy()
    sums[sight.surfaces] = np.maximum(sums[sight.surfaces], sight.projected)
    return sums * sight.subject.weights


@measure("mutual_information", "least", "channel")
def mutual_information(sight: Sight) -> float:
    """Return VMI, also called I1, in bits: the divergence of p(z|v) from p(z); infinite if nothing is seen.

    With weights, surfaces of weight 0 are left out, and it is infinite if nothing is seen that counts.
    """
    return max(divergence(sight, sums_with(sight)), 0.0)  # a value below 0 comes from rounding


@measure("information_2", "least", "channel")
def information_2(sight: Sight) -> float:
    """Return I2 = H(Z) - H(Z|v) in bits, negative if areas are more even in the view than in all views together.

    It is infinite if nothing is seen that counts. With weights, both are weighted entropies.

    M. DeWeese and M. Meister, "How to measure the information gained from one symbol", Network 10(4), 1999.
    """
    if not np.any(sight.weights > 0):
        return float("inf")
    of_all_views = float(measures.weighted_entropy(channel_of(sight).sums, sight.subject.weights))
    return of_all_views - float(measures.weighted_entropy(sight.projected, sight.weights))


@measure("information_3", "most", "channel")
def information_3(sight: Sight) -> float:
    """Return I3 = sum p(z|v) I2(z) in bits, with I2(z) = H(V) - H(V|z): surfaces that few views see count most.

    D. Butts, "How much information is associated with a particular stimulus?", Network 14(2), 2003.
    """
    channel = channel_of(sight)
    return float(
        np.sum(sight.weights * sight.shares * (channel.view_entropy - channel.entropy_of_views[sight.surfaces]))
    )

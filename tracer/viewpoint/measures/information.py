"""Measures of the channel between viewpoints and surfaces: how much a view says, given all others.

Averaged over views with the weights p(v), all three are the mutual information I(V; Z).
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
    """Return the channel."""
    assert sight.channel is not None
    return sight.channel


def sums_with(sight: Sight) -> Floats:
    """Return the sums of the channel (Z,), where it is of other views with what this one alone sees."""
    sums = channel_of(sight).sums.copy()
    sums[sight.surfaces] = np.maximum(sums[sight.surfaces], sight.projected)
    return sums


@measure("mutual_information", "least", "channel")
def mutual_information(sight: Sight) -> float:
    """Return VMI, or I1, in bits: the divergence of p(z|v) from p(z); infinite where nothing is seen."""
    return max(divergence(sight, sums_with(sight)), 0.0)  # less is rounding


@measure("information_2", "least", "channel")
def information_2(sight: Sight) -> float:
    """Return I2 = H(Z) - H(Z|v) in bits, negative if the view is more even than all together.

    M. DeWeese and M. Meister, "How to measure the information gained from one symbol", Network 10(4), 1999.
    """
    if not len(sight.surfaces):
        return float("inf")
    return channel_of(sight).surface_entropy - float(measures.entropy(sight.projected))


@measure("information_3", "most", "channel")
def information_3(sight: Sight) -> float:
    """Return I3 = sum p(z|v) I2(z) in bits, with I2(z) = H(V) - H(V|z): surfaces that few views see count most.

    D. Butts, "How much information is associated with a particular stimulus?", Network 14(2), 2003.
    """
    channel = channel_of(sight)
    return float(np.sum(sight.shares * (channel.view_entropy - channel.entropy_of_views[sight.surfaces])))

"""Measures of saliency, that is how differently a surface is seen from its neighbours, see ``Channel.saliency``."""

from __future__ import annotations

import numpy as np

from tracer.viewpoint.measures.areas import divergence
from tracer.viewpoint.measures.information import channel_of, sums_with
from tracer.viewpoint.measures.registry import measure
from tracer.viewpoint.observation import Sight


@measure("visible_saliency", "most", "channel", "saliency")
def visible_saliency(sight: Sight) -> float:
    """Return the sum of the saliency of the surfaces that are seen, in bits, each counted with its weight."""
    return float(np.sum(sight.weights * channel_of(sight).saliency[sight.surfaces]))


@measure("projected_saliency", "most", "channel", "saliency")
def projected_saliency(sight: Sight) -> float:
    """Return the sum in bits of S(z) p(v|z): the saliency of a surface times the share that this view has of it.

    p(v|z) is the projected area of z in this view over the sum of its projected areas in all views. Surfaces are
    counted with their weights.
    """
    sums = np.maximum(channel_of(sight).sums[sight.surfaces], sight.projected)
    return float(np.sum(sight.weighted / sums * channel_of(sight).saliency[sight.surfaces]))


@measure("salient_mutual_information", "least", "channel", "saliency")
def salient_mutual_information(sight: Sight) -> float:
    """Return the divergence in bits of p(z|v) from p(z) S(z), normalised: low if salient surfaces are seen most.

    Surfaces of saliency 0 count only in the projected area of which p(z|v) is a share, as in the program of the survey
    (github.com/limdor/quoniam); those of weight 0 do not even there. Unlike in that program, a view that sees no
    salient surface is the worst: infinite. If all saliencies are 0, no surface is preferred, and the result is the
    mutual information.
    """
    sums = sums_with(sight)
    expected = sums * channel_of(sight).saliency
    return divergence(sight, expected if expected.sum() > 0 else sums)

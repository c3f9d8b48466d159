"""Measures of saliency: of surfaces that are seen otherwise than those beside them, see ``Channel.saliency``."""

from __future__ import annotations

import numpy as np

from tracer.viewpoint.measures.areas import divergence
from tracer.viewpoint.measures.information import channel_of, sums_with
from tracer.viewpoint.measures.registry import measure
from tracer.viewpoint.observation import Sight


@measure("visible_saliency", "most", "channel", "saliency")
def visible_saliency(sight: Sight) -> float:
    """Return the sum of the saliency of the surfaces that are seen, in bits."""
    return float(channel_of(sight).saliency[sight.surfaces].sum())


@measure("projected_saliency", "most", "channel", "saliency")
def projected_saliency(sight: Sight) -> float:
    """Return the sum over surfaces of saliency times the share p(v|z) of what is ever seen of them, in bits."""
    shares = sight.projected / sums_with(sight)[sight.surfaces]
    return float(np.sum(shares * channel_of(sight).saliency[sight.surfaces]))


@measure("salient_mutual_information", "least", "channel", "saliency")
def salient_mutual_information(sight: Sight) -> float:
    """Return the divergence in bits of p(z|v) from p(z) S(z), normalised: low if what is salient is seen most.

    Surfaces of saliency 0 add nothing but to the projected area that p(z|v) is a share of, as in the program of the
    survey (github.com/limdor/quoniam). Unlike there, a view that sees no other surface is the worst, infinite. Where
    the saliency of all is 0, none is preferred: the mutual information.
    """
    sums = sums_with(sight)
    wanted = sums * channel_of(sight).saliency
    return divergence(sight, wanted if wanted.sum() > 0 else sums)

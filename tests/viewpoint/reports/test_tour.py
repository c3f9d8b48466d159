"""What a tour takes for good."""

from dataclasses import replace

import numpy as np
import pytest

from tracer.viewpoint.direction_measure import Gauge, stand
from tracer.viewpoint.item_buffer import Rays
from tracer.viewpoint.lens import Orthographic
from tracer.viewpoint.reports.tour import goodness
from tracer.viewpoint.surfaces import open_subject

BESIDE = np.array([30.0, 0, 0])
"""The cube around the origin is seen from there in one direction only."""


@pytest.mark.parametrize("rays", [Rays(side=32), Rays(random=1000)])
@pytest.mark.parametrize("good", ["most", "least"])
def test_a_view_of_nothing_is_worth_nothing(quads, rays, good):
    subject = open_subject(quads, "shape")
    gauge = Gauge(subject, replace(stand(subject, 20.0, BESIDE), lens=Orthographic(1)), rays, "entropy", good=good)
    axes = np.concatenate([np.eye(3), -np.eye(3)])
    values = gauge(axes)
    assert gauge.seen.tolist() == [True] + 5 * [False]
    assert values[1:].tolist() == 5 * [0]
    worth = goodness(gauge, values)
    assert worth(axes) == pytest.approx([values[0] if good == "most" else 0, 0, 0, 0, 0, 0])

"""The figure of curves can be read."""

from itertools import pairwise

import pytest
from matplotlib.figure import Figure

from benchmarks.radiosity.convergence import RAYS, Curve
from benchmarks.radiosity.figures import draw_errors


@pytest.mark.parametrize("seconds", [(0.1, 0.6, 2.2), (0.16, 0.7, 3.0), (0.02, 0.3, 4.0)])
def test_no_label_of_an_axis_overlaps_its_neighbour(seconds):
    curves = [Curve("a", "evenly", rays, [2 / rays, 3 / rays], 1.0, rays, 0.0) for rays in RAYS]
    figure = Figure(figsize=(2.6, 2.6), dpi=90)
    axis = figure.subplots()
    draw_errors(axis, "seconds", list(seconds), curves)
    figure.canvas.draw()
    labels = [label for label in axis.get_xticklabels(which="both") if label.get_text()]
    inside = [label.get_window_extent() for label in labels if label.get_window_extent().x1 < figure.bbox.x1]
    boxes = sorted(inside, key=lambda box: box.x0)
    assert len(boxes) >= 2
    assert all(left.x1 < right.x0 for left, right in pairwise(boxes))

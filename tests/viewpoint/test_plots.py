"""Spheres of viewpoints: marks have colours of the scale, and names that cover no title and are not cut off."""

import numpy as np
import pytest

from tracer.core.sphere import icosphere
from tracer.viewpoint.plots import Mark, draw_sphere, figure

UP = np.array([0.0, 0, 1])
DIRECTIONS, TRIANGLES = icosphere(1)
VALUES = 5 + 0.5 * DIRECTIONS[:, 2]


def drawn(marks):
    """Return the figure, its discs and the coloured patches of a sphere with marks."""
    plot = figure(6.4, 3.1)
    discs = plot.subplots(1, 2)
    patches = draw_sphere(discs, DIRECTIONS, TRIANGLES, VALUES, UP, marks=marks)
    plot.canvas.draw()
    return plot, discs, patches


def test_the_scale_has_the_values_of_marks():
    """A narrow well of a measure lies between the viewpoints of the grid."""
    _, discs, patches = drawn({"best": Mark(UP, 3.7), "unknown": Mark(-UP, np.inf)})
    assert patches.get_clim() == pytest.approx([3.7, VALUES.max()])
    (dot,) = (line for line in discs[0].lines if line.get_marker() == "o")
    assert dot.get_markerfacecolor() == pytest.approx(patches.cmap(0.0))
    assert drawn({})[2].get_clim() == pytest.approx([VALUES.min(), VALUES.max()])


@pytest.mark.parametrize("degrees", range(0, 360, 30))
def test_names_of_marks_on_the_rim_cover_no_title(degrees):
    direction = np.array([np.cos(np.radians(degrees)), np.sin(np.radians(degrees)), 0])
    plot, discs, _ = drawn({"exhaustive": Mark(direction, 5.0)})
    for disc in discs:
        (name,) = disc.texts
        text, title = (part.get_window_extent() for part in (name, disc.title))
        assert not text.overlaps(title)
        assert plot.bbox.x0 <= text.x0 < text.x1 <= plot.bbox.x1
        assert plot.bbox.y0 <= text.y0 < text.y1 <= plot.bbox.y1
        (dot,) = (line for line in disc.lines if line.get_marker() == "o")
        assert not dot.get_clip_on()


def test_marks_of_one_direction_have_all_names():
    nearly_up = np.array([0, 1e-3, 1])
    _, discs, _ = drawn({"paper": Mark(UP, 1.0), "octants": Mark(-UP, 1.0), "exhaustive": Mark(nearly_up, 1.0)})
    assert [text.get_text() for disc in discs for text in disc.texts] == ["paper, exhaustive", "octants"]

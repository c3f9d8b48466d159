"""Parts of paths add up to the paths, and the parts of each choice are where they belong."""

import numpy as np
import pytest

from benchmarks.guiding import paths
from guiding.lights import scene_with_lights
from tracer.guiding.slots import slots_of
from tracer.scene.view import open_scene
from tracer.session.guidance import guided_view


@pytest.fixture
def followed():
    with open_scene(scene_with_lights("area", "sky", size=(16, 16))) as opened:
        view = guided_view(opened)
        yield paths.follow(view, slots_of(view.scene), 3, 1 << 14)


def test_parts_add_up_to_the_whole(followed):
    assert followed.steps.sum(axis=0) == pytest.approx(followed.paths.radiance, rel=1e-4, abs=1e-6)
    assert np.all(followed.steps > -1e-6)
    assert len(followed.steps) == len(followed.costs) == 5  # max_depth is 5


def test_each_part_has_fewer_vertices_than_that_before(followed):
    assert followed.costs[0] == 1
    assert np.all(np.diff(followed.costs) <= 0)


def test_light_and_direction_share_what_comes_after_a_vertex(followed):
    """After the first vertex all that is not emitted by what the camera sees comes from the light or the direction."""
    first = followed.directions[0]
    count = len(first.path)
    by_light = followed.lights.given[:count] / followed.lights.chance[:count]
    by_direction = first.given / first.chance
    behind = followed.steps[1:, first.path].sum(axis=0)
    assert by_light + by_direction == pytest.approx(behind, rel=1e-4, abs=1e-6)
    assert np.all(by_direction > -1e-5)
    assert set(np.unique(first.slot)) == set(range(paths.BINS**2))


def test_bins_of_directions_are_even(followed):
    counts = np.bincount(followed.directions[0].slot, minlength=paths.BINS**2)
    assert counts == pytest.approx(counts.mean(), rel=0.2)

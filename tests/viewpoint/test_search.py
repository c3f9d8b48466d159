"""Searches on functions whose best direction is known, and on a scene."""

from dataclasses import replace

import mitsuba as mi
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tracer.core import sphere
from tracer.viewpoint import measures
from tracer.viewpoint.direction_measure import Gauge, ring, stand
from tracer.viewpoint.item_buffer import Rays
from tracer.viewpoint.lens import Orthographic, Perspective
from tracer.viewpoint.search import exhaustive_search, paper_search
from tracer.viewpoint.surfaces import open_subject

FINITE = st.floats(-1, 1)
DIRECTIONS = st.tuples(FINITE, FINITE, FINITE).filter(lambda v: np.linalg.norm(v) > 1e-2).map(sphere.normalised)


class Counted:
    """A function that counts what it is asked."""

    def __init__(self, function):
        self.function, self.count, self.seen = function, 0, []

    def __call__(self, directions):
        self.count += len(directions)
        self.seen.append(directions)
        return self.function(directions)


@settings(deadline=None)  # how long it takes depends on what else the machine does
@given(DIRECTIONS)
def test_the_exhaustive_search_finds_a_single_peak(best):
    value = Counted(lambda directions: directions @ best)
    found = exhaustive_search(value, level=1)
    assert sphere.angle(found.direction, best) < np.radians(0.2)
    assert found.evaluations == value.count
    assert found.value == pytest.approx(1, abs=1e-5)


@settings(deadline=None)  # how long it takes depends on what else the machine does
@given(DIRECTIONS)
def test_the_papers_search_never_ends_below_its_start(best):
    value = Counted(lambda directions: directions @ best)
    found = paper_search(value)
    axes = sphere.octants()[0]
    assert found.value >= (axes @ best).max()
    assert found.value == pytest.approx(found.direction @ best)
    assert found.evaluations == value.count
    assert np.all(np.sign(found.direction) * np.sign(np.where(np.abs(best) < 1e-9, 0, best)) >= 0)
    assert [value for _, value in found.steps] == sorted(value for _, value in found.steps)
    everywhere = paper_search(value, all_octants=True)
    assert everywhere.value >= found.value


def test_the_papers_search_by_hand():
    best = sphere.normalised([0.9, 0.5, 0.4])
    value = Counted(lambda directions: directions @ best)
    found = paper_search(value)
    x, y, z = np.eye(3)
    assert value.seen[1] == pytest.approx(np.stack([sphere.middle(x, y), sphere.middle(x, z)]))
    # (x + y) / sqrt 2 is better than x: next are its middles with x and (x + z) / sqrt 2.
    corner = sphere.middle(x, y)
    assert value.seen[2] == pytest.approx(
        np.stack([sphere.middle(corner, sphere.middle(x, z)), sphere.middle(corner, x)])
    )
    assert sphere.angle(found.direction, best) < np.radians(20)


def test_ends_of_one_axis_that_are_both_good_do_not_confuse_the_search():
    found = paper_search(lambda directions: np.abs(directions[:, 2]) + 1e-3 * directions @ [0.1, 0.2, 0.05])
    assert found.direction == pytest.approx([0, 0, 1])


def test_narrow_wells_need_a_hint():
    axis = sphere.normalised([1.0, 1.0, 0.3])

    def well(directions):
        return np.maximum(1 - sphere.angle(directions, axis) / np.radians(1), 0)

    assert exhaustive_search(well, level=1).value == 0
    assert exhaustive_search(well, level=1, also=axis[None]).value == pytest.approx(1)


def test_a_ring_is_at_its_angle():
    directions = ring(sphere.normalised([1.0, 2.0, 3.0]), 0.3)
    assert sphere.angle(directions, sphere.normalised([1.0, 2.0, 3.0])) == pytest.approx(np.full(6, 0.3))
    assert sphere.angle(directions[0], directions[3]) == pytest.approx(0.6)


def test_a_stand_fills_the_image():
    subject = open_subject(mi.load_dict({"type": "scene", "ball": {"type": "cube"}}))
    assert stand(subject).distance == pytest.approx(6 * 3**0.5)
    assert stand(subject).lens.field_of_view == pytest.approx(19.188, abs=1e-3)  # 2 asin(1/6), the survey's
    assert isinstance(stand(subject, orthographic=True).lens, Orthographic)
    assert stand(subject, distance=0.5).lens.field_of_view == pytest.approx(120)


@pytest.mark.parametrize("name", sorted(measures.names()))
def test_every_measure_can_be_searched(name, triangles):
    subject = open_subject(triangles)
    gauge = Gauge(subject, stand(subject), Rays(side=48), name, good=measures.get(name).best)
    values = gauge(np.array([[0, 0, 1.0], [1, 1, 1]]))
    assert np.all(np.isfinite(values))
    found = paper_search(gauge.better)
    assert gauge.sign * found.value == pytest.approx(gauge(found.direction[None])[0], rel=1e-6)
    assert gauge.evaluations > found.evaluations


def test_the_best_view_of_a_cube_is_its_corner(triangles):
    subject = open_subject(triangles)
    gauge = Gauge(subject, stand(subject, orthographic=True), Rays(side=256), "entropy", background=False)
    found = exhaustive_search(gauge.better, level=1)
    assert np.abs(found.direction) == pytest.approx(np.full(3, 3**-0.5), abs=0.03)
    assert found.value == pytest.approx(1 + np.log2(3), abs=2e-3)
    assert found.evaluations == gauge.evaluations


@pytest.mark.parametrize("rays", [Rays(side=64), Rays(random=3000)])
@pytest.mark.parametrize(("lens", "background"), [(Orthographic(1), False), (Perspective(10), True)])
def test_a_view_of_one_surface_is_a_view(quads, rays, lens, background):
    """With an entropy of 0: of parallel rays all that hit do so on one face; near by, it fills the image."""
    subject = open_subject(quads, "shape")
    place = replace(stand(subject), distance=1.0, lens=lens)
    gauge = Gauge(subject, place, rays, "entropy", background, "least")
    axes = np.concatenate([np.eye(3), -np.eye(3)])
    assert gauge.better(axes).tolist() == 6 * [0]
    assert gauge.sighted
    assert exhaustive_search(gauge.better, level=0, also=axes).value == 0


@pytest.mark.parametrize("rays", [Rays(side=64), Rays(random=3000)])
def test_a_view_of_nothing_is_none(quads, rays):
    subject = open_subject(quads, "shape")
    gauge = Gauge(subject, stand(subject, centre=np.array([90.0, 0, 0]), distance=1.0), rays, "entropy", good="least")
    assert gauge.better(-np.eye(3)[1:]).tolist() == [-np.inf, -np.inf]
    assert not gauge.sighted

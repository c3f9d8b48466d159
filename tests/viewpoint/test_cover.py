"""View sets: complete, small, and honest about what cannot be seen."""

import itertools

import mitsuba as mi
import numpy as np
import pytest

from tracer.core import sphere
from tracer.viewpoint import cover as module
from tracer.viewpoint.cover import cover
from tracer.viewpoint.item_buffer import Rays, Viewpoints, around, projected_areas
from tracer.viewpoint.lens import Orthographic
from tracer.viewpoint.surfaces import open_subject

from .conftest import mesh_scene

RAYS = Rays(side=96)
CORNERS = sphere.normalised(list(itertools.product((-1.0, 1.0), repeat=3)))
DIRECTIONS = np.concatenate([np.eye(3), -np.eye(3), sphere.icosphere(1)[0], CORNERS])


@pytest.fixture
def cube(quads):
    subject = open_subject(quads, "shape")
    return subject, around(subject.centre, 3, DIRECTIONS), Orthographic(1)


@pytest.mark.parametrize("rule", ["entropy", "area", "divergence"])
def test_a_cube_needs_two_views_of_corners(cube, rule):
    found = cover(*cube, RAYS, quality=0.5, rule=rule)
    assert len(found.chosen) == 2
    assert found.covered[-1] == pytest.approx(1)
    assert np.dot(*DIRECTIONS[found.chosen]) < -0.3  # opposite corners
    assert len(found.unseen) == 0


def test_six_views_if_each_face_must_be_seen_from_its_front(cube):
    found = cover(*cube, RAYS, quality=0.999)
    assert sorted(found.chosen) == list(range(6))


@pytest.mark.parametrize("quality", [0.2, 0.5, 0.8])
@pytest.mark.parametrize("rule", ["entropy", "area", "divergence"])
def test_all_that_is_visible_is_shown_well(quality, rule, triangles):
    subject = open_subject(triangles)
    views, lens = around(subject.centre, 3, sphere.icosphere(1)[0]), Orthographic(1)
    areas = np.concatenate([batch.areas for batch in projected_areas(subject, views, lens, RAYS)])
    shows = (areas >= quality * areas.max(axis=0)) & (areas > 0)
    found = cover(subject, views, lens, RAYS, quality, rule)
    assert np.all(shows[found.chosen].any(axis=0))
    for left_out in found.chosen:
        assert not np.all(shows[[k for k in found.chosen if k != left_out]].any(axis=0))
    sizes = range(1, len(found.chosen))
    fewest = (
        next(
            (n for n in sizes if any(np.all(shows[list(c)].any(axis=0)) for c in itertools.combinations(range(42), n))),
            len(found.chosen),
        )
        if len(found.chosen) <= 4
        else 4
    )
    assert len(found.chosen) <= (1 + np.log(12)) * fewest


def test_what_no_view_sees_is_reported():
    small = mi.ScalarTransform4f().scale(0.3)
    scene = {"type": "scene", "box": {"type": "cube"}, "hidden": {"type": "cube", "to_world": small}}
    subject = open_subject(mi.load_dict(scene), "shape")
    found = cover(subject, around(subject.centre, 5, DIRECTIONS), Orthographic(2), RAYS)
    assert [subject.names[k] for k in found.unseen] == ["hidden"]
    assert found.unseen_area == pytest.approx(0.09 / 1.09)
    assert found.covered[-1] == pytest.approx(1)


def test_it_can_end_early_and_says_how_far_it_is(cube):
    told = []
    found = cover(*cube, RAYS, quality=0.999, most=3, told=lambda views, covered: told.append((views, covered)))
    assert len(found.chosen) == 3
    assert found.covered == pytest.approx([1 / 6, 2 / 6, 3 / 6])
    chosen = [step for step in told if step[0] > 0]  # before, it looks
    assert len(chosen) < len(told)
    assert [views for views, _ in chosen] == [1, 2, 3]
    assert [covered for _, covered in chosen] == pytest.approx(found.covered)


def steps(heights):
    """Return a mesh of squares in planes that lie across x, one for each of several directions, of given sizes."""
    angles = np.arange(len(heights)) * 2 * np.pi / len(heights)
    across = np.stack([-np.sin(angles), np.cos(angles), np.zeros(len(heights))], axis=-1)
    middle = 4 * np.stack([np.cos(angles), np.sin(angles), np.zeros(len(heights))], axis=-1)
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, -1], [1, 1], [-1, 1]]) * np.array([0.1, 1])
    flat = corners[:, :1] * across[:, None] + corners[:, 1:] * np.array([0, 0, 1.0]) * np.array(heights)[:, None, None]
    points = (middle[:, None] + flat).reshape(-1, 3)
    outward = np.stack([np.cos(angles), np.sin(angles), np.zeros(len(heights))], axis=-1)
    return points, np.repeat(np.arange(len(heights)), 2), outward


@pytest.mark.parametrize(("gain", "count"), [(0.0, 5), (0.05, 4), (0.15, 3), (0.21, 2), (0.5, 1)])
def test_a_set_ends_when_no_view_adds_enough(gain, count):
    """Five plates, each of which one view shows well: of 40, 25, 20, 12 and 3 % of the area."""
    points, groups, outward = steps([4.0, 2.5, 2.0, 1.2, 0.3])
    subject = open_subject(mesh_scene(points, np.arange(len(points)).reshape(-1, 3)), groups=groups)
    eyes = 4 * outward
    up = np.tile([0.0, 0, 1], (5, 1))
    views = Viewpoints(eyes + outward, -outward, np.cross(-outward, up), up)
    found = cover(subject, views, Orthographic(5), Rays(side=256), quality=0.9, rule="area", gain=gain)
    assert found.chosen.tolist() == list(range(count))
    assert found.covered == pytest.approx(np.cumsum([0.4, 0.25, 0.2, 0.12, 0.03])[:count])
    assert found.missing.tolist() == list(range(count, 5))
    assert found.missing_share == pytest.approx(1 - found.covered[-1])
    assert found.ended == ("enough" if count == 5 else "gain")


def test_looking_again_finds_the_same(cube, monkeypatch):
    first = cover(*cube, RAYS)
    monkeypatch.setattr(module, "MOST_KEPT", 0)
    again = cover(*cube, RAYS)
    assert np.array_equal(first.chosen, again.chosen)
    assert np.array_equal(first.covered, again.covered)


def test_a_scene_that_no_view_sees(quads):
    subject = open_subject(quads, "shape")
    away = around(np.array([90.0, 0, 0]), 3, DIRECTIONS[[1, 3]])
    found = cover(subject, away, Orthographic(1), RAYS)
    assert len(found.chosen) == 0
    assert found.unseen_area == pytest.approx(1)


def squares(count, cell, at):
    """Return the triangles of ``count`` squares side by side, each ``cell`` wide, in the plane z = 0."""
    corners = np.array([[0, 0], [1, 0], [1, 1], [0, 0], [1, 1], [0, 1]], float)
    shifts = np.stack([np.arange(count), np.zeros(count)], axis=-1)
    flat = at + cell * (shifts[:, None] + corners).reshape(-1, 2)
    return np.column_stack([flat, np.zeros(len(flat))])


def test_what_is_shown_adds_nothing_to_the_entropy_of_the_next_view():
    """Three windows: on 16 squares and 4 more, on the same 16 and 1, and on 2 others of which no view has seen any.

    The first has the largest entropy and shows 20. By all that it sees, the second would be next, with 17 squares to 2;
    but of these all but one are shown, so that the third is, with 2 new ones.
    """
    placed = ((16, [0.0, 0.0]), (4, [0.0, 0.2]), (1, [0.0, -0.2]), (2, [9.0, 0.0]))
    points = np.concatenate([squares(count, 0.1, at) for count, at in placed])
    groups = np.repeat(np.arange(23), 2)
    subject = open_subject(mesh_scene(points, np.arange(len(points)).reshape(-1, 3)), groups=groups)
    reach = 0.85
    # The first sees from y = -0.05 on, not the square below; the second up to y = 0.15, not the four above.
    middles = np.array([[0.8, reach - 0.05, 5], [0.8, 0.15 - reach, 5], [9.1, 0.05, 5]])
    down = np.tile([0.0, 0, -1], (3, 1))
    views = Viewpoints(middles, down, np.tile([1.0, 0, 0], (3, 1)), np.tile([0.0, 1, 0], (3, 1)))
    lens = Orthographic(reach)
    seen = np.concatenate([batch.areas for batch in projected_areas(subject, views, lens, Rays(side=340))]) > 0
    assert seen.sum(axis=1).tolist() == [20, 17, 2]
    assert cover(subject, views, lens, Rays(side=340), rule="entropy").chosen.tolist() == [0, 2, 1]


def test_the_worth_of_a_view_is_the_entropy_of_what_is_missing():
    areas, missing = np.array([1.0, 2, 0, 4], np.float32), np.array([True, False, True, True])
    shares = np.array([1, 4, 11]) / 16  # the background is 9, and the 2 that is shown
    assert module.worth_of(areas, missing, np.ones(4), 16.0) == pytest.approx(-np.sum(shares * np.log2(shares)))

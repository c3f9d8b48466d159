"""Where a person could stand: not in a pillar, not on a table, not behind a wall; and what is seen and walked there."""

import mitsuba as mi
import numpy as np
import pytest

from tracer.viewpoint.inside import LENS, Pose, all_poses, best_inside, value_inside, viewpoints_of
from tracer.viewpoint.item_buffer import Rays, projected_areas
from tracer.viewpoint.novelty import Memory
from tracer.viewpoint.room import EYE_HEIGHT, distance_to, find_room
from tracer.viewpoint.surfaces import open_subject
from tracer.viewpoint.walk import HEAD_TURN, distances_on_foot, is_blocked, smooth_walk, walk, wrapped

UP = np.array([0.0, 0, 1])


def block(low, high):
    low, high = np.array(low, float), np.array(high, float)
    place = mi.ScalarTransform4f().translate((low + high) / 2).scale((high - low) / 2)
    return {"type": "cube", "to_world": place}


def house(**more):
    """Return a scene of two rooms, 4 x 4 x 2.6 each, with a wall between them, a table and a pillar in the first."""
    camera = {"type": "perspective", "to_world": mi.ScalarTransform4f().look_at([1, 1, 1.6], [3, 3, 1], UP)}
    return mi.load_dict(
        {
            "type": "scene",
            "shell": block([0, 0, 0], [8, 4, 2.6]),
            "wall": block([3.9, 0, 0], [4.1, 4, 2.6]),
            "table": block([1.5, 2, 0.7], [3, 3.5, 0.75]),
            "pillar": block([2.8, 0.5, 0], [3.4, 1.1, 2.6]),
            "toy": block([5.8, 1.8, 0], [6.2, 2.2, 0.4]),
            "camera": camera,
            **more,
        },
        optimize=False,
    )


@pytest.fixture(scope="module")
def subject():
    return open_subject(house(), "shape")


@pytest.fixture(scope="module")
def room(subject):
    return find_room(subject, UP)


def test_a_person_stands_on_the_floor_of_the_room_with_the_camera(room):
    x, y, z = room.places.T
    assert len(room.places) > 50
    assert room.height == pytest.approx(2.6, rel=1e-3)
    assert z == pytest.approx(np.full(len(z), EYE_HEIGHT * 2.6), rel=1e-3)
    assert np.all((x > 0) & (x < 3.9) & (y > 0) & (y < 4))  # the other room cannot be reached
    assert not np.any((x > 1.51) & (x < 2.99) & (y > 2.01) & (y < 3.49))  # nor is the table a floor
    assert not np.any((x > 2.8) & (x < 3.4) & (y > 0.5) & (y < 1.1))


def test_a_door_leads_to_the_other_room():
    doors = {"wall": block([3.9, 0, 0], [4.1, 2.8, 2.6])}
    found = find_room(open_subject(house(**doors), "shape"), UP)
    assert (found.places[:, 0] > 4.1).sum() > 30


def test_an_object_is_no_room():
    ball = {"type": "scene", "ball": {"type": "sphere"}}
    assert find_room(open_subject(mi.load_dict(ball)), UP) is None
    camera = {"type": "perspective", "to_world": mi.ScalarTransform4f().look_at([9, 9, 5], [4, 2, 1], UP)}
    outside = open_subject(house(camera=camera), "shape")
    assert find_room(outside, UP) is None  # its camera looks at it from outside
    assert find_room(outside, UP, force=True) is not None
    flat = open_subject(mi.load_dict({"type": "scene", "plate": {"type": "rectangle"}}))
    assert find_room(flat, UP, force=True) is None


def test_nothing_is_between_places_that_are_linked(subject, room):
    start, end = room.places[room.links[:, 0]], room.places[room.links[:, 1]]
    length = np.linalg.norm(end - start, axis=1)
    assert np.all(distance_to(subject, start, (end - start) / length[:, None]) > length)
    assert np.isfinite(distances_on_foot(room)).all()


def test_the_best_view_is_at_least_as_good_as_all_that_are_tried(subject, room):
    value = value_inside(subject, room, "entropy", "most")
    pose, best, poses, values = best_inside(room, value, Rays(side=64))
    assert best[0] >= values.max()
    assert len(poses) == len(all_poses(room)) == len(values)
    assert value(pose, Rays(side=64)) == pytest.approx(best)
    views = viewpoints_of(room, poses)
    for first, second in ((views.forward, views.up), (views.forward, views.right), (views.up, views.right)):
        assert np.abs(np.sum(first * second, axis=1)).max() < 1e-12
    assert np.all(views.up @ UP > 0)


@pytest.mark.parametrize("avoided", ["start", "visited"])
def test_a_walk_goes_from_place_to_place(subject, room, avoided):
    value = value_inside(subject, room, "entropy", "most")
    start = all_poses(room)[:1]
    path = walk(room, value, Rays(side=32), start, 12, avoided)
    assert len(path.poses) == 13
    steps = {tuple(sorted(pair)) for pair in zip(path.poses.place[:-1], path.poses.place[1:], strict=True)}
    assert steps <= {tuple(sorted(pair)) for pair in room.links.tolist()}
    assert np.all(path.weights[1:] > 0)
    assert np.abs(np.diff(path.poses.turn)).max() <= HEAD_TURN + 1e-9
    assert path.distances[0] == 0
    if avoided == "visited":
        assert len(set(path.poses.place)) >= 10
    views = smooth_walk(subject, room, path.poses, 50)
    assert len(views) == 50
    assert not is_blocked(subject, room, views.eyes)


def test_a_curve_through_the_pillar_is_blocked(subject, room):
    curve = np.linspace([2.5, 0.8, 1.6], [3.6, 0.8, 1.6], 20)
    assert is_blocked(subject, room, curve)


def gallery():
    """Return a room, 8 x 4 x 2.6, whose side walls have six pictures each, and the numbers of the pictures."""
    parts = {"type": "scene", "shell": block([0, 0, 0], [8, 4, 2.6])}
    for k in range(6):
        x = 1 + 1.2 * k
        parts[f"left_{k}"] = block([x - 0.3, 0.01, 1.2], [x + 0.3, 0.03, 1.9])
        parts[f"right_{k}"] = block([x - 0.3, 3.97, 1.2], [x + 0.3, 3.99, 1.9])
    subject = open_subject(mi.load_dict(parts, optimize=False), "shape")
    return subject, [number for number, name in enumerate(subject.names) if name[:4] in ("left", "righ")]


@pytest.mark.slow
def test_a_person_looks_at_pictures_on_the_side_walls():
    """A camera that does not know what is new goes on looking at the same few pictures."""
    subject, pictures = gallery()
    found = find_room(subject, UP, force=True)
    value = value_inside(subject, found, "entropy", "most")
    corner = np.linalg.norm(found.places[:, :2] - [1, 2], axis=1).argmin()
    start = Pose(np.array([corner]), np.array([0.0]), np.array([0.0]))
    well = {}
    for memory in (None, Memory(subject, found)):
        poses = walk(found, value, Rays(side=48), start, 60, "start", memory).poses
        views = viewpoints_of(found, poses)
        areas = np.concatenate([batch.areas for batch in projected_areas(subject, views, LENS, Rays(side=64))])
        well[memory is not None] = int((areas[:, pictures].max(axis=0) > 0.02 * LENS.image_area).sum())
        assert np.abs(np.diff(poses.turn)).max() <= HEAD_TURN + 1e-9
    assert well[True] >= 6
    assert well[True] > well[False] + 2


@pytest.mark.parametrize("steps", [7, 30])
def test_a_loop_ends_as_it_starts(subject, room, steps):
    value = value_inside(subject, room, "entropy", "most")
    start = all_poses(room)[500:501]
    path = walk(room, value, Rays(side=24), start, steps, "visited", Memory(subject, room), is_loop=True)
    assert path.poses.place[-1] == start.place[0]
    assert len(set(path.poses.place)) > steps / 3
    assert wrapped(path.poses.turn[-1] - start.turn[0]) == pytest.approx(0, abs=1e-6)
    assert np.abs(np.diff(path.poses.turn)).max() <= HEAD_TURN + 1e-9
    views = smooth_walk(subject, room, path.poses, 4 * steps, is_loop=True)
    gaps = np.linalg.norm(np.diff(views.eyes, axis=0, append=views.eyes[:1]), axis=1)
    assert gaps[-1] < 2 * gaps[:-1].max()
    assert views.eyes[0] == pytest.approx(room.places[start.place[0]])


def test_what_was_seen_is_not_new(subject, room):
    memory, poses = Memory(subject, room), all_poses(room)[:40]
    first = memory.new_share(poses)
    assert set(first.round(6)) <= {0, 1}  # a view of a wall alone has no entropy
    assert np.count_nonzero(first) >= 15
    memory.remember(poses[:20])
    assert memory.new_share(poses[:20]) == pytest.approx(np.zeros(20), abs=1e-6)
    assert memory.new_share(poses[20:]).max() > 0.01

"""Cells: the host and the device agree, and a grid fits its points."""

import mitsuba as mi
import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from tracer.core.device import upload
from tracer.guiding.cells import FACES, CellFinder, Grid


def points_and_normals(seed, count=500):
    random = np.random.default_rng(seed)
    normals = random.normal(size=(count, 3))
    return random.normal(0, (5, 1, 0.2), (count, 3)), normals / np.linalg.norm(normals, axis=-1, keepdims=True)


def on_device(kind, rows):
    return kind(*(upload(mi.Float, column) for column in rows.T))


@given(st.integers(0, 2**32 - 1))
def test_host_and_device_find_the_same_cells(seed):
    points, normals = points_and_normals(seed)
    grid = Grid.around(points, 256)
    found = CellFinder.of(grid).cell(on_device(mi.Point3f, points), on_device(mi.Vector3f, normals)).numpy()
    expected = grid.cells(points, normals)
    assert np.mean(found != expected) < 0.01  # float32 at a border
    assert found.max() < grid.cell_count


def test_faces_are_those_of_the_axes():
    grid = Grid(np.zeros(3), 1.0, (1, 1, 1))
    normals = np.concatenate([-np.eye(3), np.eye(3)])
    assert grid.cells(np.zeros((6, 3)), normals).tolist() == [0, 2, 4, 1, 3, 5]


@given(st.integers(0, 2**32 - 1), st.sampled_from([1, 8, 100, 4096]))
def test_about_as_many_boxes_as_asked_for(seed, count):
    grid = Grid.around(points_and_normals(seed)[0], count)
    assert np.prod(grid.boxes) <= 4 * count + 8
    assert max(grid.boxes) <= count


def test_points_in_a_plane_and_at_one_place_have_a_grid():
    random = np.random.default_rng(0)
    flat = random.random((1000, 3)) * (4, 4, 0)
    columns, rows, layers = Grid.around(flat, 256).boxes
    assert layers == 1
    assert abs(columns - rows) <= 1
    assert rows >= 15
    single = Grid.around(np.ones((10, 3)), 256)
    assert np.ptp(single.cells(np.ones((10, 3)), np.tile([0, 0, 1.0], (10, 1)))) == 0


def test_a_few_points_far_away_do_not_make_boxes_large():
    points = points_and_normals(1, 10_000)[0]
    far = points.copy()
    far[:10] *= 1e6
    assert Grid.around(far, 256).edge < 1.5 * Grid.around(points, 256).edge


@given(st.integers(2, 5), st.tuples(*[st.integers(1, 9)] * 3))
def test_a_parent_holds_the_boxes_of_a_cube(factor, boxes):
    grid = Grid(np.zeros(3), 1.0, boxes)
    corners = np.stack(np.meshgrid(*[np.arange(n) + 0.5 for n in boxes], indexing="ij"), -1).reshape(-1, 3)
    normals = np.tile([0, 1.0, 0], (len(corners), 1))
    parent = grid.parents(factor)[grid.cells(corners, normals)]
    cubes = np.unique(np.concatenate([corners // factor, parent[:, None]], axis=1), axis=0)
    assert len(cubes) == len(np.unique(parent)) == np.prod([-(-n // factor) for n in boxes])
    assert grid.parents(factor).shape == (np.prod(boxes) * FACES,)

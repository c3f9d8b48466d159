"""Normals are on one side of a surface, however its faces are wound, and those of a file are kept."""

import mitsuba as mi
import numpy as np
import pytest
import trimesh

from tracer.core.sphere import icosphere
from tracer.scene.mesh_files import read_parts
from tracer.scene.mesh_scene import shapes_of
from tracer.scene.normals import alike, corner_mean

POINTS, FACES = icosphere(2)
TURNED = np.random.default_rng(3).random(len(FACES)) < 0.3
"""Faces that are wound differently from the others."""
WINDINGS = {"outwards": FACES, "inwards": FACES[:, ::-1], "some": np.where(TURNED[:, None], FACES[:, ::-1], FACES)}


def written(path, faces, normals=None, transform=None):
    """Write a mesh with the points of the ball, and return its path."""
    mesh = trimesh.Trimesh(POINTS, faces, vertex_normals=normals, process=False)
    if path.suffix == ".glb":
        scene = trimesh.Scene()
        scene.add_geometry(mesh, transform=transform)
        scene.export(path, include_normals=normals is not None)
    elif path.suffix == ".off":
        mesh.export(path)
    else:
        mesh.export(path, **{{".obj": "include_normals", ".ply": "vertex_normal"}[path.suffix]: normals is not None})
    return path


def pointing(part):
    """Return how much each normal points outwards, -1 to 1."""
    return np.sum(part.normals * part.vertices / np.linalg.norm(part.vertices, axis=1, keepdims=True), axis=1)


@pytest.mark.parametrize("suffix", [".ply", ".obj", ".off", ".glb"])
@pytest.mark.parametrize("winding", WINDINGS)
def test_normals_are_on_the_side_of_most_faces(tmp_path, suffix, winding):
    (part,) = read_parts(written(tmp_path / f"ball{suffix}", WINDINGS[winding]))
    assert np.all((-1 if winding == "inwards" else 1) * pointing(part) > 0.99)


@pytest.mark.parametrize("suffix", [".ply", ".obj", ".glb"])
@pytest.mark.parametrize("winding", WINDINGS)
def test_normals_of_a_file_are_kept(tmp_path, suffix, winding):
    tilted = POINTS + np.array([0.2, 0, 0])
    tilted /= np.linalg.norm(tilted, axis=1, keepdims=True)
    for sign in (1, -1):
        (part,) = read_parts(written(tmp_path / f"ball{suffix}", WINDINGS[winding], sign * tilted))
        nearest = np.argmax(part.vertices @ POINTS.T, axis=1)
        assert part.normals == pytest.approx(sign * tilted[nearest], abs=1e-5)


@pytest.mark.parametrize("suffix", [".ply", ".obj", ".glb"])
def test_normals_of_a_file_on_either_side_are_turned_to_one(tmp_path, suffix):
    signs = np.random.default_rng(4).choice([-1, 1], len(POINTS))[:, None]
    (part,) = read_parts(written(tmp_path / f"ball{suffix}", WINDINGS["some"], signs * POINTS))
    assert np.abs(pointing(part).sum()) == pytest.approx(len(part.normals))


def test_normals_are_moved_as_their_node_is(tmp_path):
    """Those of a ball that is squeezed into an ellipsoid, and mirrored, are (x/a^2, y/b^2, z/c^2)."""
    axes = np.array([3.0, 1, -0.5])
    (part,) = read_parts(written(tmp_path / "ball.glb", FACES, POINTS, np.diag([*axes, 1])))
    expected = part.vertices / axes**2
    assert part.normals == pytest.approx(expected / np.linalg.norm(expected, axis=1, keepdims=True), abs=1e-5)


def test_a_ball_has_no_dark_faces(tmp_path):
    """In even light from all around, a white ball sends out the same everywhere."""
    (part,) = read_parts(written(tmp_path / "ball.ply", WINDINGS["some"]))
    film = {"type": "hdrfilm", "width": 12, "height": 12, "rfilter": {"type": "box"}}
    eye = mi.ScalarTransform4f().look_at([0, 0, 6], [0, 0, 0], [0, 1, 0])
    camera = {"type": "perspective", "fov": 12, "to_world": eye, "film": film}
    light = {"type": "constant", "radiance": 2.0}
    scene = mi.load_dict({"type": "scene", **shapes_of([part]), "camera": camera, "light": light})
    image = mi.render(scene, integrator=mi.load_dict({"type": "path", "max_depth": 2}), spp=512, seed=1)
    assert np.array(image)[..., 0] == pytest.approx(np.ones((12, 12)), abs=0.05)


def test_faces_are_wound_as_most_of_their_surface():
    two = np.concatenate([WINDINGS["some"], len(POINTS) + WINDINGS["inwards"]])
    assert np.array_equal(alike(two), np.concatenate([FACES, len(POINTS) + FACES[:, ::-1]]))
    assert alike(FACES) is None


def test_a_surface_with_one_side_stays_as_it_is():
    count = 8
    corners = np.arange(2 * count)
    below, above = corners[::2], corners[1::2]
    next_below, next_above = np.append(below[1:], above[0]), np.append(above[1:], below[0])
    strip = np.concatenate([np.stack([below, next_below, above], 1), np.stack([above, next_below, next_above], 1)])
    assert np.array_equal(alike(strip), strip)


def test_a_face_without_area_does_not_count():
    vertices = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0.5, 0, 0]])
    faces = np.array([[0, 1, 2], [0, 3, 1], [2, 2, 1]])
    assert corner_mean(vertices, faces)[:3] == pytest.approx(np.outer([np.pi / 2, np.pi / 4, np.pi / 4], [0, 0, 1]))

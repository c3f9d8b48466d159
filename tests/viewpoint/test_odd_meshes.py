"""Meshes large, far away, inside out, with holes, of degenerate faces: as the same mesh without, or one sentence."""

import numpy as np
import pytest
import trimesh

from tracer.errors import SceneError
from tracer.viewpoint.direction_measure import stand
from tracer.viewpoint.item_buffer import Rays, projected_areas
from tracer.viewpoint.source import open_source
from tracer.viewpoint.survey import survey

CORNERS = np.array([[k & 1, k >> 1 & 1, k >> 2] for k in range(8)], float)
QUADS = {"x0": [0, 4, 6, 2], "x1": [1, 3, 7, 5], "y0": [0, 1, 5, 4], "y1": [2, 6, 7, 3], "z0": [0, 2, 3, 1]}
FACES = np.array([[a, *pair] for a, b, c, d in QUADS.values() for pair in ((b, c), (c, d))])
"""A box without a lid, wound outwards, with two faces to each side; the last two are the floor."""
SUFFIXES = (".ply", ".obj", ".off", ".stl", ".glb")
DIRECTIONS = np.array([[0.0, 0, 1], [0, 0, -1], [1, 0, 0], [0.5, 0.3, 0.8], [-0.4, 0.7, -0.6]])
RAYS = Rays(side=128)  # rays along an edge of two faces may meet either


def seen(path):
    """Return areas (V, Z) of the faces of a mesh file as shares of what each view sees, and entropies (V,)."""
    subject = open_source(path).subject
    place = stand(subject, orthographic=True)
    views = place.viewpoints(DIRECTIONS / np.linalg.norm(DIRECTIONS, axis=1, keepdims=True))
    areas = np.concatenate([batch.areas for batch in projected_areas(subject, views, place.lens, RAYS)])
    return areas / areas.sum(axis=1, keepdims=True), survey(subject, views, place.lens, RAYS, ["entropy"])["entropy"]


def written(path, vertices, faces):
    mesh = trimesh.Trimesh(vertices, faces, process=False)
    mesh.export(path, **({"digits": 12} if path.suffix in (".off", ".obj") else {}))
    return path


@pytest.fixture(scope="module")
def right(tmp_path_factory):
    return seen(written(tmp_path_factory.mktemp("right") / "box.ply", CORNERS, FACES))


def test_one_looks_through_a_hole_at_the_inner_side(right):
    shares, _ = right
    assert shares[0] == pytest.approx([0] * 8 + [0.5, 0.5], abs=0.02)  # from above: the floor
    assert shares[1] == pytest.approx([0] * 8 + [0.5, 0.5], abs=0.02)
    assert shares[2] == pytest.approx([0, 0, 0.5, 0.5] + [0] * 6, abs=0.02)
    x, y, z = DIRECTIONS[3]  # from a corner above: two sides from outside, the inner sides of two others, the floor
    deep = max(0, 1 - x / z) * max(0, 1 - y / z)  # how much of the floor the near sides do not hide
    assert shares[3][-2:].sum() == pytest.approx(deep * z / (x + y + z), abs=0.02)


@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.parametrize("kind", ["inside out", "partly inside out", "large", "small"])
def test_they_look_the_same(kind, suffix, right, tmp_path):
    scale = {"large": 1e6, "small": 1e-6}.get(kind, 1.0)
    turned = {"inside out": np.ones(10, bool), "partly inside out": np.arange(10) % 3 == 1}.get(
        kind, np.zeros(10, bool)
    )
    faces = np.where(turned[:, None], FACES[:, ::-1], FACES)
    shares, entropies = seen(written(tmp_path / f"box{suffix}", scale * CORNERS, faces))
    assert shares == pytest.approx(right[0], abs=0.01)
    assert entropies == pytest.approx(right[1], abs=0.01)


@pytest.mark.parametrize("suffix", [".ply", ".obj", ".off"])
def test_far_away_and_in_double_precision_they_look_the_same(suffix, right, tmp_path):
    path = tmp_path / f"box{suffix}"
    if suffix == ".ply":
        rows = [*(CORNERS + 1e7).tolist(), *([3, *face] for face in FACES.tolist())]
        header = "ply\nformat ascii 1.0\nelement vertex 8\nproperty double x\nproperty double y\nproperty double z\n"
        header += "element face 10\nproperty list uchar int vertex_indices\nend_header\n"
        path.write_text(header + "\n".join(" ".join(map(str, row)) for row in rows) + "\n")
    else:
        written(path, CORNERS + 1e7, FACES)
    assert seen(path)[0] == pytest.approx(right[0], abs=0.01)


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_faces_without_area_are_not_seen(suffix, right, tmp_path):
    degenerate = [[0, 0, 7], [3, 3, 3], [8, 0, 7]]  # two corners in one place, three, and three on a line
    vertices = np.concatenate([CORNERS, CORNERS[[0, 7]].mean(axis=0, keepdims=True)])
    path = written(tmp_path / f"box{suffix}", vertices, np.concatenate([FACES, degenerate]))
    shares, entropies = seen(path)
    assert shares[:, :10] == pytest.approx(right[0], abs=0.01)
    assert not shares[:, 10:].any()
    assert entropies == pytest.approx(right[1], abs=0.01)


def test_what_single_precision_cannot_hold_is_one_sentence(tmp_path):
    with pytest.raises(SceneError, match="has a radius of") as caught:
        open_source(written(tmp_path / "box.off", 1e12 * CORNERS, FACES))
    assert "\n" not in str(caught.value)

"""Meshes in all formats: the same triangles, parts and colours, or one sentence."""

import struct

import numpy as np
import pytest
import trimesh
from trimesh.visual.material import PBRMaterial, SimpleMaterial

from tracer.errors import SceneError
from tracer.scene.mesh_files import SUFFIXES, read_parts
from tracer.scene.parts import own_names, recentred

CORNERS = np.array([[0.0, 0, 0], [2, 0, 0], [0, 3, 0], [0, 0, 4]])
FACES = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])


def triangles_of(parts):
    """Return all triangles (F, 3, 3), sorted, each with its first corner first."""
    corners = np.concatenate([part.vertices[part.faces] for part in parts])
    turned = [np.roll(triangle, -min(range(3), key=lambda k: tuple(triangle[k])), axis=0) for triangle in corners]
    return np.array(sorted(turned, key=lambda triangle: triangle.ravel().tolist()))


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_every_format_has_the_same_triangles(tmp_path, suffix):
    mesh = trimesh.Trimesh(CORNERS, FACES, process=False)
    path = tmp_path / f"mesh{suffix}"
    (trimesh.Scene([mesh]) if suffix in (".3mf", ".glb", ".gltf") else mesh).export(path)
    if suffix == ".gltf":
        assert len(list(tmp_path.iterdir())) > 1  # numbers are in files of their own
    parts = read_parts(path)
    assert len(parts) == 1
    assert np.allclose(triangles_of(parts), triangles_of([type("Part", (), {"vertices": CORNERS, "faces": FACES})]))
    if suffix == ".stl":  # its triangles look flat, and share vertices
        assert parts[0].normals is None
        assert len(parts[0].vertices) == 4
    else:
        assert np.allclose(np.linalg.norm(parts[0].normals, axis=1), 1)
    if suffix in (".ply", ".off"):
        assert np.allclose(parts[0].normals, mesh.vertex_normals)


def test_nodes_of_gltf_are_parts_where_they_stand(tmp_path):
    scene = trimesh.Scene()
    red = PBRMaterial(name="red", baseColorFactor=[255, 0, 0, 255], metallicFactor=0.0, roughnessFactor=0.4)
    ball = trimesh.creation.icosphere(subdivisions=1)
    ball.visual = trimesh.visual.TextureVisuals(material=red)
    for number in range(3):
        moved = trimesh.transformations.translation_matrix([5 * number, 0, 0])
        scene.add_geometry(ball, node_name=f"ball{number}", transform=moved)
    scene.export(tmp_path / "balls.glb")
    parts = read_parts(tmp_path / "balls.glb")
    assert len({part.name for part in parts}) == 3
    assert sorted(round(part.vertices[:, 0].mean(), 6) for part in parts) == [0, 5, 10]
    assert all(part.material.colour == (1.0, 0.0, 0.0) for part in parts)
    assert all(part.material.roughness == pytest.approx(0.4) for part in parts)


GROUPS = """mtllib colours.mtl
v 0 0 0
v 1 0 0
v 0 1 0
v 0 0 1
g left
usemtl green
f 1 2 3
g right
usemtl blue
f 1 2 4
f 2 3 4
"""


def test_metal_is_as_gltf_has_it(tmp_path):
    """Left out, a material is metal; a picture has it in blue, and roughness in green."""
    from PIL import Image

    box = trimesh.creation.box()
    picture = Image.fromarray(np.full((2, 2, 3), (0, 51, 102), np.uint8))
    for number, (material, expected) in enumerate(
        [
            (PBRMaterial(baseColorFactor=[255, 255, 0, 255]), (1.0, 1.0)),
            (PBRMaterial(metallicFactor=0.0, roughnessFactor=0.5), (0.0, 0.5)),
            (PBRMaterial(metallicRoughnessTexture=picture), (0.4, 0.2)),
        ]
    ):
        box.visual = trimesh.visual.TextureVisuals(uv=np.zeros((8, 2)), material=material)
        box.export(tmp_path / f"{number}.glb")
        (part,) = read_parts(tmp_path / f"{number}.glb")
        assert (part.material.metallic, part.material.roughness) == pytest.approx(expected, abs=0.01)


def test_groups_of_obj_are_parts_with_their_materials(tmp_path):
    (tmp_path / "mesh.obj").write_text(GROUPS)
    (tmp_path / "colours.mtl").write_text("newmtl green\nKd 0 0.5 0\nnewmtl blue\nKd 0 0 1\n")
    parts = read_parts(tmp_path / "mesh.obj")
    assert sorted(len(part.faces) for part in parts) == [1, 2]
    assert sorted(part.material.colour for part in parts) == [(0, 0, 1), pytest.approx((0, 0.5, 0), abs=0.01)]
    (tmp_path / "colours.mtl").unlink()
    assert sum(len(part.faces) for part in read_parts(tmp_path / "mesh.obj")) == 3


def test_polygons_and_negative_numbers_of_obj(tmp_path):
    (tmp_path / "mesh.obj").write_text("v 0 0 0\nv 2 0 0\nv 2 1 0\nv 0 1 0\nf -4 -3 -2 -1\n")
    (part,) = read_parts(tmp_path / "mesh.obj")
    a, b, c = part.vertices[part.faces].transpose(1, 0, 2)
    assert 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() == pytest.approx(2)


@pytest.mark.parametrize("order", ["little", "big"])
def test_ply_may_have_triangles_quads_and_more_in_one_file(tmp_path, order):
    """A cube of three quads, two pairs of triangles and a side with five corners."""
    sides = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5], [0, 5, 1], [2, 3, 7], [2, 7, 6], [0, 2, 6, 4, 8], [1, 5, 7, 3]]
    corners = np.array([[k & 1, k >> 1 & 1, k >> 2] for k in range(8)] + [[0, 0, 0.5]], float)
    sign = {"little": "<", "big": ">"}[order]
    header = f"ply\nformat binary_{order}_endian 1.0\nelement vertex 9\nproperty uchar red\n"
    header += "property double x\nproperty double y\nproperty double z\nelement face 8\n"
    header += "property list uchar uint vertex_indices\nproperty short flags\nend_header\n"
    data = b"".join(struct.pack(f"{sign}B3d", 200, *corner) for corner in corners)
    data += b"".join(struct.pack(f"{sign}B{len(side)}Ih", len(side), *side, 7) for side in sides)
    (tmp_path / "cube.ply").write_bytes(header.encode() + data)
    (part,) = read_parts(tmp_path / "cube.ply")
    assert len(part.faces) == 2 + 2 + 1 + 1 + 1 + 1 + 3 + 2
    a, b, c = part.vertices[part.faces].transpose(1, 0, 2)
    assert 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() == pytest.approx(6)
    assert abs(np.sum(a * np.cross(b, c)) / 6) == pytest.approx(1)  # the volume, as all look outwards
    (tmp_path / "cube.ply").write_bytes(header.encode() + data[:-4])
    with pytest.raises(SceneError, match=r"cube\.ply' "):
        read_parts(tmp_path / "cube.ply")


def test_ply_may_have_any_properties(tmp_path):
    header = "ply\nformat ascii 1.0\nelement vertex 3\nproperty double x\nproperty double y\nproperty double z\n"
    header += "property uchar red\nproperty uchar green\nproperty uchar blue\nproperty float quality\n"
    header += "element face 1\nproperty list uchar int vertex_indices\nproperty int flags\nend_header\n"
    (tmp_path / "mesh.ply").write_text(header + "0 0 0 255 0 0 0.5\n1 0 0 255 0 0 0.5\n0 1 0 255 0 0 0.5\n3 0 1 2 7\n")
    (part,) = read_parts(tmp_path / "mesh.ply")
    assert part.vertices[part.faces].shape == (1, 3, 3)
    assert part.material.colour == pytest.approx((1.0, 0.0, 0.0))


def test_a_picture_is_the_texture(tmp_path):
    from PIL import Image

    picture = Image.fromarray(np.array([[[255, 0, 0], [0, 255, 0]], [[0, 0, 255], [255, 255, 255]]], np.uint8))
    square = trimesh.Trimesh([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]], process=False)
    places = [[0, 0], [1, 0], [1, 1], [0, 1]]
    for suffix, material in ((".glb", PBRMaterial(baseColorTexture=picture)), (".obj", SimpleMaterial(image=picture))):
        square.visual = trimesh.visual.TextureVisuals(uv=places, material=material)
        square.export(tmp_path / f"square{suffix}")
        (part,) = read_parts(tmp_path / f"square{suffix}")
        assert part.material.texture.shape == (2, 2, 3)
        assert part.material.texture[0, 0] == pytest.approx([1, 0, 0], abs=0.02)
        corner = np.argmin(np.abs(part.vertices - [0, 1, 0]).sum(axis=1))
        assert part.places[corner] == pytest.approx([0, 1])


WRONG = {
    "empty.ply": (b"", "is empty; export it anew"),
    "points.ply": (
        b"ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\nend_header\n"
        b"0 0 0\n1 1 1\n",
        "holds 2 points and no faces; make a surface",
    ),
    "points.obj": (b"v 0 0 0\nv 1 0 0\n", "has no face"),
    "nan.off": (b"OFF\n3 1 0\n0 0 nan\n1 0 0\n0 1 0\n3 0 1 2\n", "no numbers"),
    "beyond.off": (b"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 7\n", "outside the range"),
    "text.stl": (b"this is no mesh", "mesh.stl|text.stl"),
    "broken.glb": (b"glTF\x02\x00\x00\x00", "does not load as a mesh"),
}


@pytest.mark.parametrize("name", WRONG)
def test_what_is_no_surface_is_one_sentence(tmp_path, name):
    content, message = WRONG[name]
    (tmp_path / name).write_bytes(content)
    with pytest.raises(SceneError, match=message) as caught:
        read_parts(tmp_path / name)
    assert "\n" not in str(caught.value)
    with pytest.raises(SceneError, match="There is no mesh"):
        read_parts(tmp_path / "none.stl")


def test_normals_are_there_even_for_faces_without_area(tmp_path):
    (tmp_path / "mesh.off").write_text("OFF\n4 2 0\n0 0 0\n1 0 0\n0 1 0\n5 5 5\n3 0 1 2\n3 3 3 3\n")
    (part,) = read_parts(tmp_path / "mesh.off")
    assert np.allclose(np.linalg.norm(part.normals, axis=1), 1)
    assert np.allclose(np.abs(part.normals[:3]), [0, 0, 1])


def test_what_is_far_away_is_brought_near(tmp_path):
    trimesh.Trimesh(CORNERS + 1e7, FACES, process=False).export(tmp_path / "far.off", digits=9)
    parts, origin = recentred(read_parts(tmp_path / "far.off"))
    assert origin == pytest.approx(1e7 + np.array([1, 1.5, 2]))
    assert np.abs(parts[0].vertices).max() < 3
    near = read_parts(tmp_path / "far.off")
    assert recentred([near[0], parts[0]])[1] == pytest.approx(np.zeros(3))


def test_names_differ():
    parts = [type("Part", (), {"name": name}) for name in ("a", "b", "a", "a")]
    assert own_names(parts) == ["a", "b", "a 2", "a 3"]

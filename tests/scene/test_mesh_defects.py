"""Mesh files that Mitsuba does not load: what is wrong with them and what to do."""

import re
import struct

import mitsuba as mi
import pytest

from tracer.errors import SceneError
from tracer.scene.load import load
from tracer.scene.mesh_defects import mesh_defect
from tracer.viewpoint.source import open_source

POINTS = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
TRIANGLES = [(0, 1, 2), (0, 2, 3)]
VERTICES = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"


def ply(faces, form="ascii", points=POINTS, count=None, names="xyz", element="face"):
    """Return a PLY file whose faces have a colour before and after their corners."""
    count = len(faces) if count is None else count
    header = f"ply\nformat {form} 1.0\ncomment made up\nelement vertex {len(points)}\n"
    header += "".join(f"property float {name}\n" for name in names)
    if faces or count:
        header += f"element {element} {count}\nproperty uchar red\nproperty list uchar int vertex_indices\n"
        header += "property float blue\n"
    header = (header + "end_header\n").encode()
    if form == "ascii":
        lines = [" ".join(map(str, point[: len(names)])) for point in points]
        lines += [" ".join(map(str, (255, len(face), *face, 0.25))) for face in faces]
        return header + ("\n".join(lines) + "\n").encode()
    order = "<" if "little" in form else ">"
    data = b"".join(struct.pack(f"{order}3f", *point) for point in points)
    for face in faces:
        data += struct.pack(f"{order}BB{len(face)}i", 255, len(face), *face) + struct.pack(f"{order}f", 0.25)
    return header + data


FORMATS = ["ascii", "binary_little_endian", "binary_big_endian"]
POLYGONS = "has a face of {} corners, and of PLY files Mitsuba reads only triangles; triangulate the mesh when you"
CLOUD = "holds 4 points and no faces; make a surface of them, or place a small sphere at each"
BACKWARDS = (
    "has faces that count their corners backwards (negative indices, as {}), which Mitsuba does not read; export"
)
CASES = {
    "quad.ply": (ply([(0, 1, 2, 3)]), POLYGONS.format(4)),
    "later.ply": (ply([*TRIANGLES, (0, 1, 2, 3)]), POLYGONS.format(4)),
    "five.ply": (ply([(0, 1, 2, 3, 0)], "binary_little_endian"), POLYGONS.format(5)),
    "big.ply": (ply([(0, 1, 2), (0, 1, 2, 3)], "binary_big_endian"), POLYGONS.format(4)),
    "cloud.ply": (ply([]), CLOUD),
    "bytes.ply": (ply([], "binary_little_endian"), CLOUD),
    "none.ply": (ply([], count=0) + b"", CLOUD),
    "cut.ply": (ply(TRIANGLES, count=3), "ends before its 3 faces do; export it anew"),
    "short.ply": (ply(TRIANGLES, "binary_little_endian")[:-3], "ends before its 2 faces do; export it anew"),
    "flat.ply": (ply(TRIANGLES, names="xy"), "has vertices without z; export it anew"),
    "strips.ply": (ply([(0, 1, 2, 3)], element="tristrips"), "has strips of triangles, which Mitsuba does not read"),
    "lists.ply": (
        ply(TRIANGLES).replace(b"property float blue", b"property list uchar float texcoord"),
        "has faces with more than one list (vertex_indices and texcoord); export it with the corners alone",
    ),
    "empty.ply": (b"", "is empty; export it anew"),
    "text.ply": (b"v 0 0 0\n", "is no PLY file; name the plugin of its format"),
    "broken.ply": (b"ply\nformat ascii 1.0\n", "has no whole PLY header; export it anew"),
    "relative.obj": (VERTICES + "f -4 -3 -2\n", BACKWARDS.format("-4")),
    "places.obj": (VERTICES + "vt 0 0\nvt 1 1\nf 1/1 2/2 3/-1\n", BACKWARDS.format("-1")),
    "zero.obj": (VERTICES + "f 0 1 2\n", "has a face with vertex 0, and 4 of them, counted from 1; export it anew"),
    "beyond.obj": (VERTICES + "f 1 2 9\n", "has a face with vertex 9, and 4 of them, counted from 1; export it anew"),
    "normals.obj": (VERTICES + "vn 0 0 1\nf 1//1 2//1 3//2\n", "has a face with normal 2, and 1 of them, counted from"),
    "points.obj": (VERTICES + "p 1 2 3\n", "has no face of three corners or more, only points or lines; export it"),
    "two.obj": (VERTICES + "f 1 2\n", "has no face of three corners or more, only points or lines; export it anew"),
    "goes_on.obj": (VERTICES + "f 1 2 \\\n3\n", "has faces that go on in the next line, which Mitsuba does not read"),
    "ply.obj": (ply(TRIANGLES), "is a PLY file; name the plugin 'ply' instead of 'obj'"),
    "empty.obj": (b"", "is empty; export it anew"),
}
READ_ALONE = {
    "quad.ply": 2,
    "lists.ply": 2,
    "later.ply": 4,
    "five.ply": 3,
    "big.ply": 3,
    "relative.obj": 1,
    "places.obj": 1,
    "normals.obj": 1,
    "goes_on.obj": 1,
}
"""Number of triangles in files that are read where they are named alone, though Mitsuba does not read them."""


@pytest.fixture(params=CASES)
def case(request, tmp_path):
    data, defect = CASES[request.param]
    (tmp_path / request.param).write_bytes(data.encode() if isinstance(data, str) else data)
    return tmp_path / request.param, defect


def test_a_mesh_that_does_not_load_is_one_sentence(case, scene_file):
    mesh, defect = case
    scene = scene_file(f'<shape type="{mesh.suffix[1:]}"><string name="filename" value="{mesh.name}"/></shape>')
    for source, name in (
        (scene, mesh.name),
        ({"type": "scene", "mesh": {"type": mesh.suffix[1:], "filename": str(mesh)}}, str(mesh)),
    ):
        with pytest.raises(SceneError) as caught:
            load(source)
        described = f"'{source}'" if source is scene else "the scene"
        assert str(caught.value).startswith(f"{described} does not load: '{name}' {defect}")
        assert str(caught.value).count("\n") == 0
    if mesh.name in READ_ALONE:
        assert open_source(mesh).subject.count == READ_ALONE[mesh.name]
        return
    with pytest.raises(SceneError, match=re.escape(f"'{mesh}' {defect}")):
        open_source(mesh)


@pytest.mark.parametrize("form", FORMATS)
def test_nothing_is_wrong_with_triangles(tmp_path, form):
    path = tmp_path / "mesh.ply"
    path.write_bytes(ply(TRIANGLES, form))
    assert mesh_defect(path, "ply") is None
    assert mi.load_dict({"type": "ply", "filename": str(path)}).face_count() == 2


def test_nothing_is_wrong_with_polygons_of_an_obj(tmp_path):
    path = tmp_path / "mesh.obj"
    path.write_text(VERTICES + "vt 0 0\nf 1/1 2/1 3/1 4/1\n")
    assert mesh_defect(path, "obj") is None
    assert mi.load_dict({"type": "obj", "filename": str(path)}).face_count() == 2


def test_what_it_cannot_tell_is_left_to_mitsuba(tmp_path, scene_file):
    for content in (
        b"ply\nformat ascii 1.0\nelement vertex x\nend_header\n",
        ply(TRIANGLES).replace(b"255 3", b"255 x"),
    ):
        (tmp_path / "odd.ply").write_bytes(content)
        assert mesh_defect(tmp_path / "odd.ply", "ply") is None
    shape = '<shape type="ply"><string name="filename" value="{}"/></shape>'
    for name, message in (("odd.ply", "PLYMesh"), ("missing.ply", "missing.ply")):
        with pytest.raises(SceneError, match=message):
            load(scene_file(shape.format(name)))
    assert mesh_defect(tmp_path / "missing.ply", "ply") is None
    assert mesh_defect(tmp_path / "odd.ply", "serialized") is None


def test_of_several_meshes_the_defective_one_is_named(tmp_path, scene_file):
    (tmp_path / "good.ply").write_bytes(ply(TRIANGLES))
    (tmp_path / "bad.ply").write_bytes(ply([(0, 1, 2, 3)]))
    shape = '<shape type="ply"><string name="filename" value="{}"/></shape>'
    with pytest.raises(SceneError, match=r"does not load: 'bad\.ply' has a face of 4 corners"):
        load(scene_file(shape.format("good.ply") + shape.format("bad.ply")))


def test_a_mesh_alone_is_checked_for_faces_without_vertices(tmp_path):
    (tmp_path / "mesh.ply").write_bytes(ply([(0, 1, 7)]))
    with pytest.raises(SceneError, match=r"index|vertex 7"):
        open_source(tmp_path / "mesh.ply")

"""A scene arrives whole, where its files find one another, and nothing leaves the folder it is for."""

import io
import zipfile
from dataclasses import replace

import mitsuba as mi
import numpy as np
import pytest

import tracer
from conftest import LIT
from tracer.cluster import remote_drawer
from tracer.cluster.bundle import contents_of, pack, unpack
from tracer.cluster.connection import Connection
from tracer.errors import ClusterError
from tracer.scene.fingerprint import fingerprint
from tracer.scene.load import load

PLY = """ply
format ascii 1.0
element vertex 3
property float x
property float y
property float z
element face 1
property list uchar int vertex_index
end_header
0 0 0
1 0 0
0 1 0
3 0 1 2
"""


@pytest.fixture
def scene(tmp_path):
    """Return a scene that names a mesh, a texture, a spectrum and another scene file, in several ways."""
    (tmp_path / "project" / "sub").mkdir(parents=True)
    (tmp_path / "meshes").mkdir()
    (tmp_path / "meshes" / "face.ply").write_text(PLY)
    (tmp_path / "project" / "gold.spd").write_text("400 0.2\n700 0.9\n")
    (tmp_path / "project" / "more.xml").write_text(
        '<scene version="3.0.0"><shape type="sphere"><bsdf type="diffuse"><texture type="bitmap" name="reflectance">'
        '<string name="filename" value="sub/$name.png"/></texture></bsdf></shape></scene>'
    )
    from tracer.io.exr import write_png

    write_png(tmp_path / "project" / "sub" / "wood.png", np.full((4, 4, 3), 0.5))
    path = tmp_path / "project" / "scene.xml"
    path.write_text(
        f'<scene version="3.0.0"><default name="name" value="wood"/>{LIT}<include filename="more.xml"/>'
        '<shape type="ply"><string name="filename" value="../meshes/face.ply"/>'
        "<bsdf type='diffuse'><spectrum name='reflectance' filename='gold.spd'/></bsdf></shape></scene>"
    )
    return path


@pytest.fixture
def scattered(tmp_path):
    """Return a scene whose mesh is in a folder that <path> names; another such folder is empty."""
    for folder in ("shots", "common", "empty"):
        (tmp_path / folder).mkdir()
    (tmp_path / "common" / "face.ply").write_text(PLY)
    path = tmp_path / "shots" / "scene.xml"
    path.write_text(
        f'<scene version="3.0.0"><path value="../common"/><path value="../empty"/>{LIT}'
        '<shape type="ply"><string name="filename" value="face.ply"/></shape></scene>'
    )
    return path


def test_folders_that_path_names_arrive_with_what_is_in_them(scattered, tmp_path):
    unpack(pack(scattered, {}), tmp_path / "there")
    (found,) = (tmp_path / "there").glob("**/scene.xml")
    (scattered.parent.parent / "common" / "face.ply").unlink()
    assert len(load(found).shapes()) == 1


def test_files_of_the_current_folder_are_refused(scattered):
    text = scattered.read_text().replace('<path value="../common"/>', "")
    scattered.write_text(text)
    before = mi.file_resolver()
    here = mi.FileResolver(before)
    here.append(str(scattered.parent.parent / "common"))
    mi.set_file_resolver(here)
    try:
        with pytest.raises(ClusterError, match=r"'face.ply', which is in the current folder and not beside"):
            pack(scattered, {})
    finally:
        mi.set_file_resolver(before)


def test_all_files_are_found(scene):
    names = {path.name for path in contents_of(scene, {"name": "wood"})[0]}
    assert names == {"scene.xml", "more.xml", "face.ply", "gold.spd", "wood.png"}


def test_what_is_unpacked_is_the_same_scene(scene, tmp_path):
    define = {"name": "wood"}
    archive = pack(scene, define)
    unpack(archive, tmp_path / "there")
    (found,) = (tmp_path / "there").glob("**/scene.xml")
    assert fingerprint(found, define) == fingerprint(scene, define)
    unpack(b"not read again", tmp_path / "there")


def test_absolute_paths_are_refused(scene, tmp_path):
    scene.write_text(scene.read_text().replace("../meshes", str(tmp_path / "meshes")))
    with pytest.raises(ClusterError, match="a path that workers do not have"):
        pack(scene, {"name": "wood"})


@pytest.mark.parametrize("name", ["../out.txt", "/etc/out.txt", "a/../../out.txt", "../out.txt/"])
def test_names_that_lead_out_are_refused(tmp_path, name):
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        archive.writestr(name, "" if name.endswith("/") else "x")
    with pytest.raises(ClusterError, match="does not belong"):
        unpack(stream.getvalue(), tmp_path / "deep" / "there")
    assert not list(tmp_path.rglob("out.txt"))


@pytest.mark.parametrize("name", ["scene", "scattered"])
def test_workers_without_the_scene_get_it(name, request, two_workers, monkeypatch):
    scene = request.getfixturevalue(name)
    make = remote_drawer.make_setup
    sent = []

    def elsewhere(*arguments, **seen):
        setup = make(*arguments, **seen)
        sent.append(setup)
        return replace(setup, scene="/nowhere/scene.xml")

    ship = Connection.ship
    monkeypatch.setattr(remote_drawer, "make_setup", elsewhere)
    monkeypatch.setattr(Connection, "ship", lambda self, setup: ship(self, sent[0]))
    define = {"name": "wood"} if name == "scene" else {}
    found = tracer.render(scene, spp=8, define=define, cluster=two_workers)
    assert np.array_equal(found.image, tracer.render(scene, spp=8, define=define).image)


def test_files_that_an_included_scene_names_are_beside_it(tmp_path):
    (tmp_path / "sub").mkdir()
    (tmp_path / "sub" / "face.ply").write_text(PLY)
    shape = '<shape type="ply"><string name="filename" value="face.ply"/></shape>'
    (tmp_path / "sub" / "more.xml").write_text(f'<scene version="3.0.0">{shape}</scene>')
    path = tmp_path / "scene.xml"
    path.write_text(f'<scene version="3.0.0">{LIT}<include filename="sub/more.xml"/></scene>')
    assert tmp_path / "sub" / "face.ply" in contents_of(path, {})[0]


def test_a_link_arrives_by_the_name_that_the_scene_has_for_it(tmp_path):
    (tmp_path / "project").mkdir()
    (tmp_path / "face.ply").write_text(PLY)
    (tmp_path / "project" / "link.ply").symlink_to(tmp_path / "face.ply")
    path = tmp_path / "project" / "scene.xml"
    shape = '<shape type="ply"><string name="filename" value="link.ply"/></shape>'
    path.write_text(f'<scene version="3.0.0">{LIT}{shape}</scene>')
    unpack(pack(path, {}), tmp_path / "there")
    assert (tmp_path / "there" / "link.ply").read_text() == PLY


def test_files_that_a_default_names_and_text_that_is_none(tmp_path):
    (tmp_path / "metal.spd").write_text("400 0.2\n700 0.9\n")
    matrix = " ".join(f"{value:.17f}" for value in np.eye(4).ravel())
    path = tmp_path / "scene.xml"
    path.write_text(
        f'<scene version="3.0.0"><default name="m" value="metal"/><default name="mat" value="metal"/>{LIT}'
        f'<shape type="sphere"><transform name="to_world"><matrix value="{matrix}"/></transform>'
        '<bsdf type="diffuse"><spectrum name="reflectance" filename="$mat.spd"/></bsdf></shape></scene>'
    )
    assert len(matrix) > 255
    assert tmp_path / "metal.spd" in contents_of(path, {})[0]

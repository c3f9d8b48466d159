"""Files of patches hold what was solved, as other people's programs read them."""

import json
import sys

import meshio
import mitsuba as mi
import numpy as np
import pytest
import trimesh

from tracer.errors import MissingPackageError, WriteError
from tracer.radiosity.export import check_export, colours_of, write_patches
from tracer.radiosity.gathering import solve
from tracer.radiosity.meshing import cut
from tracer.radiosity.photometry import illuminance

T = mi.ScalarTransform4f


@pytest.fixture(scope="module")
def solved():
    """A ball over a sheet that is lit from both sides."""
    clay, paper = ({"type": "ref", "id": name} for name in ("clay", "paper"))
    lamp = {"type": "area", "radiance": {"type": "rgb", "value": [9.0, 8.0, 5.0]}}
    scene = {
        "type": "scene",
        "clay": {"type": "diffuse", "reflectance": {"type": "rgb", "value": [0.7, 0.3, 0.2]}},
        "paper": {"type": "twosided", "both": {"type": "diffuse"}},
        "sky": {"type": "constant", "radiance": 0.2},
        "sheet": {"type": "rectangle", "bsdf": paper, "to_world": T().scale(2)},
        "ball": {"type": "sphere", "center": [0.5, 0, 1], "radius": 0.4, "bsdf": clay},
        "lamp": {
            "type": "rectangle",
            "to_world": T().translate([0, 0, 3]).rotate([1, 0, 0], 180),
            "bsdf": clay,
            "emitter": lamp,
        },
    }
    patches = cut(mi.load_dict(scene), 0.4)
    solution = solve(patches, 32)
    return patches, solution, illuminance(solution.irradiance)


def write(path, solved):
    patches, solution, lux = solved
    write_patches(path, patches, solution.radiosity, solution.irradiance, lux)
    return path


def test_vtu_there_and_back(tmp_path, solved):
    patches, solution, lux = solved
    mesh = meshio.read(write(tmp_path / "patches.vtu", solved))
    triangles = mesh.cells_dict["triangle"]
    columns = {name: column for name, (column,) in mesh.cell_data.items()}
    assert np.array_equal(columns["radiosity"], solution.radiosity)
    assert np.array_equal(columns["irradiance"], solution.irradiance)
    assert np.array_equal(columns["illuminance"], lux)
    assert np.array_equal(columns["emitted"], patches.emitted)
    assert np.array_equal(columns["albedo"], patches.albedo)
    corners = mesh.points[triangles]
    assert corners.mean(axis=1) == pytest.approx(patches.centres, abs=1e-5)
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert np.linalg.norm(across, axis=1) / 2 == pytest.approx(columns["area"], rel=1e-3)
    normals = across / np.linalg.norm(across, axis=1, keepdims=True)
    assert np.sum(normals * patches.normals, axis=1) == pytest.approx(np.ones(len(patches)), abs=1e-4)
    # Patches of a shape share corners, of which a net of triangles has about half as many as triangles.
    assert len(mesh.points) < 0.75 * len(patches)
    numbers = {name: int(number[0]) for name, number in mesh.field_data.items()}
    assert {"shape sheet", "shape ball", "shape lamp", "material paper", "material clay"} == set(numbers)
    is_lamp = columns["shape"] == numbers["shape lamp"]
    assert np.array_equal(is_lamp, patches.emitted.max(axis=1) > 0)
    is_clay = columns["material"] == numbers["material clay"]
    assert np.array_equal(is_clay, np.isclose(patches.albedo, [0.7, 0.3, 0.2], atol=1e-5).all(axis=1))


def test_glb_there_and_back(tmp_path, solved):
    patches, solution, lux = solved
    scene = trimesh.load_scene(write(tmp_path / "patches.glb", solved), process=False)
    assert set(scene.geometry) == {"sheet", "sheet, back", "ball", "lamp"}
    assert sum(len(mesh.faces) for mesh in scene.geometry.values()) == len(patches)
    lamp = scene.geometry["lamp"]
    chosen = patches.emitted.max(axis=1) > 0
    for name, values in (("_RADIOSITY", solution.radiosity), ("_IRRADIANCE", solution.irradiance)):
        found = lamp.vertex_attributes[name]
        assert found == pytest.approx(np.repeat(values[chosen], 3, axis=0), rel=1e-6)
    assert lamp.vertex_attributes["_ILLUMINANCE"].ravel() == pytest.approx(np.repeat(lux[chosen], 3), rel=1e-6)
    assert lamp.triangles.mean(axis=1) == pytest.approx(patches.centres[chosen], abs=1e-5)
    for name, normal in (("sheet", 1), ("sheet, back", -1), ("lamp", -1)):
        assert scene.geometry[name].face_normals[:, 2] == pytest.approx(normal, abs=1e-4)


def test_colours_of_glb_are_linear_light_and_unlit(tmp_path, solved):
    patches, solution, _ = solved
    path = write(tmp_path / "patches.glb", solved)
    content = path.read_bytes()
    tree = json.loads(content[20 : 20 + int.from_bytes(content[12:16], "little")])  # the reader keeps no extensions
    assert tree["materials"][0]["extensions"] == {"KHR_materials_unlit": {}}
    assert "KHR_materials_unlit" in tree["extensionsUsed"]
    assert all("COLOR_0" in primitive["attributes"] for mesh in tree["meshes"] for primitive in mesh["primitives"])
    assert all(primitive["material"] == 0 for mesh in tree["meshes"] for primitive in mesh["primitives"])
    # Twice as much light is twice as large a number, as the colours of corners are linear in glTF.
    colours = colours_of(patches, solution.radiosity)[:, :3].astype(float)
    assert np.polyfit(solution.radiosity[colours < 255], colours[colours < 255], 1)[1] == pytest.approx(0, abs=0.5)


def test_a_missing_package_is_one_sentence(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "meshio", None)
    with pytest.raises(MissingPackageError, match="writing it needs meshio; install it"):
        check_export(tmp_path / "patches.vtu")
    check_export(tmp_path / "patches.glb")


def test_a_file_that_cannot_be_written_leaves_nothing(tmp_path, solved):
    with pytest.raises(WriteError, match="Cannot write"):
        write(tmp_path / "nowhere" / "patches.glb", solved)
    assert list(tmp_path.iterdir()) == []

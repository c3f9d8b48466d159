"""Surfaces by pattern of names and by attributes of meshes."""

import mitsuba as mi
import numpy as np
import pytest

from tracer.errors import SettingsError
from tracer.viewpoint.surfaces import open_subject


def scene():
    place = mi.ScalarTransform4f().translate
    return mi.load_dict(
        {
            "type": "scene",
            "chair_1": {"type": "cube"},
            "chair_2": {"type": "cube", "to_world": place([3, 0, 0])},
            "table": {"type": "sphere", "center": [0, 3, 0]},
        }
    )


def labelled(labels, name="face_label", size=1):
    """Return a scene with a fan of triangles, and an attribute."""
    count = len(labels) if name.startswith("face") else len(labels) - 2
    mesh = mi.Mesh("fan", count + 2, count)
    parameters = mi.traverse(mesh)
    angle = np.linspace(0, np.pi, count + 1)
    rim = np.stack([np.cos(angle), np.sin(angle), np.zeros(count + 1)], axis=-1)
    parameters["vertex_positions"] = np.concatenate([np.zeros((1, 3)), rim]).ravel().astype(np.float32)
    parameters["faces"] = np.array([[0, k + 1, k + 2] for k in range(count)], np.uint32).ravel()
    parameters.update()
    mesh.add_attribute(name, size, np.ravel(labels).astype(np.float32))
    return mi.load_dict({"type": "scene", "fan": mesh, "ball": {"type": "sphere", "center": [5, 0, 0]}})


def test_shapes_that_match_a_pattern_are_one_surface():
    subject = open_subject(scene(), "shape", patterns=["chair_*"])
    assert subject.names == ["chair_*", "table"]
    assert subject.areas[0] == pytest.approx(48, rel=1e-6)
    by_face = open_subject(scene(), "face", patterns=["chair_2", "chair_*"])  # the first that matches counts
    assert by_face.count == 3
    assert by_face.areas[:2] == pytest.approx([24, 24], rel=1e-6)
    with pytest.raises(SettingsError, match="Nothing is called 'chiar_1', did you mean 'chair_1'"):
        open_subject(scene(), "shape", patterns=["chiar_1"])


def test_faces_of_one_value_are_one_surface():
    subject = open_subject(labelled([4, 4, 7, 4]), "face_label")
    assert subject.names == ["face_label 4", "face_label 7", "without"]
    assert np.bincount(subject.mesh.surface, minlength=3).tolist() == [3, 1, 0]
    rgb = open_subject(labelled([[1, 0, 0], [0, 1, 0], [1, 0, 0]], "face_color", 3), "face_color")
    assert rgb.names == ["face_color 0 1 0", "face_color 1 0 0", "without"]


def test_what_two_corners_share_counts_for_the_face():
    # Corners of the faces: (0, 1, 2), (0, 2, 3), (0, 3, 4), with the values 5, 5, 8, 8, 5.
    subject = open_subject(labelled([5, 5, 8, 8, 5], "vertex_label"), "vertex_label")
    assert subject.names == ["vertex_label 5", "vertex_label 8", "without"]
    assert subject.mesh.surface.tolist() == [0, 1, 0]


def test_an_attribute_that_is_not_there_is_said():
    with pytest.raises(SettingsError, match="No mesh has an attribute 'face_part'; there are face_label"):
        open_subject(labelled([1, 2]), "face_part")
    with pytest.raises(SettingsError, match="there is none"):
        open_subject(scene(), "vertex_part")
    with pytest.raises(SettingsError, match="Unknown kind of surface 'facet'"):
        open_subject(scene(), "facet")


def test_a_shape_without_a_name_has_a_number(tmp_path):
    path = tmp_path / "scene.xml"
    path.write_text('<scene version="3.0.0"><shape type="sphere" id="ball"/><shape type="cube"/></scene>')
    unnamed = mi.load_file(str(path))
    shape_ids = [shape.id() for shape in unnamed.shapes()]
    assert "" in shape_ids
    subject = open_subject(unnamed, "shape")
    assert sorted(subject.names) == sorted(["ball", str(1 + shape_ids.index(""))])
    assert open_subject(unnamed, patterns=[str(1 + shape_ids.index(""))]).count == 2

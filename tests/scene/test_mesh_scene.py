"""Parts of a mesh file as Mitsuba's shapes: the same surfaces, named, in the colours of the file."""

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest

from tracer.scene.mesh_scene import shapes_of
from tracer.scene.parts import Material, Part
from tracer.viewpoint.surfaces import open_subject

SQUARE = np.array([[-1.0, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]])
TWO = np.array([[0, 1, 2], [0, 2, 3]])
PICTURE = np.array([[[1, 0, 0], [0, 1, 0]], [[0, 0, 1], [1, 1, 1]]], np.float32)
"""Red and green above, blue and white below."""


def square(name="square", shift=0.0, material=None, places=None):
    up = np.tile([0.0, 0, 1], (4, 1))
    return Part(name, SQUARE + np.array([shift, 0, 0]), TWO, up, places, material or Material())


def reflectance(scene, x, y, from_above=True):
    """Return the diffuse reflectance that a ray sees at a place."""
    z = 1.0 if from_above else -1.0
    hit = scene.ray_intersect(mi.Ray3f(mi.Point3f(x, y, z), mi.Vector3f(0, 0, -z)))
    assert dr.all(hit.is_valid())
    return np.array(hit.bsdf().eval_diffuse_reflectance(hit)).ravel()


def test_places_in_a_picture_are_where_the_file_says():
    """Pictures begin above on the left, and places below on the left."""
    places = np.array([[0.0, 0], [1, 0], [1, 1], [0, 1]])
    material = Material(colour=(1.0, 1.0, 1.0), texture=PICTURE)
    scene = mi.load_dict({"type": "scene", **shapes_of([square(material=material, places=places)])})
    corners = {(-0.5, 0.5): [1, 0, 0], (0.5, 0.5): [0, 1, 0], (-0.5, -0.5): [0, 0, 1], (0.5, -0.5): [1, 1, 1]}
    for (x, y), colour in corners.items():
        for from_above in (True, False):
            assert reflectance(scene, x, y, from_above) == pytest.approx(colour, abs=0.02)


def test_a_colour_multiplies_the_picture():
    places = np.full((4, 2), 0.75)
    grey = np.full((2, 2, 3), 0.5, np.float32)
    material = Material(colour=(0.5, 1.0, 0.25), texture=grey)
    scene = mi.load_dict({"type": "scene", **shapes_of([square(material=material, places=places)])})
    assert reflectance(scene, 0, 0.1) == pytest.approx(0.2140 * np.array([0.5, 1, 0.25]), rel=0.02)


def test_equal_materials_are_one_surface_and_parts_keep_their_names():
    red, also_red, blue = Material("red", (0.5, 0, 0)), Material("red", (0.5, 0, 0)), Material("blue", (0, 0, 0.5))
    parts = [square("a", 0, red), square("b", 3, also_red), square("c", 6, blue)]
    scene = mi.load_dict({"type": "scene", **shapes_of(parts)})
    assert open_subject(scene, "bsdf").names == ["red", "blue"]
    by_shape = open_subject(scene, "shape")
    assert by_shape.names == ["a", "b", "c"]
    assert by_shape.areas == pytest.approx([4, 4, 4])
    assert open_subject(scene, "face").count == 6


def test_metal_is_metal():
    scene = mi.load_dict({"type": "scene", **shapes_of([square(material=Material(metallic=1.0, roughness=0.3))])})
    assert "principled" in str(scene.shapes()[0].bsdf()).lower()

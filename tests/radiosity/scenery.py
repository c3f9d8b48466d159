"""What rays see in the tests, without a scene."""

import drjit as dr
import mitsuba as mi
import numpy as np

from tracer.radiosity.groups import Points
from tracer.radiosity.hemisphere import NOTHING
from tracer.radiosity.meshing import cell_centres

GENERATOR = np.random.default_rng(1)
NORMALS = GENERATOR.normal(size=(7, 3))
POINTS = Points(GENERATOR.normal(size=(7, 3)), NORMALS / np.linalg.norm(NORMALS, axis=1, keepdims=True))
UP = Points(np.zeros((1, 3)), np.array([[0.0, 0.0, 1.0]]))


def plane(count, seed=7):
    """Return places of a unit square that look up, scattered in a grid."""
    generator = np.random.default_rng(seed)
    cells = np.stack(np.meshgrid(np.arange(count), np.arange(count)), axis=-1).reshape(-1, 2)
    places = np.column_stack([(cells + generator.random(cells.shape)) / count, np.zeros(len(cells))])
    return Points(places, np.tile([0.0, 0, 1], (len(places), 1)))


def box(ray):
    """Everything is one thing that shines alike."""
    return dr.zeros(mi.UInt32, dr.width(ray)), mi.Color3f(1.0) + dr.zeros(mi.Float, dr.width(ray))


def nothing(ray):
    return dr.zeros(mi.UInt32, dr.width(ray)) + NOTHING, dr.zeros(mi.Color3f, dr.width(ray))


def busy(ray):
    """Where x > 0.6 every ray hits something else, which shines or not."""
    cell = mi.UInt32(dr.abs(ray.d.y) * 9999)
    there = ray.d.x > 0.6
    return dr.select(there, cell, 0), mi.Color3f(dr.select(there & (cell % 2 == 0), 5.0, 0.0))


def square(corner, first, second):
    """Return what a parallelogram of radiance 1 looks like."""
    corner, first, second = (np.array(each, float) for each in (corner, first, second))
    normal = np.cross(first, second)

    def see(ray):
        n, c = mi.Vector3f(normal.tolist()), mi.Point3f(corner.tolist())
        distance = dr.dot(c - ray.o, n) / dr.dot(ray.d, n)
        at = ray(distance) - c
        a = dr.dot(at, mi.Vector3f(first.tolist())) / float(first @ first)
        b = dr.dot(at, mi.Vector3f(second.tolist())) / float(second @ second)
        hit = (distance > 0) & (a >= 0) & (a < 1) & (b >= 0) & (b < 1)
        return dr.select(hit, mi.UInt32(1), mi.UInt32(NOTHING)), mi.Color3f(dr.select(hit, 1.0, 0.0))

    return see


def form_factor(place, normal, corners):
    """Return the share of what leaves a place that a polygon receives (Lambert 1760)."""
    toward = (corners - place) / np.linalg.norm(corners - place, axis=1, keepdims=True)
    total = 0.0
    for a, b in zip(toward, np.roll(toward, -1, axis=0), strict=True):
        across = np.cross(a, b)
        total += np.arccos(a @ b) * (across / np.linalg.norm(across)) @ normal
    return abs(total) / (2 * np.pi)


def furnace(albedo):
    """Return a closed box whose inside emits radiance 1 everywhere."""
    bsdf = {"type": "diffuse", "reflectance": {"type": "rgb", "value": list(albedo)}}
    emitter = {"type": "area", "radiance": 1.0}
    return mi.load_dict(
        {"type": "scene", "c": {"type": "cube", "flip_normals": True, "bsdf": bsdf, "emitter": emitter}}
    )


HIGH = np.array([[0, 0, 0.5], [1, 0, 0.5], [0, 1, 0.5]])
"""Corners of the upper of ``two_triangles``."""
UPWARDS = np.array([0.0, 0, 1])


def two_triangles():
    """Return a scene of a triangle that emits 2 and faces up, and of one above that faces down; both reflect 0.6."""
    return mi.load_dict({"type": "scene", "low": triangle(0.0, 1, 2.0), "high": triangle(0.5, -1)})


def mean_form_factor(outside):
    """Return the mean over places of the lower of ``two_triangles`` of what of their light the upper receives."""
    places = np.pad(cell_centres(40), ((0, 0), (0, 1))) + outside
    return np.mean([form_factor(place, UPWARDS, HIGH) for place in places])


def triangle(height, facing, emitter=None):
    """Return a triangle at a height, which faces up or down."""
    corners = np.array([[0, 0, height], [1, 0, height], [0, 1, height]], np.float32)
    properties = mi.Properties()
    grey = {"type": "diffuse", "reflectance": {"type": "rgb", "value": 0.6}}
    properties["bsdf"] = mi.load_dict(grey)
    if emitter:
        properties["emitter"] = mi.load_dict({"type": "area", "radiance": {"type": "rgb", "value": emitter}})
    mesh = mi.Mesh(f"at {height}", 3, 1, props=properties)
    parameters = mi.traverse(mesh)
    parameters["vertex_positions"] = corners.ravel()
    parameters["faces"] = np.array([0, 1, 2] if facing > 0 else [0, 2, 1], np.uint32)
    parameters.update()
    return mesh

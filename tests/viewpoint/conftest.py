"""Scenes whose views are known exactly."""

import mitsuba as mi
import numpy as np
import pytest


def rectangles():
    """Return six rectangles that form a cube of edge 1 around the origin."""
    turn = mi.ScalarTransform4f
    sides = [([1, 0, 0], 0), ([1, 0, 0], 90), ([1, 0, 0], 180), ([1, 0, 0], 270), ([0, 1, 0], 90), ([0, 1, 0], -90)]
    shapes = {
        f"side{k}": {"type": "rectangle", "to_world": turn().rotate(*side) @ turn().translate([0, 0, 0.5]).scale(0.5)}
        for k, side in enumerate(sides)
    }
    return {"type": "scene", **shapes}


@pytest.fixture
def quads():
    return mi.load_dict(rectangles())


@pytest.fixture
def triangles():
    return mi.load_dict({"type": "scene", "cube": {"type": "cube", "to_world": mi.ScalarTransform4f().scale(0.5)}})


def mesh_scene(vertices, faces):
    """Return a scene of one mesh."""
    mesh = mi.Mesh("mesh", len(vertices), len(faces))
    parameters = mi.traverse(mesh)
    parameters["vertex_positions"] = np.ravel(vertices).astype(np.float32)
    parameters["faces"] = np.ravel(faces).astype(np.uint32)
    parameters.update()
    return mi.load_dict({"type": "scene", "mesh": mesh})

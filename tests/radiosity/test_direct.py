"""Light straight from lamps, against Lambert's closed form: what is below a surface does not light it."""

import mitsuba as mi
import numpy as np
import pytest

from tracer.radiosity.direct import direct_of_patches
from tracer.radiosity.meshing import cut

from .scenery import form_factor

T = mi.ScalarTransform4f
ABOVE, BELOW = 2.0, 50.0
"""Radiance of the lamps."""
CORNERS = np.array([[-1.0, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]])
UP = np.array([0.0, 0, 1])


def lamp(radiance, height):
    """Return a square of side 2 at a height, which shines at the plane z = 0."""
    turned = T().translate([0, 0, height]) @ T().rotate([1, 0, 0], 180 if height > 0 else 0)
    emitter = {"type": "area", "radiance": {"type": "rgb", "value": radiance}}
    return {"type": "rectangle", "to_world": turned, "emitter": emitter}


@pytest.mark.parametrize("twosided", [False, True])
def test_a_sheet_between_two_lamps(twosided):
    grey = {"type": "diffuse", "reflectance": {"type": "rgb", "value": 0.5}}
    sheet = {"type": "rectangle", "bsdf": {"type": "twosided", "both": grey} if twosided else grey}
    scene = {"type": "scene", "sheet": sheet, "above": lamp(ABOVE, 1.0), "below": lamp(BELOW, -0.7)}
    patches = cut(mi.load_dict(scene), 0.75)
    # Means over a side of 9 seeds; three comparisons at 5 standard errors of 8 degrees of freedom (Student): false
    # alarms below 1 in 300.
    found = np.stack([direct_of_patches(patches, 1024, seed)[:, 0] for seed in range(9)])
    sheet_patches = np.abs(patches.centres[:, 2]) < 0.1
    sides = {1.0: (ABOVE, 1.0), -1.0: (BELOW, -0.7)} if twosided else {1.0: (ABOVE, 1.0)}
    assert set(patches.normals[sheet_patches, 2].round(6)) == set(sides)
    for side, (radiance, height) in sides.items():
        here = np.flatnonzero(sheet_patches & (patches.normals[:, 2] * side > 0.5))
        corners = CORNERS + height * UP
        expected = np.mean([np.pi * radiance * form_factor(patches.centres[k], side * UP, corners) for k in here])
        means = found[:, here].mean(axis=1)
        assert abs(means.mean() - expected) < 5 * means.std(ddof=1) / 3 + 1e-4 * expected
        assert means.std(ddof=1) < 0.02 * expected

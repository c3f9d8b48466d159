"""What materials reflect, against what is known of them."""

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest

from tracer.radiosity.albedo import MIRROR, albedo, not_diffuse


def found(bsdf, side=1.0, count=4):
    interaction = dr.zeros(mi.SurfaceInteraction3f, count)
    interaction.t = 1
    interaction.n = mi.Normal3f(0, 0, 1)
    interaction.sh_frame = mi.Frame3f(mi.Normal3f(0, 0, 1))
    interaction.wi = mi.Vector3f(0, 0, side)
    return albedo(mi.load_dict(bsdf), interaction)


def test_diffuse_is_exact():
    grey = {"type": "diffuse", "reflectance": {"type": "rgb", "value": [0.2, 0.4, 0.6]}}
    assert np.abs(found(grey) - [0.2, 0.4, 0.6]).max() < 1e-6
    assert not not_diffuse(mi.load_dict(grey))


def test_a_mirror_reflects_nearly_all():
    assert found({"type": "conductor"}) == pytest.approx(np.full((4, 3), MIRROR))
    assert not_diffuse(mi.load_dict({"type": "conductor"}))


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_glass_reflects_what_fresnel_has_it_reflect_of_even_light(side):
    """R. Dunkle's integral: of light from all around, 9.18 % comes back from glass of 1.5, 59.6 % inside of it."""
    glass = {"type": "dielectric", "int_ior": 1.5, "ext_ior": 1.0}
    expected = 0.0918 if side > 0 else 1 - (1 - 0.0918) / 1.5**2
    values = found(glass, side, 2000)
    assert values.mean(axis=0) == pytest.approx(np.full(3, expected), abs=4 * values.std() / np.sqrt(2000))


def test_rough_metal_reflects_no_more_than_all():
    values = found({"type": "roughconductor", "alpha": 0.05, "material": "Au"}, count=500)
    assert values.min() > 0.2
    assert values.max() <= MIRROR
    assert values[:, 0].mean() > values[:, 2].mean()

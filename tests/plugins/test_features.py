"""The integrator ``features``: values known beforehand, and those of Mitsuba's own AOVs, in several variants."""

import subprocess
import sys
from pathlib import Path

import mitsuba as mi
import numpy as np
import pytest

T = mi.ScalarTransform4f
GREY = [0.5, 0.5, 0.5]


def wall(bsdf=None, **film):
    """Return a wall two units before a parallel camera that begins rays at 0.5; the left half of it is cut away."""
    size = {"type": "hdrfilm", "width": 8, "height": 4, "rfilter": {"type": "box"}, **film}
    eye = T().look_at([0, 0, 2], [0, 0, 0], [0, 1, 0])
    sensor = {"type": "orthographic", "near_clip": 0.5, "to_world": eye, "film": size}
    shape = {"type": "rectangle", "to_world": T().translate([-1, 0, 0])} | ({} if bsdf is None else {"bsdf": bsdf})
    return {"type": "scene", "sensor": sensor, "wall": shape}


def look(scene, spp=4):
    """Return albedo, normal, depth of ``mi.render``, each (H, W, C)."""
    image = np.array(mi.render(mi.load_dict(scene), integrator=mi.load_dict({"type": "features"}), spp=spp))
    return np.split(image[..., -7:], [3, 6], axis=-1)


def test_a_wall_and_nothing():
    albedo, normal, depth = look(wall({"type": "diffuse", "reflectance": {"type": "rgb", "value": [0.2, 0.5, 0.8]}}))
    seen = depth[..., 0] > 0
    assert seen.sum() == 16
    assert albedo[seen] == pytest.approx(np.tile([0.2, 0.5, 0.8], (16, 1)))
    assert normal[seen] == pytest.approx(np.tile([0.0, 0.0, 1.0], (16, 1)))
    assert depth[seen] == pytest.approx(1.5)
    for each in (albedo, normal, depth):
        assert np.all(each[~seen] == 0)


@pytest.mark.parametrize(
    ("bsdf", "expected"),
    [
        (None, GREY),
        ({"type": "twosided", "inner": {"type": "diffuse", "reflectance": 0.25}}, [0.25] * 3),
        ({"type": "plastic", "diffuse_reflectance": {"type": "rgb", "value": [0.1, 0.3, 0.2]}}, [0.1, 0.3, 0.2]),
        ({"type": "principled", "base_color": {"type": "rgb", "value": [0.1, 0.3, 0.2]}}, [0.1, 0.3, 0.2]),
        ({"type": "mask", "opacity": 0.5, "inner": {"type": "diffuse"}}, GREY),
        ({"type": "conductor", "specular_reflectance": {"type": "rgb", "value": [0.9, 0.6, 0.3]}}, [0.9, 0.6, 0.3]),
        ({"type": "dielectric"}, [1.0, 1.0, 1.0]),
        ({"type": "roughdielectric", "alpha": 0.2}, [1.0, 1.0, 1.0]),
        ({"type": "thindielectric", "specular_transmittance": {"type": "rgb", "value": [0.2, 1, 0.2]}}, [0.2, 1, 0.2]),
        ({"type": "null"}, [1.0, 1.0, 1.0]),
    ],
)
def test_albedo_of_materials(bsdf, expected):
    albedo, _, depth = look(wall(bsdf))
    assert albedo[depth[..., 0] > 0] == pytest.approx(np.tile(expected, (16, 1)), abs=1e-5)


def test_a_rough_metal_has_its_colour():
    gold, _, depth = look(wall({"type": "roughconductor", "material": "Au", "alpha": 0.01}))
    red, green, blue = gold[depth[..., 0] > 0].T
    assert np.all(red > green + 0.1)
    assert np.all(green > blue + 0.2)
    assert red.max() < 1


def test_what_shines_has_its_radiance_up_to_one():
    scene = wall({"type": "diffuse", "reflectance": 0.0})
    scene["wall"]["emitter"] = {"type": "area", "radiance": {"type": "rgb", "value": [0.1, 2.0, 0.3]}}
    scene["sky"] = {"type": "constant", "radiance": {"type": "rgb", "value": [0.2, 0.4, 30.0]}}
    albedo, _, depth = look(scene)
    seen = depth[..., 0] > 0
    assert albedo[seen] == pytest.approx(np.tile([0.1, 1.0, 0.3], (16, 1)), abs=1e-5)
    assert albedo[~seen] == pytest.approx(np.tile([0.2, 0.4, 1.0], (16, 1)), abs=1e-5)


def room(size=24):
    """Return the Cornell box with a bumpy ball beside a glass one in it, and no lamp in sight; an instance of both."""
    scene = mi.cornell_box()
    film = {"width": size, "height": size, "rfilter": {"type": "gaussian"}}
    scene["sensor"]["film"] |= film
    scene["sensor"]["sampler"] = {"type": "owen_sobol", "sample_count": 16}
    del scene["light"]
    ball = {"type": "sphere", "radius": 0.3, "bsdf": {"type": "diffuse", "reflectance": 0.7}}
    scene["balls"] = {"type": "shapegroup", "ball": ball, "other": {"type": "cube", "to_world": T().scale(0.1)}}
    for k, place in enumerate(([0.5, 0.6, 0.2], [-0.6, 0.3, 0.4])):
        to_world = T().translate(place).rotate([0, 1, 1], 40)
        scene[f"balls_{k}"] = {"type": "instance", "group": {"type": "ref", "id": "balls"}, "to_world": to_world}
    return scene


def test_equal_to_the_aovs_of_mitsuba():
    scene = mi.load_dict(room())
    aov = mi.load_dict({"type": "aov", "aovs": "a:albedo,n:sh_normal,d:depth"})
    expected = np.array(mi.render(scene, integrator=aov, spp=16, seed=5))[..., -7:]
    found = np.array(mi.render(scene, integrator=mi.load_dict({"type": "features"}), spp=16, seed=5))[..., -7:]
    assert found == pytest.approx(expected, abs=1e-5)
    assert found[..., :3].std() > 0.1


OTHER_VARIANTS = """
import sys

import tracer

tracer.activate(sys.argv[1])
import mitsuba as mi
import numpy as np

mi.set_log_level(mi.LogLevel.Error)
from plugins.test_features import look, wall

reflectance = {"type": "rgb", "value": [0.2, 0.5, 0.8]}
scene = wall({"type": "diffuse", "reflectance": reflectance})
scene["sky"] = {"type": "constant", "radiance": reflectance}
albedo, normal, depth = look(scene)
print(*albedo[0, 0], *albedo[0, 7], *normal.sum((0, 1)), depth.sum())
assert np.ptp(albedo[:, :4], axis=(0, 1)).max() < 1e-4
metal = look(wall({"type": "conductor", "material": "Au"}))[0].max(axis=(0, 1))
assert 0.3 < metal.min() <= metal.max() <= 1
"""


@pytest.mark.parametrize("variant", ["llvm_ad_spectral", "llvm_ad_mono", "llvm_ad_spectral_polarized"])
def test_other_variants(variant):
    if variant not in mi.variants():
        pytest.skip(f"this Mitsuba has no {variant}")
    folder = Path(__file__).parent.parent
    command = [sys.executable, "-c", OTHER_VARIANTS, variant]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    *albedo, x, y, z, depth = (float(number) for number in done.stdout.split())
    if "mono" in variant:
        assert albedo == pytest.approx([albedo[0]] * 6, abs=1e-5)
        assert 0.2 < albedo[0] < 0.8
    else:
        assert albedo == pytest.approx([0.2, 0.5, 0.8] * 2, abs=0.02)
    assert [x, y, z] == pytest.approx([0, 0, 16], abs=1e-5)
    assert depth == pytest.approx(16 * 1.5)

"""Solutions that are known: furnaces, two patches, and pictures of a path tracer."""

import mitsuba as mi
import numpy as np
import pytest

from radiosity.scenery import furnace
from tracer.errors import SceneError
from tracer.radiosity.gathering import solve
from tracer.radiosity.guide import Guidance
from tracer.radiosity.meshing import cut

T = mi.ScalarTransform4f


def rgb(*value):
    return {"type": "rgb", "value": list(value)}


def test_white_furnace():
    albedo = np.array([0.5, 0.8, 0.2])
    found = solve(cut(furnace(albedo), 0.5), 32, residual=1e-7)
    expected = np.pi / (1 - albedo)
    assert np.abs(found.radiosity / expected - 1).max() < 1e-5
    assert found.residual < 1e-7


def test_energy_in_is_energy_out():
    """In a closed box what is emitted is absorbed: sum A E = sum A (1 - rho) H, if each gives what others get."""
    patches = cut(furnace([0.5, 0.8, 0.2]), 0.25)
    found = solve(patches, 64, residual=1e-8)
    emitted = np.sum(patches.areas[:, None] * patches.emitted, axis=0)
    absorbed = np.sum(patches.areas[:, None] * (1 - patches.albedo) * found.irradiance, axis=0)
    assert absorbed == pytest.approx(emitted, rel=1e-5)


def test_two_parallel_squares():
    """B1 = E + rho F B2, B2 = rho F B1 with F = 0.199825 of unit squares at distance 1 (Howell C-11), if B were even.

    It is not, so patches are small and the means are compared with the exact ones of a fine solution's own kernel: the
    first bounce is F exactly, and the second is between the square of the least and the largest form factor of a point.
    """
    white = {"type": "diffuse", "reflectance": rgb(0.5, 0.5, 0.5)}
    lower = {"type": "rectangle", "to_world": T().scale(0.5), "bsdf": white}
    lower["emitter"] = {"type": "area", "radiance": rgb(1.0, 1.0, 1.0)}
    upper = {"type": "rectangle", "to_world": T().translate([0, 0, 1]).rotate([1, 0, 0], 180).scale(0.5), "bsdf": white}
    patches = cut(mi.load_dict({"type": "scene", "lower": lower, "upper": upper}), 0.1)
    found = solve(patches, 1024, residual=1e-9)
    above = patches.emitted[:, 0] == 0
    factor = 0.199825
    mean = float(found.radiosity[above, 0].mean()) / np.pi
    least = (
        0.5 * factor / (1 - (0.5 * 0.1385) ** 2)
    )  # 0.1385: form factor of a corner (Howell C-4, four times a quarter)
    largest = 0.5 * factor / (1 - (0.5 * 0.2395) ** 2)  # 0.2395: of the middle
    assert least * 0.997 < mean < largest * 1.003


def meant(scene, patches, chosen, spp):
    """Return the radiance (N, 3) that leaves patches, by Mitsuba's path tracer."""
    integrator = mi.load_dict({"type": "path", "max_depth": 64, "rr_depth": 64})
    sampler = mi.load_dict({"type": "independent"})
    sampler.seed(0, len(chosen) * spp)
    places = np.repeat(patches.centres[chosen] + 1e-3 * patches.normals[chosen], spp, axis=0).T.astype(np.float32)
    toward = np.repeat(-patches.normals[chosen], spp, axis=0).T.astype(np.float32)
    ray = mi.RayDifferential3f(mi.Point3f(*places), mi.Vector3f(*toward))
    radiance = np.array(integrator.sample(scene, sampler, ray)[0], float).T.reshape(len(chosen), spp, -1)
    return radiance.mean(axis=1), radiance.std(axis=1) / np.sqrt(spp)


@pytest.mark.parametrize("lights", [False, True])
def test_agrees_with_a_path_tracer_the_better_the_smaller_patches_are(lights):
    box = mi.load_dict(mi.cornell_box())
    errors = []
    for size in (1.2, 0.5, 0.2):
        patches = cut(box, size)
        found = solve(patches, 512 if lights else 4096, residual=1e-5, lights=lights)
        lit = np.flatnonzero((patches.emitted.max(axis=1) == 0) & (patches.albedo.max(axis=1) > 0))
        chosen = np.random.default_rng(4).choice(lit, 60, replace=False)
        expected, _ = meant(box, patches, chosen, 2048)
        scale = expected.mean()
        errors.append(np.mean(np.abs(found.radiosity[chosen] / np.pi - expected)) / scale)
    assert errors[2] < errors[1] < errors[0]
    assert errors[2] < 0.04


@pytest.mark.slow
def test_guided_rays_find_the_same_and_less_error():
    """A lamp that shines at the ceiling from near: what is not the ceiling is lit by a small bright part of it."""
    scene = mi.cornell_box()
    scene["light"]["to_world"] = T().translate([0.3, 0.85, 0.2]).rotate([1, 0, 0], -90).scale(0.08)
    patches = cut(mi.load_dict(scene), 0.2)
    truth = np.mean([solve(patches, 2048, 1e-6, seed, True).radiosity for seed in (90, 91)], axis=0)
    errors = []
    for guidance in (None, Guidance()):
        found = [solve(patches, 256, 1e-6, seed, True, guidance) for seed in range(6)]
        mean = np.sum(patches.areas[:, None] * np.mean([each.radiosity for each in found], axis=0))
        assert mean == pytest.approx(np.sum(patches.areas[:, None] * truth), rel=2e-3)
        assert found[0].rays <= 2 * 256 * 1.02 * len(patches)
        assert (found[0].guided > 0.5) == (guidance is not None)
        errors.append(np.mean([np.mean((each.radiosity - truth) ** 2) for each in found]))
    assert errors[1] < errors[0]


def test_light_that_goes_to_and_fro_for_ever_is_told_of():
    with pytest.raises(SceneError, match="largest albedo is 1; make it less than 1"):
        solve(cut(furnace([1.0, 1.0, 1.0])), 16, residual=1e-6)


def test_a_white_surface_in_the_open_is_no_trouble():
    white = {"type": "diffuse", "reflectance": {"type": "rgb", "value": 1.0}}
    scene = {"type": "scene", "sky": {"type": "constant"}, "ground": {"type": "rectangle", "bsdf": white}}
    found = solve(cut(mi.load_dict(scene), 0.5), 64)
    assert found.radiosity == pytest.approx(np.full(found.radiosity.shape, np.pi), rel=1e-4)

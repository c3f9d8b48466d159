"""Shooting: no power is made or lost, and the solution is that of gathering."""

import mitsuba as mi
import numpy as np
import pytest

from tracer.errors import SceneError
from tracer.radiosity.gathering import solve
from tracer.radiosity.guide import Guidance
from tracer.radiosity.meshing import cut
from tracer.radiosity.shooting import brightest, shoot

from .scenery import HIGH, UPWARDS, form_factor, mean_form_factor, two_triangles
from .test_gathering import furnace

COMPLEX = Guidance("distinct", 4)


def balance(found):
    return found.absorbed + found.lost + found.unsent


@pytest.mark.parametrize("guidance", [None, COMPLEX])
def test_energy_in_is_energy_out(guidance):
    patches = cut(mi.load_dict(mi.cornell_box()), 0.2)
    found = shoot(patches, 64, 1e-4, spread=guidance)
    assert balance(found) == pytest.approx(found.supplied, rel=1e-9)
    assert found.unsent.sum() <= 1e-4 * found.supplied.sum()
    # The box is open in front.
    assert (found.lost > 0).all()


@pytest.mark.parametrize("guidance", [None, COMPLEX])
def test_white_furnace(guidance):
    albedo = np.array([0.5, 0.8, 0.2])
    patches = cut(furnace(albedo), 0.25)
    found = shoot(patches, 256, 1e-6, spread=guidance)
    area = patches.areas[:, None]
    assert balance(found) == pytest.approx(found.supplied, rel=1e-9)
    assert found.lost.max() < 1e-6 * found.supplied.max()
    assert np.sum(area * found.radiosity, axis=0) / area.sum() == pytest.approx(np.pi / (1 - albedo), rel=1e-5)
    assert np.abs(found.radiosity / (np.pi / (1 - albedo)) - 1).mean() < 0.05


def test_agrees_with_gathering():
    """Each patch by as much as few rays let it, and all in all."""
    patches = cut(mi.load_dict(mi.cornell_box()), 0.2)
    gathered = solve(patches, 2048, 1e-6)
    found = shoot(patches, 1024, 1e-5)
    area = patches.areas[:, None]
    assert np.sum(area * found.radiosity) == pytest.approx(np.sum(area * gathered.radiosity), rel=0.01)
    assert np.mean(np.abs(found.radiosity - gathered.radiosity)) < 0.05 * gathered.radiosity.mean()


def test_from_around():
    """A grey square under an even sky: what falls on it is pi, and half of it goes back to the sky."""
    grey = {"type": "diffuse", "reflectance": {"type": "rgb", "value": 0.5}}
    scene = mi.load_dict({"type": "scene", "sky": {"type": "constant"}, "ground": {"type": "rectangle", "bsdf": grey}})
    found = shoot(cut(scene, 0.5), 64, 1e-5)
    assert found.radiosity == pytest.approx(np.full(found.radiosity.shape, np.pi / 2), rel=1e-4)
    assert found.lost == pytest.approx(found.supplied, rel=1e-9)


def test_the_brightest_are_chosen():
    assert brightest(np.array([1.0, 5.0, 0.0, 3.0])).tolist() == [1]
    assert brightest(np.array([4.0, 5.0, 0.0, 3.0])).tolist() == [1, 0]
    assert brightest(np.ones(4)).tolist() == [0, 1]


def test_two_patches_exchange_as_the_closed_form_has_it():
    """B1 = E + rho F B2, B2 = rho F B1, with the form factor F from the middle of a patch to the other for gathering.

    Rays that shoot leave from all over a patch: F is the mean over its places.
    """
    patches = cut(two_triangles())
    assert len(patches) == 2
    low = int(patches.emitted.max(axis=1).argmax())
    outside = UPWARDS * patches.points.outside
    factor = form_factor(patches.centres[low] + outside, UPWARDS, HIGH)
    mean_factor = mean_form_factor(outside)
    assert mean_factor < 0.97 * factor
    emitted = 2 * np.pi
    gathered = solve(patches, 1 << 20, 1e-9).radiosity[:, 0]
    shot = shoot(patches, 1 << 20, 1e-9).radiosity[:, 0]
    # Over seeds the errors of gathering have a standard deviation of 2.5e-5 at most, those of shooting of 5e-5.
    for found, seen, tolerance in ((gathered, factor, 1e-4), (shot, mean_factor, 3e-4)):
        expected = np.array([1.0, 0.6 * seen]) * emitted / (1 - (0.6 * seen) ** 2)
        assert found[[low, 1 - low]] == pytest.approx(expected, rel=tolerance)


def test_large_patches_of_a_furnace_are_right():
    """From the middles of patches alone, they would be 4 % off on average however many rays there are."""
    patches = cut(furnace(np.array([0.5, 0.8, 0.2])), 1.0)
    found = shoot(patches, 8192, 1e-5).radiosity * (1 - np.array([0.5, 0.8, 0.2])) / np.pi
    assert np.abs(found - 1).mean() < 0.006
    assert np.abs(found - 1).max() < 0.03


def test_light_that_goes_to_and_fro_for_ever_is_told_of():
    with pytest.raises(SceneError, match="largest albedo is 1; make it less than 1"):
        shoot(cut(furnace([1.0, 1.0, 1.0])), 4)

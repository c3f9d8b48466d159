"""Illuminance against closed forms, and what is said of each surface."""

import mitsuba as mi
import numpy as np
import pytest

from tracer.errors import SettingsError
from tracer.radiosity.gathering import solve
from tracer.radiosity.meshing import cut
from tracer.radiosity.photometry import check_efficacy, illuminance, lit_surfaces
from tracer.radiosity.shooting import shoot

T = mi.ScalarTransform4f


def rgb(*value):
    return {"type": "rgb", "value": list(value)}


def test_white_and_green():
    """Y of the sRGB primaries is in IEC 61966-2-1: 0.2126, 0.7152 and 0.0722."""
    primaries = illuminance(np.eye(3))
    assert primaries == pytest.approx([683 * 0.2126, 683 * 0.7152, 683 * 0.0722], rel=1e-3)
    assert illuminance(np.ones((2, 4, 3)), 1.0) == pytest.approx(np.ones((2, 4)), rel=1e-5)


@pytest.mark.parametrize("efficacy", [0.0, -1.0, float("nan"), float("inf")])
def test_an_efficacy_is_a_number_of_lumens(efficacy):
    with pytest.raises(SettingsError, match="lumens above 0"):
        check_efficacy(efficacy)


@pytest.mark.parametrize("solver", [solve, shoot])
def test_squares_that_face_each_other(solver):
    """Unit squares at distance 1: F = 0.199825 (J. R. Howell, C-11), and a mean of 683 pi F L of green light."""
    black = {"type": "diffuse", "reflectance": rgb(0.0, 0.0, 0.0)}
    lamp = {"type": "rectangle", "to_world": T().scale(0.5), "bsdf": black}
    lamp["emitter"] = {"type": "area", "radiance": rgb(0.0, 2.0, 0.0)}
    over = T().translate([0, 0, 1]).rotate([1, 0, 0], 180).scale(0.5)
    ceiling = {"type": "rectangle", "to_world": over, "bsdf": {"type": "twosided", "both": black}}
    patches = cut(mi.load_dict({"type": "scene", "lamp": lamp, "ceiling": ceiling}), 0.1)
    found = {surface.name: surface for surface in lit_surfaces(patches, illuminance(solver(patches, 1024).irradiance))}
    assert set(found) == {"lamp", "ceiling"}
    surface = found["ceiling"]
    assert surface.area == pytest.approx(1, rel=1e-5)
    assert surface.mean == pytest.approx(683 * 0.71516 * np.pi * 0.199825 * 2, rel=0.01)
    # Form factors of a corner and of the middle of the square (Howell C-4, four times a quarter).
    assert surface.least / surface.mean == pytest.approx(0.1385 / 0.199825, rel=0.07)
    assert surface.greatest / surface.mean == pytest.approx(0.2395 / 0.199825, rel=0.07)
    assert surface.uniformity == pytest.approx(surface.least / surface.mean)
    assert found["lamp"].greatest == 0
    assert found["lamp"].uniformity == 0


def test_surfaces_by_size_with_names_and_both_sides_where_both_are_lit():
    paper = {"type": "twosided", "both": {"type": "diffuse"}}
    sheet = {"type": "rectangle", "to_world": T().translate([0, 0, 3]), "bsdf": {"type": "ref", "id": "paper"}}
    ground = {"type": "rectangle", "to_world": T().scale(2)}
    scene = {"type": "scene", "sky": {"type": "constant"}, "paper": paper, "sheet": sheet, "ground": ground}
    patches = cut(mi.load_dict(scene), 0.5)
    lux = illuminance(solve(patches, 64).irradiance)
    found = lit_surfaces(patches, lux)
    assert [(surface.name, surface.material) for surface in found] == [
        ("ground", ""),
        ("sheet", "paper"),
        ("sheet, back", "paper"),
    ]
    chosen = np.arange(len(patches)) >= len(patches.back.numpy())
    back = found[2]
    assert back.mean == pytest.approx(np.average(lux[chosen], weights=patches.areas[chosen]))
    assert (back.least, back.greatest) == (lux[chosen].min(), lux[chosen].max())
    leak = lux.copy()
    leak[chosen] *= 1e-3
    assert [surface.name for surface in lit_surfaces(patches, leak)] == ["ground", "sheet"]

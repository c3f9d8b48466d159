"""Places on rectangles by solid angle and cosine, against sums over many places by area."""

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest

from benchmarks.guiding.spherical_rectangle import SphericalRectangle, warped

SIDE = 512
CORNER, FIRST, SECOND = np.array([-1.0, 0.5, 2.0]), np.array([2.0, 0.0, 0.0]), np.array([0.0, 0.8, 0.6])
POINTS = {
    "near": [0.3, 0.7, 1.9],
    "far": [5.0, -8.0, 3.0],
    "on the other side": [0.0, 2.0, 1.0],
    "above a corner": [-1.0, -0.1, 2.8],
}


def even_numbers():
    """Return the middles of equal squares in the unit square, as mi.Point2f and as an array (N, 2)."""
    number = np.stack(np.meshgrid(*[(np.arange(SIDE) + 0.5) / SIDE] * 2), axis=-1).reshape(-1, 2)
    return mi.Point2f(mi.Float(number[:, 0]), mi.Float(number[:, 1])), number


def by_area(point):
    """Return evenly spread places (N, 3), the directions to them, and the solid angle that each stands for."""
    number = even_numbers()[1]
    places = CORNER + number[:, :1] * FIRST + number[:, 1:] * SECOND
    towards = places - point
    distance = np.linalg.norm(towards, axis=1, keepdims=True)
    normal = np.cross(FIRST, SECOND)
    return places, towards / distance, np.abs(towards @ normal) / distance[:, 0] ** 3 / len(number)


def seen(point):
    return SphericalRectangle.of(*(mi.Vector3f(np.float32(vector)) for vector in (CORNER, FIRST, SECOND, point)))


@pytest.mark.parametrize("point", POINTS.values(), ids=POINTS)
def test_the_solid_angle_is_the_integral_over_the_rectangle(point):
    assert seen(point).solid_angle[0] == pytest.approx(by_area(point)[2].sum(), rel=2e-3)


@pytest.mark.parametrize("point", POINTS.values(), ids=POINTS)
def test_places_are_even_over_solid_angle(point):
    """All means up to the second powers of the place along both sides are those of evenly spread directions."""
    places = np.array(seen(point).place(even_numbers()[0])).T
    expected, _, angle = by_area(point)
    for powers in ((1, 0), (0, 1), (2, 0), (1, 1), (0, 2)):
        mine, theirs = (
            ((drawn - CORNER) @ FIRST / (FIRST @ FIRST)) ** powers[0]
            * ((drawn - CORNER) @ SECOND / (SECOND @ SECOND)) ** powers[1]
            for drawn in (places, expected)
        )
        assert mine.mean() == pytest.approx((theirs * angle).sum() / angle.sum(), abs=2e-3)


@pytest.mark.parametrize("point", POINTS.values(), ids=POINTS)
def test_the_density_by_cosines_integrates_to_the_solid_angle(point):
    """So does any function over the density: here the direction itself."""
    rectangle, number = seen(point), even_numbers()[0]
    normal = dr.normalize(mi.Vector3f(np.float32(CORNER + 0.6 * FIRST + 0.4 * SECOND - point)))
    chosen, density = warped(number, rectangle.cosines(normal))
    directions = dr.normalize(rectangle.place(chosen) - rectangle.seen_from) * rectangle.solid_angle / density
    _, expected, angle = by_area(point)
    assert np.array(directions).mean(axis=1) == pytest.approx(
        (expected * angle[:, None]).sum(axis=0), rel=5e-3, abs=1e-4
    )
    assert dr.mean(dr.rcp(density))[0] == pytest.approx(1, rel=2e-3)


def test_values_that_are_linear_are_met_exactly():
    """With the density of values at the corners, their bilinear mix over the density is the same everywhere."""
    corners = [mi.Float(value) for value in (1.0, 2.0, 0.5, 4.0)]
    chosen, density = warped(even_numbers()[0], corners)
    a, b, c, d = (1.0, 2.0, 0.5, 4.0)
    mix = dr.lerp(dr.lerp(a, b, chosen.x), dr.lerp(c, d, chosen.x), chosen.y)
    assert np.allclose(mix / density, 7.5 / 4, rtol=1e-3)


@pytest.mark.parametrize("point", [[0.0, 0.9, 2.3], [4000.0, 1.0, 0.0]], ids=["in its plane", "seen as a speck"])
def test_what_float32_cannot_tell_is_left_to_area(point):
    assert not seen(point).is_wide[0]

"""Slots: every light and every part of it has its place, and the numbers that choose stay even."""

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tracer.core.device import upload
from tracer.guiding.slots import MOST_SLOTS, Slots, morton, plan_slots, slots_of

from .lights import scene_with_lights


@given(st.lists(st.sampled_from([1, 4, 8]), min_size=1, max_size=700), st.integers(0, 99))
def test_every_light_is_in_the_slots_once(sides, seed):
    low = np.random.default_rng(seed).random((len(sides), 3))
    plan = plan_slots(np.array(sides), low, low + 0.1)
    assert len(plan.first) <= MOST_SLOTS
    assert sorted(plan.order) == list(range(len(sides)))
    assert plan.stock.sum() == pytest.approx(1)
    for place in range(len(sides)):
        mine = np.flatnonzero((plan.first <= place) & (place < plan.first + plan.count))
        assert mine.tolist() == list(range(plan.begin[place], plan.begin[place] + plan.parts[place]))
        assert sorted(plan.part[mine]) == list(range(len(mine)))


def test_lights_of_a_group_are_near_each_other():
    centres = np.random.default_rng(3).random((2000, 3))
    plan = plan_slots(np.ones(2000, int), centres, centres)
    extents = [
        np.ptp(centres[plan.order[a : a + n]], axis=0).max() for a, n in zip(plan.first, plan.count, strict=True)
    ]
    assert len(plan.first) == MOST_SLOTS
    assert np.median(extents) < 0.3


def test_the_curve_is_the_one_by_interleaved_bits():
    points = np.array([[0, 0, 0], [1023, 0, 0], [0, 1023, 0], [5, 3, 6], [1023, 1023, 1023]], float)
    expected = [
        sum(((int(p[axis]) >> bit) & 1) << (3 * bit + axis) for bit in range(10) for axis in range(3)) for p in points
    ]
    assert morton(points).tolist() == expected


def test_large_lights_are_cut_and_others_are_not():
    scene = scene_with_lights("area", "sky", "point")
    plan = slots_of(scene)
    sides = {light.class_name(): plan.side[plan.first == k][0] for k, light in enumerate(scene.emitters())}
    assert sides == {"AreaLight": 4, "ConstantBackgroundEmitter": 8, "PointLight": 1}


@pytest.mark.parametrize("kinds", [("area", "sky", "point"), ("point",) * 600])
def test_each_light_gets_even_numbers(kinds):
    """Within a slot, what is left of the numbers fills the slot's part of the unit square."""
    scene = scene_with_lights(*kinds)
    plan = slots_of(scene)
    slots = Slots.of(scene, plan)
    side = 64
    u = (np.arange(side) + 0.5) / side
    x, y = (values.ravel() for values in np.meshgrid(u, u))
    for slot in (0, len(plan.first) // 2, len(plan.first) - 1):
        number = mi.Point2f(upload(mi.Float, x), upload(mi.Float, y))
        place, inner, share = slots.within(dr.full(mi.UInt32, slot, side**2), number, mi.Bool(True))
        place = place.numpy()
        assert place.min() >= plan.first[slot]
        assert place.max() < plan.first[slot] + plan.count[slot]
        assert np.bincount(place - plan.first[slot]).min() >= side**2 // plan.count[slot] - 2 * side
        column, row = divmod(int(plan.part[slot]), int(plan.side[slot]))
        for values, begin in ((inner.x.numpy(), column), (inner.y.numpy(), row)):
            scaled = values * plan.side[slot] - begin
            assert abs(scaled.mean() - 0.5) < 0.02
            assert scaled.min() >= -1e-5
            assert scaled.max() <= 1 + 1e-5
        assert np.allclose(share.numpy(), plan.side[slot] ** 2 / plan.count[slot])


def test_parts_are_where_they_are():
    """The parts of a square light are the squares of a grid; one of a row is at the end of the light."""
    scene = scene_with_lights("area")
    plan = slots_of(scene)
    corner, far = np.array(scene.emitters()[0].bbox().min).ravel(), np.array(scene.emitters()[0].bbox().max).ravel()
    low, high = plan.centre.min(axis=0), plan.centre.max(axis=0)
    assert np.allclose(low[:2], corner[:2] + (far - corner)[:2] / 8, atol=1e-4)
    assert np.allclose(high[:2], far[:2] - (far - corner)[:2] / 8, atol=1e-4)
    assert np.allclose(plan.radius, 0.5 * np.sqrt(2) * (far - corner)[0] / 4, atol=1e-4)


def test_a_sky_has_no_place():
    plan = slots_of(scene_with_lights("sky", "point"))
    assert np.isinf(plan.radius[plan.side == 8]).all()
    assert plan.radius[plan.side == 1].tolist() == [0]


def test_no_light_has_the_first_place():
    slots = Slots.of(scene := scene_with_lights("area", "point"), slots_of(scene))
    assert slots.place_of(dr.zeros(mi.EmitterPtr, 2)).numpy().tolist() == [0, 0]


def test_a_sky_among_many_lamps_has_a_slot_of_its_own():
    random = np.random.default_rng(1)
    places = random.uniform(-1, 1, (300, 3))
    low, high = (np.insert(places + size, 7, np.inf * size, axis=0) for size in (-0.01, 0.01))
    plan = plan_slots(np.ones(301, np.int64), low, high, 64)
    assert (plan.order[0], plan.count[0]) == (7, 1)
    assert np.isinf(plan.radius[0])
    assert np.isfinite(plan.radius[1:]).all()
    assert sorted(plan.order) == list(range(301))
    assert plan.count.sum() == 301
    assert len(plan.count) == 64

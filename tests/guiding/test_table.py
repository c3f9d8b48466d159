"""A table chooses each light as often as it says, and says how often."""

import mitsuba as mi
import numpy as np
import pytest

from tracer.core.device import upload
from tracer.guiding.cells import Grid
from tracer.guiding.slots import slots_of
from tracer.guiding.table import LightChances, LightTable

from .lights import scene_with_lights

COUNT = 1 << 16


def table_of(scene, seed=0):
    """Return a table of two rows, Mitsuba's and one at random, and its plan and chances."""
    plan = slots_of(scene)
    random = np.random.default_rng(seed).gamma(0.5, size=len(plan.stock)) + 0.05
    chances = np.stack([plan.stock, random / random.sum()])
    grid = Grid(np.array([-2.0, -2, 0]), 2.0, (2, 2, 1))
    row = (np.arange(grid.cell_count) % 2).astype(np.uint32)
    return LightTable.of(scene, plan, LightChances(grid, row, chances)), plan, chances


def even_numbers(count=COUNT):
    """Return numbers that fill the unit square evenly (Hammersley, 1960)."""
    number, bits = np.arange(count), count.bit_length() - 1
    reversed_bits = sum(((number >> bit) & 1) << (bits - 1 - bit) for bit in range(bits))
    return mi.Point2f(upload(mi.Float, (number + 0.5) / count), upload(mi.Float, (reversed_bits + 0.5) / count))


@pytest.mark.parametrize("kinds", [("area", "sky", "point"), ("point",) * 600, ("area",)])
@pytest.mark.parametrize("row", [0, 1])
def test_each_slot_and_light_is_chosen_as_often_as_the_table_says(kinds, row):
    scene = scene_with_lights(*kinds)
    table, plan, chances = table_of(scene)
    first = mi.UInt32(row * len(plan.stock)) + mi.UInt32(np.zeros(COUNT, np.uint32))
    choice = table.choose(first, even_numbers())
    slots = np.bincount(choice.slot.numpy(), minlength=len(plan.stock)) / COUNT
    uncut = plan.side == 1  # the others are chosen by both numbers
    assert np.allclose(slots[uncut], chances[row][uncut], atol=1.5 / COUNT)
    assert np.allclose(slots, chances[row], atol=12 / COUNT)
    place = table.slots.place_of(choice.light).numpy()
    lights = np.bincount(place, minlength=len(plan.order))
    said = np.zeros(len(plan.order))
    said[place] = choice.light_chance.numpy()
    assert np.allclose(lights / COUNT, said, atol=3 / COUNT)
    assert np.allclose(choice.slot_chance.numpy(), chances[row][choice.slot.numpy()], rtol=1e-3)


@pytest.mark.parametrize("kinds", [("sky",), ("area",), ("point", "point")])
def test_with_the_chances_of_mitsuba_a_light_gets_the_same_numbers(kinds):
    """So a guide that has learned nothing is as even as ``path``."""
    scene = scene_with_lights(*kinds)
    table, _, _ = table_of(scene)
    number = even_numbers()
    choice = table.choose(mi.UInt32(np.zeros(COUNT, np.uint32)), number)
    x = number.x.numpy() * len(kinds)
    assert np.allclose(choice.number.x.numpy(), x - np.floor(x), atol=1e-4)
    assert np.allclose(choice.number.y.numpy(), number.y.numpy(), atol=1e-4)


@pytest.mark.parametrize("kinds", [("area", "sky", "point"), ("point",) * 600])
@pytest.mark.parametrize("row", [0, 1])
def test_to_divide_by_the_density_gives_each_light_its_full_weight(kinds, row):
    """The mean of f / density is the integral of f over a light's unit square, for each light (f = 1, and f = x y)."""
    scene = scene_with_lights(*kinds)
    table, plan, _ = table_of(scene)
    first = mi.UInt32(row * len(plan.stock)) + mi.UInt32(np.zeros(1 << 19, np.uint32))
    choice = table.choose(first, even_numbers(1 << 19))
    place = table.slots.place_of(choice.light).numpy()
    for function, integral in ((1, 1.0), (choice.number.x.numpy() * choice.number.y.numpy(), 0.25)):
        sums = np.bincount(place, function / choice.density.numpy(), len(plan.order)) / (1 << 19)
        assert np.allclose(sums, integral, rtol=0.2)
        assert sums.mean() == pytest.approx(integral, rel=0.01)


def test_cells_have_their_rows():
    scene = scene_with_lights("area", "point")
    table, plan, _ = table_of(scene)
    places = mi.Point3f([-1, 1, -1, 50], [-1, -1, 1, 50], 0.0)
    up, left = table.row_at(places, mi.Vector3f(0, 0, 1)), table.row_at(places, mi.Vector3f(-1, 0, 0))
    assert (up.numpy() / len(plan.stock)).tolist() == [1, 1, 1, 1]
    assert (left.numpy() / len(plan.stock)).tolist() == [0, 0, 0, 0]


def test_what_is_packed_is_unpacked():
    scene = scene_with_lights("area", "point")
    plan = slots_of(scene)
    grid = Grid(np.array([1.0, 2, 3]), 0.5, (1, 2, 3))
    learned = LightChances(grid, np.zeros(grid.cell_count, np.uint32), plan.stock[None])
    again = LightChances.unpack(learned.pack())
    assert again.grid.boxes == grid.boxes
    assert again.grid.low.tolist() == [1, 2, 3]
    assert np.array_equal(again.chances, learned.chances)
    packed = learned.pack()
    with pytest.raises(ValueError, match="another grid"):
        LightChances.unpack({**packed, "row": packed["row"][1:]})
    with pytest.raises(ValueError, match="another grid"):
        LightChances.unpack({**packed, "row": packed["row"] + np.uint32(1)})
    with pytest.raises(ValueError, match="no grid"):
        LightChances.unpack({**packed, "grid": packed["grid"][1:]})

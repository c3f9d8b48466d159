"""The sampler: nets, scrambles, keys; and how it does under Mitsuba's own integrators."""

import itertools

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tracer.plugins import owen_sobol, pairings

words = st.integers(0, 2**32 - 1)


def points(count, *, seed=5, pixel=3, skip=0):
    """Return the first points (2, count) of one pixel in the dimension pair after ``skip`` others."""
    sampler = mi.load_dict({"type": "owen_sobol"})
    sampler.seed_samples(seed, dr.full(mi.UInt32, pixel, count), dr.arange(mi.UInt32, count))
    for _ in range(skip):
        sampler.next_2d()
    return np.array(sampler.next_2d())


def reverse(value):
    return int(f"{value:032b}"[::-1], 2)


@pytest.mark.parametrize("pixel", [0, 1, 70000])
@pytest.mark.parametrize("skip", [0, 1, 6])
@pytest.mark.parametrize("log_count", [3, 6, 8])
def test_every_elementary_interval_holds_one_point(log_count, pixel, skip):
    count = 1 << log_count
    x, y = points(count, pixel=pixel, skip=skip)
    for a in range(log_count + 1):
        columns, rows = 1 << a, 1 << (log_count - a)
        cell = np.floor(x * columns).astype(int) * rows + np.floor(y * rows).astype(int)
        assert np.array_equal(np.sort(cell), np.arange(count))


def test_one_dimensional_samples_are_stratified():
    sampler = mi.load_dict({"type": "owen_sobol"})
    sampler.seed_samples(1, dr.full(mi.UInt32, 9, 64), dr.arange(mi.UInt32, 64))
    values = np.array(sampler.next_1d())
    assert np.array_equal(np.sort(np.floor(values * 64)), np.arange(64))


def test_second_dimension_is_sobols():
    # Direction numbers of the second dimension (polynomial x + 1), by their recurrence.
    directions = [1 << 31]
    for _ in range(31):
        directions.append(directions[-1] ^ (directions[-1] >> 1))
    for index in [0, 1, 2, 3, 5, 77, 1 << 20, 0x89ABCDEF]:
        expected = 0
        for bit in range(32):
            expected ^= directions[bit] if index >> bit & 1 else 0
        assert reverse(int(owen_sobol.pascal(mi.UInt32(index))[0])) == expected


@given(words, words, words)
def test_scramble_is_a_nested_permutation(first, second, seed):
    """Owen's definition: digit k is permuted by a choice that depends on the digits above it alone."""
    if first == second:
        return
    inputs = mi.UInt32([reverse(first), reverse(second)])
    outputs = [reverse(int(x)) for x in owen_sobol.scramble_reversed(inputs, mi.UInt32(seed)).numpy()]
    assert (outputs[0] ^ outputs[1]).bit_length() == (first ^ second).bit_length()


def true_owen_scramble(values, bits, rng):
    """Scramble integers of ``bits`` digits with an independent random bit for every node of the tree."""
    result = np.zeros_like(values)
    for digit in range(bits):
        flips = rng.integers(0, 2, 1 << digit)
        shift = bits - 1 - digit
        result |= (((values >> shift) & 1) ^ flips[values >> (shift + 1)]) << shift
    return result


def test_integrates_as_well_as_a_true_owen_scramble():
    """Mean squared error for a disc and a smooth function, 64 points, 600 seeds: within 25 % of random trees."""
    rng = np.random.default_rng(0)
    bits, count, repeats = 16, 64, 600
    sobol = np.array([[reverse(i) >> 16, reverse(int(owen_sobol.pascal(mi.UInt32(i))[0])) >> 16] for i in range(count)])
    functions = (
        (lambda x, y: (x - 0.4) ** 2 + (y - 0.5) ** 2 < 0.09, np.pi * 0.09),
        (lambda x, y: np.sin(np.pi * x) * np.sin(np.pi * y), 4 / np.pi**2),
    )
    ours = [points(count, seed=s, pixel=s * 7 + 1) for s in range(repeats)]
    trees = [[(true_owen_scramble(sobol[:, d], bits, rng) + 0.5) / (1 << bits) for d in (0, 1)] for _ in range(repeats)]
    for function, integral in functions:
        errors = [np.mean([(function(*p).mean() - integral) ** 2 for p in sets]) for sets in (ours, trees)]
        assert errors[0] == pytest.approx(errors[1], rel=0.25)


def test_a_sample_does_not_depend_on_its_lane():
    sampler = mi.load_dict({"type": "owen_sobol"})
    rng = np.random.default_rng(0)
    pixel, index = np.repeat(np.arange(50), 16), np.tile(np.arange(16), 50)
    chosen = rng.permutation(800)[:100]
    results = []
    for p, i in ((pixel, index), (pixel[chosen], index[chosen])):
        sampler.seed_samples(9, mi.UInt32(p.astype(np.uint32)), mi.UInt32(i.astype(np.uint32)))
        results.append([np.array(sampler.next_1d()), *np.array(sampler.next_2d())])
    for whole, part in zip(*results, strict=True):
        assert np.array_equal(whole[chosen], part)


def test_clone_goes_on_where_the_original_is_and_fork_starts_anew():
    sampler = mi.load_dict({"type": "owen_sobol", "sample_count": 8})
    sampler.seed(3, 64)
    sampler.next_2d()
    copy = sampler.clone()
    assert np.array_equal(np.array(sampler.next_2d()), np.array(copy.next_2d()))
    anew = sampler.fork()
    assert anew.sample_count() == 8
    assert anew.dimension.numpy().tolist() == [0]


def test_forks_and_clones_keep_the_seed_of_a_scene():
    first = mi.load_dict({"type": "owen_sobol", "sample_count": 8, "seed": 7})
    copies = [first.fork(), first.clone()]
    for made in (first, *copies):
        made.seed(3, 64)
    expected = np.array(first.next_2d())
    assert all(np.array_equal(np.array(made.next_2d()), expected) for made in copies)


def test_lanes_are_all_samples_of_a_pixel_and_then_those_of_the_next():
    sampler = mi.load_dict({"type": "owen_sobol", "sample_count": 8})
    sampler.seed(3, 32)
    found = np.array(sampler.next_2d())
    for pixel in range(4):
        assert np.array_equal(found[:, 8 * pixel : 8 * pixel + 8], points(8, seed=3, pixel=pixel))


def test_values_are_below_one():
    largest = owen_sobol.to_unit_interval(mi.UInt32([0, 255, 256, 2**31, 2**32 - 1])).numpy()
    assert largest.tolist() == [0, 0, 2**-24, 0.5, 1 - 2**-24]


def test_a_third_wavefront_continues_too():
    sampler = mi.load_dict({"type": "owen_sobol", "sample_count": 4})
    sampler.seed(3, 4)
    drawn = []
    for _ in range(4):
        drawn.append(np.array(sampler.next_2d()))
        sampler.advance()
    assert np.array_equal(np.concatenate(drawn, axis=1), points(16, seed=3, pixel=0))


def test_a_second_wavefront_continues_the_sequence():
    sampler = mi.load_dict({"type": "owen_sobol", "sample_count": 8})
    sampler.seed(3, 8)
    first = np.array(sampler.next_2d())
    sampler.advance()
    both = np.concatenate([first, np.array(sampler.next_2d())], axis=1)
    cells = np.floor(both[0] * 4) * 4 + np.floor(both[1] * 4)
    assert len(set(cells)) == 16


def test_symbolic_loop_equals_unrolled_loop(cornell):
    scene = mi.load_dict(cornell() | {"integrator": {"type": "path", "max_depth": 4}})
    sensor = mi.load_dict(cornell()["sensor"] | {"sampler": {"type": "owen_sobol", "sample_count": 4}})
    symbolic = np.array(mi.render(scene, sensor=sensor, spp=4, seed=1))
    with dr.scoped_set_flag(dr.JitFlag.SymbolicLoops, False):
        unrolled = np.array(mi.render(scene, sensor=sensor, spp=4, seed=1))
    assert np.allclose(symbolic, unrolled, atol=1e-5)


def test_seeds_and_pixels_differ_and_counts_are_checked():
    assert not np.array_equal(points(16, seed=1), points(16, seed=2))
    assert not np.array_equal(points(16, pixel=1), points(16, pixel=2))
    assert not np.array_equal(points(16, skip=0), points(16, skip=1))
    for seed in (1, 2**31):
        sampler = mi.load_dict({"type": "owen_sobol", "sample_count": 16, "seed": seed})
        sampler.seed(0, 16)
        assert not np.array_equal(np.array(sampler.next_2d()), points(16, seed=0, pixel=0))
    with pytest.raises(RuntimeError, match="at least 1"):
        mi.load_dict({"type": "owen_sobol", "sample_count": 0})


VARIANT_SCRIPT = """
import sys, tracer
tracer.activate(sys.argv[1])
import mitsuba as mi, numpy as np
for name in ("path", "volpath", "prb"):
    scene = mi.cornell_box()
    scene["integrator"] = {"type": name, "max_depth": 3}
    scene["sensor"]["film"] |= {"width": 8, "height": 8}
    scene["sensor"]["sampler"] = {"type": "owen_sobol", "sample_count": 16}
    image = np.array(mi.render(mi.load_dict(scene), spp=16))
    assert np.all(np.isfinite(image)) and image.mean() > 0.05, (name, image.mean())
"""


@pytest.mark.slow
@pytest.mark.parametrize("variant", [name for name in mi.variants() if name.startswith("llvm")])
def test_renders_under_every_llvm_variant(variant, tmp_path):
    import subprocess
    import sys

    subprocess.run([sys.executable, "-c", VARIANT_SCRIPT, variant], check=True, cwd=tmp_path)


@pytest.mark.parametrize("size", [1, 2, 5, 24, 32])
def test_entries_of_a_table(size):
    table = list(range(100, 100 + size))
    assert owen_sobol.entry(table, dr.arange(mi.UInt32, size)).numpy().tolist() == table


@pytest.mark.parametrize("gap", [1, 2, 3])
@pytest.mark.parametrize("first", [0, 1, 5, 20])
def test_two_pairs_are_spread_together(first, gap):
    """Halves and quarters of one dimension against those of another: what random orders would leave to chance."""
    count = 64
    pairs = itertools.product(points(count, skip=first), points(count, skip=first + gap))
    for (x, y), (columns, rows) in itertools.product(pairs, ((2, 2), (2, 4), (4, 2))):
        cell = np.floor(x * columns).astype(int) * rows + np.floor(y * rows).astype(int)
        assert np.all(np.bincount(cell, minlength=columns * rows) == count // (columns * rows))


def test_cycles_of_pairs_are_nets_and_differ():
    pairs = len(pairings.POLYNOMIALS)
    first, second = points(64, skip=2), points(64, skip=2 + pairs)
    assert len(set(np.floor(second[0] * 8) * 8 + np.floor(second[1] * 8))) == 64
    together = np.histogram2d(first[0], second[0], bins=8)[0]
    assert np.count_nonzero(together) > 32  # a copy of the first, scrambled, would fill 8 of 64


def test_an_order_is_the_product_with_all_digits_of_its_polynomial():
    """Without carry, and towards lower bits: what falls off is lost."""
    index = 0xDEADBEEF
    for pair, polynomial in enumerate(pairings.POLYNOMIALS):
        expected = 0
        for k, digit in enumerate(f"{polynomial:b}"[::-1]):
            expected ^= int(digit) * (index >> k)
        assert int(owen_sobol.reorder(mi.UInt32(index), mi.UInt32(pair))[0]) == expected
    assert max(pairings.POLYNOMIALS).bit_length() == pairings.DEGREE


def test_pixels_and_dimensions_are_scrambled_independently():
    """The first sample of 4096 pixels: one of 15 correlations is beyond 4.5 / 64 by chance once in 10 000 runs."""
    sampler = mi.load_dict({"type": "owen_sobol"})
    sampler.seed_samples(1, dr.arange(mi.UInt32, 4096), dr.zeros(mi.UInt32, 4096))
    one, two, three, four = sampler.next_1d(), sampler.next_2d(), sampler.next_2d(), sampler.next_1d()
    values = np.stack([np.array(each) for each in (one, *two, *three, four)])
    correlations = np.corrcoef(values)[np.triu_indices(6, 1)]
    assert np.abs(correlations).max() < 4.5 / 64
    assert values.mean(axis=1) == pytest.approx(np.full(6, 0.5), abs=4.5 * 12**-0.5 / 64)


def test_later_cycles_are_shuffled_anew():
    """One pair in its second and third cycle: in one order for both, cells of 8 x 8 would be met in eight, or in 64."""
    pairs = len(pairings.POLYNOMIALS)
    second, third = points(64, skip=2 + pairs), points(64, skip=2 + 2 * pairs)
    together = np.histogram2d(second[0], third[0], bins=8)[0]
    assert 24 < np.count_nonzero(together) < 60  # at random 64 (1 - exp(-1)) = 40


def test_dependence_is_that_of_ranks():
    rng = np.random.default_rng(3)
    rows = [rng.integers(0, 32, 200).astype(np.uint64) for _ in range(4)]
    spans = [{0}] * 200
    expected = np.zeros(200, bool)
    for row in rows:
        for k, value in enumerate(row):
            expected[k] |= int(value) in spans[k]
            spans[k] = spans[k] | {int(value) ^ one for one in spans[k]}
    assert 20 < expected.sum() < 180
    assert np.array_equal(pairings.dependent(rows), expected)


@pytest.mark.slow
def test_polynomials_are_those_that_the_search_finds():
    """Each is chosen by those before it, and to find all takes minutes."""
    first = 2 * len(pairings.POLYNOMIALS) // 5
    assert pairings.search(first) == list(pairings.POLYNOMIALS)[:first]

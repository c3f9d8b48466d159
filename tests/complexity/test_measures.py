"""Values from analysis, and properties."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from tracer.complexity import measures

counts = hnp.arrays(np.int64, st.integers(1, 40), elements=st.integers(0, 1000))


def test_cube_seen_from_its_centre_has_the_entropy_of_its_faces():
    assert measures.entropy(np.ones(6)) == pytest.approx(np.log2(6))
    assert measures.entropy(np.ones(12)) == pytest.approx(np.log2(12))


def test_cube_over_the_whole_sphere_with_background():
    # Cube of edge 1 seen face-on from distance 2 of its centre: solid angle 0.400670 of 4 pi.
    d, a = 1.5, 0.5
    seen = 4 * np.arctan(a**2 / (d * np.sqrt(2 * a**2 + d**2)))
    assert seen == pytest.approx(0.400670, abs=1e-6)
    assert measures.entropy([4 * np.pi - seen, seen]) == pytest.approx(0.203755, abs=1e-6)
    assert measures.entropy([4 * np.pi - seen, seen / 2, seen / 2]) == pytest.approx(0.235639, abs=1e-6)


def test_empty_view_is_zero_not_nan():
    for measure in (measures.entropy, measures.gini, lambda c: measures.renyi(c, 2)):
        assert measure(np.zeros(5)) == 0
    assert measures.tsallis(np.zeros(5), 2) == 0
    assert measures.viewpoint_complexity(np.zeros(5), surfaces=5, image_area=100) == 0


def test_viewpoint_complexity_of_the_paper():
    # Two of four surfaces are visible and cover 60 of 100 pixels.
    assert measures.viewpoint_complexity([40, 20, 0, 0], surfaces=4, image_area=100) == pytest.approx(0.5 + 0.6)
    # areas of the visible ones alone say the same
    assert measures.viewpoint_complexity([40, 20], surfaces=4, image_area=100) == pytest.approx(0.5 + 0.6)
    assert measures.ray_viewpoint(np.array([2, 2]), np.zeros(2, bool), 0) == 0


@given(counts)
def test_entropies_are_ordered_and_bounded(values):
    shannon, collision = measures.entropy(values), measures.renyi(values, 2)
    assert -1e-9 <= collision <= shannon + 1e-9 <= np.log2(max(np.count_nonzero(values), 1)) + 2e-9
    assert 0 <= measures.gini(values) <= 1 - 1 / len(values) + 1e-12
    assert measures.tsallis(values, 2) == pytest.approx(measures.gini(values), abs=1e-12)


@given(counts)
def test_limits_of_the_generalised_entropies_are_shannons(values):
    shannon = measures.entropy(values)
    assert measures.renyi(values, 1 + 1e-7) == pytest.approx(shannon, abs=1e-4)
    assert measures.tsallis(values, 1 + 1e-7) == pytest.approx(shannon * np.log(2), abs=1e-4)
    assert measures.renyi(values, 1) == pytest.approx(measures.renyi(values, 1 + 1e-7), abs=1e-4)
    assert measures.tsallis(values, 1) == pytest.approx(measures.tsallis(values, 1 + 1e-7), abs=1e-4)


@given(counts)
def test_splitting_every_face_in_two_adds_one_bit(values):
    if values.sum() == 0:
        return
    assert measures.entropy(np.repeat(values, 2)) == pytest.approx(measures.entropy(values) + 1)


@given(hnp.arrays(np.int64, st.tuples(st.integers(1, 5), st.integers(1, 30)), elements=st.integers(0, 6)))
def test_entropy_of_rays_needs_no_histogram(ids):
    multiplicity = (ids[:, :, None] == ids[:, None, :]).sum(axis=-1)
    for row, m in zip(ids, multiplicity, strict=True):
        histogram = np.unique(row, return_counts=True)[1]
        assert measures.ray_entropy(m) == pytest.approx(measures.entropy(histogram))
        assert measures.ray_gini(m) == pytest.approx(measures.gini(histogram))
        assert measures.ray_distinct(m) == len(histogram)


@pytest.mark.parametrize("rays", [2, 8, 64])
@pytest.mark.parametrize("equal", [1, 2])
def test_divergences_of_k_equal_values_among_n(equal, rays):
    values = np.zeros(rays)
    values[:equal] = 0.3
    assert measures.kullback_leibler(values) == pytest.approx(np.log(rays / equal))
    assert measures.chi_square(values) == pytest.approx(rays / equal - 1)
    assert measures.hellinger(values) == pytest.approx(1 - np.sqrt(equal / rays))
    assert measures.contrast(values) == pytest.approx(np.log2(rays / equal) / np.log2(rays))


def test_small_noise_relates_the_divergences():
    noise = 1 + 1e-3 * np.random.default_rng(0).standard_normal(10_000)
    chi_square = measures.chi_square(noise)
    assert chi_square == pytest.approx(np.var(noise) / np.mean(noise) ** 2, rel=1e-6)
    assert measures.kullback_leibler(noise) == pytest.approx(chi_square / 2, rel=0.01)
    assert measures.hellinger(noise) == pytest.approx(chi_square / 8, rel=0.01)


MEASURES = [measures.contrast, measures.kullback_leibler, measures.chi_square, measures.hellinger]


@pytest.mark.parametrize("measure", MEASURES)
def test_nothing_is_as_uniform_as_equal_values(measure):
    found = measure([[0, 0, 0, 0], [0.7, 0.7, 0.7, 0.7], [1, 0, 0, 0]])
    assert found[:2] == pytest.approx([0, 0], abs=1e-12)
    assert found[2] > 0.4
    assert measure([3.0]) == 0


def test_negative_counts_are_refused():
    with pytest.raises(ValueError, match="negative"):
        measures.entropy([1, -1])


def test_viewpoint_complexity_of_rays_is_that_of_their_areas():
    ids = np.array([3, 3, 3, 5, 0, 0, 7, 7])  # 0: a miss
    multiplicity = np.array([np.sum(ids == each) for each in ids])
    expected = measures.viewpoint_complexity([3, 1, 2, 0, 0], surfaces=5, image_area=8)
    assert measures.ray_viewpoint(multiplicity, ids != 0, 5) == pytest.approx(float(expected))

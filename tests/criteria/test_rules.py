"""The rules of other renderers, against loops over all samples."""

import mitsuba as mi
import numpy as np
import pytest

from tracer import criteria
from tracer.criteria import half_buffers, luxcore
from tracer.image.colour import LUMINANCE

from .made_up import evidence_of, importance, light, statistics_of


def dilated(values):
    """Return the largest of 3 x 3 neighbours."""
    padded = np.pad(values, 1, constant_values=-1)
    height, width = values.shape
    return np.max([padded[r : r + height, c : c + width] for r in range(3) for c in range(3)], axis=0)


def in_half(name, index):
    return (index & 0xAAAAAAAA).bit_count() % 2 == 1 if name == "cycles" else index % 2 == 0


@pytest.mark.parametrize("brightness", [0.1, 10.0])
@pytest.mark.parametrize("name", ["cycles", "mitsuba_1731"])
@pytest.mark.parametrize("number", [16, 13])
def test_difference_of_half_the_samples(name, number, brightness):
    samples = brightness * light(number)
    mean = samples.mean(axis=0)
    half = np.mean([sample for index, sample in enumerate(samples) if in_half(name, index)], axis=0)
    intensity = mean.sum(axis=-1)
    scale = 1e-4 + np.where(intensity < 1, np.sqrt(intensity), intensity)
    expected = dilated(np.abs(mean - half).sum(axis=-1) / scale)
    assert importance(name, samples) == pytest.approx(expected, rel=1e-4)


@pytest.mark.parametrize("number", [4, 16, 20])
def test_the_two_classes_are_of_one_size(number):
    colour, index = [mi.Float(1.0)], mi.UInt32(np.arange(number, dtype=np.uint32))
    for classes in (half_buffers.class_a, half_buffers.even):
        assert np.array(classes(colour, index)[0][1]).sum() == number / 2


def test_a_pixel_without_a_half_counts_as_the_worst():
    samples = np.tile(light(2), (1, 3, 3, 1))
    assert importance("mitsuba_1731", samples).min() > 0
    # of the first two samples none is in class A
    assert np.all(importance("cycles", samples) == 1)


def test_contrast_is_between_the_extremes():
    samples = light(5) + 0.1
    most, least = samples.max(axis=0), samples.min(axis=0)
    expected = ((most - least) / (most + least) / [0.4, 0.3, 0.6]).max(axis=-1)
    assert importance("contrast", samples) == pytest.approx(expected, rel=1e-5)


def test_green_counts_most_in_contrast():
    samples = np.full((2, 1, 3, 3), 0.5)
    for channel in range(3):
        samples[1, 0, channel, channel] = 0.25
    assert importance("contrast", samples)[0] == pytest.approx((1 / 3) / np.array([0.4, 0.3, 0.6]))


def test_confidence_is_relative_to_the_mean_but_not_in_the_dark():
    samples = light(20)
    samples[:, 0] *= 1e-5
    bright = samples @ LUMINANCE
    mean = bright.mean(axis=0)
    usual = np.maximum(mean, 0.01 * mean.mean())
    assert np.any(usual != mean)
    expected = 1.959964 * np.sqrt(bright.var(axis=0, ddof=1) / len(bright)) / usual
    assert importance("z_test", samples) == pytest.approx(expected, rel=1e-3)


def test_shape_id_is_eight_to_one(cornell):
    class Seen:
        same_face = np.zeros((1, 3, 4))
        face_gini = np.array([[0.0, 1e-15, 2 * 0.25 * 0.75]])

    evidence = evidence_of(statistics_of(light(2, 1, 3), "shape_id"), look=Seen)
    assert criteria.get("shape_id").importance(evidence).tolist() == [[1, 1, 8]]


def noise_by_loops(new, old):
    """Return the noise map of LuxCore, pixel by pixel."""
    height, width, _ = new.shape
    change = np.zeros((height, width))
    for row, column in np.ndindex(height, width):
        total = new[row, column].sum()
        change[row, column] = np.abs(new[row, column] - old[row, column]).sum() / np.sqrt(total) if total else 0
    smooth = np.zeros((height, width))
    for row, column in np.ndindex(height, width):
        window = change[max(row - 4, 0) : row + 4, max(column - 4, 0) : column + 4]
        smooth[row, column] = window.mean()
    score = np.clip((smooth - smooth.mean()) / smooth.std(), -6, 6)
    return (score - score.min()) / (score.max() - score.min())


def test_luxcore_looks_at_what_changed():
    old, new = (statistics_of(light(8, 20, 30, seed=seed), "luxcore") for seed in (0, 1))
    old.mean[:9, :9], new.mean[:9, :9] = 0, 0
    shown = [np.clip(each.mean.astype(np.float64), 0, 1) ** (1 / 2.2) for each in (new, old)]
    expected = np.maximum(noise_by_loops(*shown), 0.05)
    found = criteria.get("luxcore").importance(evidence_of(new, before=old))
    assert found == pytest.approx(expected, rel=1e-6)
    assert (found.min(), found.max()) == (pytest.approx(0.05), pytest.approx(1))


def test_luxcore_cuts_off_outliers():
    old = np.zeros((100, 100, 3))
    new = old + 1e-3
    new[50, 50] = 1
    new[20, 20] = 0.05
    assert luxcore.noise(new, old) == pytest.approx(noise_by_loops(new, old), rel=1e-6)


def test_luxcore_starts_the_same_everywhere():
    known = statistics_of(light(), "luxcore")
    rule = criteria.get("luxcore").importance
    assert np.all(rule(evidence_of(known)) == 1)
    assert np.ptp(rule(evidence_of(known, before=known))) == 0

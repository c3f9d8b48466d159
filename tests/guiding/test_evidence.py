"""What paths show of errors, against values from analysis."""

import numpy as np
import pytest

from tracer.guiding.chosen import choose
from tracer.guiding.evidence import Judgement, Taught, brightness, error_left
from tracer.guiding.training import Paths, Trials

GRID = 50, 80


def judged(sample, block=4, pixels=500):
    """Return what paths with the radiance ``sample(shape)`` show: shape (pixels, 2, block)."""
    chosen = choose(GRID, pixels, block, 0, 0)
    return Judgement.of(Paths(chosen, sample((pixels, 2, block)).ravel()))


def left(first, last, objective="absolute"):
    return error_left(first, last, GRID, objective, 0.0)


def test_errors_are_variances_of_the_means_of_blocks():
    random = np.random.default_rng(1)
    found = judged(lambda shape: random.normal(2, 0.5, shape), pixels=4000)
    assert found.error.mean() == pytest.approx(0.25 / 4, rel=0.1)
    assert found.mean == pytest.approx(2, abs=1)


@pytest.mark.parametrize("objective", ["absolute", "relative", "display"])
def test_what_is_left_of_the_error_is_measured_with_its_doubt(objective):
    random = np.random.default_rng(2)
    ratios, doubts = [], []
    for _ in range(40):
        before, after = (judged(lambda shape, size=size: random.normal(0.5, size, shape)) for size in (0.1, 0.05))
        ratio, doubt = left(before, after, objective)
        ratios.append(ratio)
        doubts.append(doubt)
    assert np.mean(ratios) == pytest.approx(0.25, rel=0.1)
    assert np.std(ratios) / np.mean(ratios) == pytest.approx(np.mean(doubts), rel=0.35)


def test_nothing_is_gained_where_nothing_has_changed():
    """Also where pixels are bright because of single samples: such a brightness would hide their errors."""
    random = np.random.default_rng(3)
    ratios = [
        left(*(judged(lambda shape: random.exponential(0.5, shape), block=1) for _ in range(2)), "relative")[0]
        for _ in range(100)
    ]
    assert np.exp(np.mean(np.log(ratios))) == pytest.approx(1, abs=0.05)


def test_the_same_rays_leave_no_doubt():
    same = judged(lambda shape: np.random.default_rng(4).normal(2, 1, shape))
    assert left(same, same) == (1.0, 0.0)


def test_pictures_without_light_have_nothing_left_to_learn():
    dark = judged(np.zeros)
    assert left(dark, dark) == (1.0, 0.0)


def taught(radiance):
    chosen = choose(GRID, 8, 2, 0, len(radiance) // 2)
    path = np.arange(len(radiance), dtype=np.uint32)
    nowhere = np.zeros((len(path), 3))
    trials = Trials(path, nowhere, nowhere, 0 * path, np.ones(len(path)), 0.5 * radiance)
    values = np.concatenate([np.full(chosen.judge_count, 99.0), radiance])
    return Taught.of(Paths(chosen, values), [trials], GRID, "absolute", 0.0)


def test_paths_that_judge_do_not_teach():
    radiance = np.random.default_rng(5).normal(2, 0.5, 4000)
    found = taught(radiance)
    assert found.path_count == 4000
    assert found.noise.mean() == pytest.approx(0.25, rel=0.1)
    assert found.squares == pytest.approx(0.25 * radiance**2)


def test_what_was_taught_before_stays():
    first, second = (taught(np.random.default_rng(seed).normal(2, 0.5, 4000)) for seed in (6, 7))
    both = second.after(first)
    assert both.path_count == 8000
    assert both.trials.path.tolist() == list(range(8000))
    assert np.array_equal(both.noise, first.noise)  # of Mitsuba's choice
    assert first.after(None) is first


def test_brightness_is_that_of_the_square():
    radiance = np.array([1.0, 3.0, 5.0, 7.0])
    pixel = np.array([0, 7, 8, 16 * 8])  # in pictures 16 wide: one square of 8 x 8, the one beside it, the one below
    assert brightness(pixel, radiance, (16, 16)).tolist() == [2.0, 2.0, 5.0, 7.0]

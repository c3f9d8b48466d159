"""From how many views on a solution pays, and how far it is from what paths tend to."""

import numpy as np
import pytest

from benchmarks.radiosity.views import break_even, seconds_as_exact, squared_bias


def test_noise_of_pictures_is_no_bias():
    noise = np.random.default_rng(3).normal(0, 1, (4, 100, 100, 3))
    truth, lean = 5.0, 0.5
    biased, exact = [truth + lean + each for each in noise[:2]], [truth + each for each in noise[2:]]
    # A product of such differences deviates by about 2, the mean of 30,000 of them by 0.013.
    assert squared_bias(biased, exact) == pytest.approx(lean**2, abs=0.06)
    assert squared_bias([each - lean for each in biased], exact) < 0.06


def test_noise_and_bias_together_are_as_small_as_the_noise_of_paths():
    assert seconds_as_exact(2.0, error=0.5, bias=0.0, target=1.0) == pytest.approx(1.0)
    assert seconds_as_exact(2.0, error=0.5, bias=0.75, target=1.0) == pytest.approx(4.0)
    assert seconds_as_exact(2.0, error=0.5, bias=1.0, target=1.0) is None


def test_a_solution_pays_from_where_all_its_views_take_less():
    assert break_even(10.0, 1.0, 3.0) == 5
    assert break_even(10.1, 1.0, 3.0) == 6
    assert break_even(10.0, 3.0, 3.0) is None
    assert break_even(10.0, None, 3.0) is None

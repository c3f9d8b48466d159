"""Times that vary by chance: how much, and the sentence where gains at equal time are noise."""

from dataclasses import replace

import numpy as np
import pytest

from study.page.conftest import made_up
from tracer.study.clock import clock_spread, clock_warning
from tracer.study.page.build import build_page
from tracer.study.tables import markdown


def with_times(results, factor):
    """Give each measurement other seconds: its own times ``factor`` of (method, seed)."""
    results.measurements[:] = [
        replace(
            entry, took=replace(entry.took, seconds=entry.took.seconds * factor(entry.cell.method, entry.cell.seed))
        )
        for entry in results.measurements
    ]


def test_slow_methods_and_a_slow_machine_are_no_noise():
    results, _ = made_up(1, 4)
    with_times(results, lambda method, seed: (2 + len(method)) * (3 if seed else 1))
    assert clock_spread(results, "scene 0", "16 spp") == pytest.approx(0, abs=1e-12)
    assert clock_warning(results) is None


def test_the_spread_is_that_of_the_noise():
    generator = np.random.default_rng(3)
    squares = []
    for _ in range(100):
        results, _ = made_up(1, 4)
        with_times(results, lambda method, seed: np.exp(0.2 * generator.standard_normal()))
        squares.append(clock_spread(results, "scene 0", "64 spp") ** 2)
    # Three degrees of freedom each: the mean of 100 has a relative standard error of sqrt(2 / 300).
    assert np.mean(squares) == pytest.approx(0.04, rel=4 * np.sqrt(2 / 300))


def test_one_seed_or_one_method_tell_nothing():
    results, _ = made_up(1, 1)
    assert clock_spread(results, "scene 0", "16 spp") is None
    results, _ = made_up(1, 3)
    results.measurements[:] = [entry for entry in results.measurements if entry.cell.seed == 0]
    assert clock_spread(results, "scene 0", "16 spp") is None
    assert clock_warning(results) is None


def test_page_and_tables_say_where_the_clock_is_noise():
    results, pictures = made_up(5, 3)
    assert "mostly noise" not in markdown(results) + build_page(results, pictures)
    with_times(results, lambda method, seed: 2.0 if (method, seed) == ("fused", 1) else 1.0)
    warning = clock_warning(results)
    assert "mostly noise on scene" in warning
    assert "and 7 more: look at equal samples there" in warning
    assert warning in markdown(results)
    assert warning in build_page(results, pictures)

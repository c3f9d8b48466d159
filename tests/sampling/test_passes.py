"""How rounds are cut into passes."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tracer.sampling.passes import PASS_SIZES, even_pass, next_pass_size


@given(left=st.integers(1, 10**9), size=st.sampled_from(PASS_SIZES))
def test_passes_are_even(left, size):
    taken = even_pass(left, size)
    assert 1 <= taken <= min(left, PASS_SIZES[-1])
    assert taken <= 1.5 * size
    assert taken >= min(left, 0.5 * size)


@pytest.mark.parametrize(("rate", "size"), [(1e4, 0), (1e6, 0), (2e6, 1), (1e8, 2)])
def test_pass_size_follows_the_rate(rate, size):
    assert next_pass_size(rate, 100) == PASS_SIZES[size]


def test_passes_of_many_objects_are_large_at_once():
    assert next_pass_size(None, 100) == PASS_SIZES[1]
    assert next_pass_size(None, 10_000) == next_pass_size(1e4, 10_000) == PASS_SIZES[-1]


def test_no_pass_is_larger_than_the_largest():
    assert even_pass(1000, 900, 400) == 334  # in three, as in two they would have 500

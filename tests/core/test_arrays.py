"""Pixels that are evenly spread over a picture."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tracer.core.arrays import spread_out


@given(st.integers(1, 10**7), st.integers(1, 10**5))
def test_about_so_many_are_picked(size, count):
    picked = len(range(size)[spread_out(size, count)])
    assert min(size, count) / 2 - 1 <= picked <= 2 * min(size, count) + 1 if size >= count else picked == size


@pytest.mark.parametrize("width", [64, 100, 512])
def test_every_column_is_seen(width):
    picked = np.arange(width * width)[spread_out(width * width, width * width // 16)]
    assert len(np.unique(picked % width)) > 0.9 * width

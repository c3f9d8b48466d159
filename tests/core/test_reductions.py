"""Sums on the device, beside those of NumPy, with any number of threads."""

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest

from tracer.core.device import upload
from tracer.core.reductions import BLOCK, largest, running_sum, sums

SIZES = [1, BLOCK - 1, BLOCK, 5 * BLOCK + 7, 100_003]


@pytest.fixture
def threads():
    count = dr.thread_count()
    yield
    dr.set_thread_count(count)


@pytest.mark.parametrize("size", SIZES)
def test_sums_are_those_of_numpy(size):
    values = np.random.default_rng(size).lognormal(0, 3, size)
    found = sums(upload(mi.Float64, values), upload(mi.UInt32, values))
    assert found == pytest.approx([values.sum(), values.astype(np.uint32).sum()], rel=1e-12)
    assert largest(upload(mi.Float64, values)) == values.max()
    assert running_sum(upload(mi.Float64, values)).numpy() == pytest.approx(np.cumsum(values), rel=1e-12)


def test_sums_do_not_depend_on_threads(threads):
    values = upload(mi.Float64, np.random.default_rng(3).lognormal(0, 5, 100_003))
    found = set()
    for count in (1, 2, 3, 5):
        dr.set_thread_count(count)
        found.add((sums(values)[0], running_sum(values).numpy().tobytes()))
    assert len(found) == 1

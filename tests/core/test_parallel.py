"""Work on arrays by several threads gives what one thread would give."""

import threading

import drjit as dr
import numpy as np
import pytest

from tracer.core import parallel

LARGE = (600, 700, 2)
"""Shape of an array that is divided among threads."""


@pytest.mark.parametrize("shape", [(), (1,), (3, 4), (1, 500_000), LARGE, (500_000,)])
def test_a_copy_is_complete_whatever_its_shape(shape):
    source = np.random.default_rng(1).random(shape)
    target = np.full(shape, -1.0, np.float32)
    assert parallel.copy(target, source) is target
    assert np.array_equal(target, source.astype(np.float32))


def test_a_function_gets_the_same_rows_of_all_arrays():
    generator = np.random.default_rng(2)
    first, second = generator.random(LARGE), generator.random(LARGE[:2])
    found = parallel.fill(np.empty(LARGE), lambda a, b: a / (1 + b[..., None]), first, second)
    assert np.array_equal(found, first / (1 + second[..., None]))


def test_the_target_may_be_a_source():
    values = np.random.default_rng(3).random(LARGE)
    before = values.copy()
    parallel.fill(values, np.add, values, before)
    assert np.array_equal(values, before + before)


@pytest.mark.skipif(dr.thread_count() < 2, reason="there is one thread only")
def test_a_large_array_is_worked_on_by_several_threads():
    both_are_here = threading.Barrier(2, timeout=10)

    def meet(rows: np.ndarray) -> np.ndarray:
        both_are_here.wait()
        return rows

    count = dr.thread_count()
    try:
        dr.set_thread_count(2)
        parallel.fill(np.empty(LARGE), meet, np.ones(LARGE))
    finally:
        dr.set_thread_count(count)


def test_an_error_of_the_function_reaches_the_caller():
    def fail(rows: np.ndarray) -> np.ndarray:
        raise ValueError("no")

    with pytest.raises(ValueError, match="no"):
        parallel.fill(np.empty(LARGE), fail, np.ones(LARGE))

"""The model of scaling has the limits that it must have."""

import pytest

from benchmarks.cluster.scaling_model import Constants, speed_up, times

ONLY_DRAWING = Constants(sample=1e-6, unit=0.0, deciding=0.0, developing=0.0, round_bytes=0.0, sums_bytes=0.0)
SOME = Constants(sample=1e-6, unit=8e-3, deciding=1e-6, developing=4e-6, round_bytes=40, sums_bytes=460)


def test_without_anything_else_workers_are_as_fast_as_they_are_many():
    assert times(ONLY_DRAWING, 10**6, 256, 1).total == pytest.approx(256.0)
    assert speed_up(ONLY_DRAWING, 10**7, 4096, [1, 2, 10]) == pytest.approx([1, 2, 10], rel=0.01)


def test_what_the_client_does_alone_bounds_the_speed_up():
    alone = times(SOME, 10**6, 256, 1)
    serial = alone.deciding + alone.network + alone.developing
    found = speed_up(SOME, 10**6, 256, [1, 10, 100, 10000])
    assert found[0] == 1.0
    assert all(faster <= alone.total / serial for faster in found)
    assert found[1] < 10


def test_a_scheduler_that_is_slow_is_waited_for():
    slow = Constants(**{**vars(SOME), "unit": 1.0})
    assert times(slow, 10**6, 256, 1000).scheduling > 0
    assert times(slow, 10**6, 256, 1000).limit in ("scheduling", "drawing")

"""The model of more cores keeps serial seconds and shares out the rest."""

import pytest

from benchmarks.time.scaling import work_of


def test_serial_seconds_stay_and_the_rest_is_shared():
    work = work_of(seconds=4.5, shared=4.0, threads=2)
    assert (work.serial, work.parallel) == (0.5, 8.0)
    assert work.seconds(2) == 4.5
    assert work.seconds(16) == 1.0
    assert work.serial_share(16) == pytest.approx(0.5)

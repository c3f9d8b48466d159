"""The model of more cores keeps serial seconds and shares out the rest."""

import pytest

from benchmarks.time.scaling import work_of


def test_serial_seconds_stay_and_the_rest_is_shared():
    # 1 s alone and 3 s with both threads; 0.5 s alone.
    work = work_of({"seconds_drawing": (4.0, 7.0), "seconds_deciding": (0.5, 0.5)}, 2)
    assert (work.serial, work.parallel) == (1.5, 6.0)
    assert work.seconds(2) == 4.5
    assert work.seconds(12) == 2.0
    assert work.serial_share(12) == pytest.approx(0.75)

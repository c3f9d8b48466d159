"""The model of more cores keeps serial seconds and shares out the rest."""

import pytest

from benchmarks.time.scaling import work_of


def test_serial_seconds_stay_and_the_rest_is_shared():
    # Deciding: 0.5 s alone and 2 s for all threads. Drawing: 6 s for all.
    work = work_of(
        {"seconds_drawing": (3.1, 6.2), "seconds_deciding": (1.5, 3.0)},
        {"seconds_drawing": (6.0, 6.0), "seconds_deciding": (2.5, 2.5)},
        2,
    )
    assert (work.serial, work.parallel) == (0.5, 8.0)
    assert work.seconds(2) == 4.5
    assert work.seconds(16) == 1.0
    assert work.serial_share(16) == pytest.approx(0.5)

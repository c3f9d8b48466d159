"""Names of directions, and texts of values."""

import numpy as np

from tracer.viewpoint.reports.context import name_direction, number


def test_nothing_is_minus_zero():
    assert [number(value) for value in (-0.0, 0.0, -1.5, np.inf)] == ["0", "0", "-1.5", "–"]
    up = np.array([0.0, 0, 1])
    for slightly in (-1e-3, 0.0, 1e-3):
        assert name_direction(np.array([1.0, slightly, slightly]), up) == "0°, +0°"

"""Timings: ratios are what they say, and a real scene is timed every way."""

import pytest

from conftest import LIT
from tracer.study.overhead import Timing, markdown, measure


def test_ratios_are_of_throughput():
    timing = Timing("box", [1.0, 2.0], [2.0, 4.0], [4.0, 8.0], [5.0, 5.0], [0.1, 0.1])
    assert timing.sampler_throughput.mean == pytest.approx(0.5)
    assert timing.uniform_throughput.mean == pytest.approx(0.5)
    assert timing.idle_share.mean == pytest.approx(0.1)
    assert "| box | 1.41 | 2.83 | 5.66 | 5.00 | 0.500" in markdown([timing])


def test_every_way_is_timed(scene_file):
    steps = []
    (timing,) = measure(scene_file(LIT, "lit.xml"), 8, [16], 2, lambda *step: steps.append(step))
    assert timing.scene == "lit"
    for way in ("independent", "owen_sobol", "uniform", "fused", "idle"):
        assert len(getattr(timing, way)) == 2
    assert all(0 < share < 1 for share in timing.idle)
    assert steps[-1][1:] == (12, 12)
    with pytest.raises(KeyboardInterrupt):
        measure(scene_file(LIT), 8, [16], 2, lambda *step: False)

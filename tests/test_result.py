"""What a report says."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import tracer
from tracer.result import histogram


@given(st.lists(st.integers(0, 2**24), min_size=1, max_size=50))
def test_a_histogram_counts_every_pixel_in_its_range(counts):
    found = histogram(np.array([counts], np.uint32))
    assert sum(found.values()) == len(counts)
    for name, number in found.items():
        first, _, last = name.partition("-")
        assert number == sum(int(first) <= count <= int(last or first) for count in counts)


def test_a_report_says_what_became_of_the_pixels(cornell):
    result = tracer.render(cornell(), spp=24, max_spp=32, noise=1e-6)
    report = result.report
    assert report.pixels_at_most == np.count_nonzero(result.samples >= 32) > 0
    assert sum(report.histogram.values()) == result.samples.size
    assert report.noise == pytest.approx(report.as_dict()["noise"])
    assert 0 < report.converged < 1
    assert report.as_dict()["stopped_by"] == "spp"

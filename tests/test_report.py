"""What a report says."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import tracer
from tracer.core.quantities import mean_count
from tracer.io.exr import read_metadata
from tracer.report import histogram
from tracer.result import metadata, write_result


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


def test_what_was_drawn_is_said_and_not_what_could_have_been(cornell, tmp_path):
    result = tracer.render(cornell(), noise=0.2)
    spp = result.samples.mean()
    assert 4 <= spp < 1000
    assert result.report.spp == pytest.approx(spp)
    assert f"<figcaption>{mean_count(spp)} spp, " in result._repr_html_()
    assert "4096" not in result._repr_html_()
    own = metadata(result, "abc")
    assert (own["spp"], own["spp_at_most"]) == (pytest.approx(spp), 4096)
    assert own["report"]["spp"] == own["spp"]
    write_result(tmp_path / "out.exr", result, own)
    assert read_metadata(tmp_path / "out.exr")["spp"] == pytest.approx(spp)


def test_samples_that_only_decide_were_drawn_too(cornell):
    result = tracer.render(cornell(), spp=64, unbiased=True)
    assert result.samples.mean() == 60
    assert result.report.spp == 64


@pytest.mark.parametrize(("settings", "end"), [({"spp": 64}, "of 64"), ({"noise": 1e-6}, "of at most 4096")])
def test_a_render_that_was_stopped_says_after_what(cornell, settings, end):
    result = tracer.render(cornell(), progress=lambda now: now.done < 8 * 384, **settings)
    assert result.report.notes[-1] == f"Stopped after {mean_count(result.samples.mean())} samples per pixel, {end}."


def test_a_round_that_was_cut_short_counts_in_the_noise(cornell, monkeypatch):
    """Stopped in the middle of a round, the noise is that of the picture and not of the last whole round."""
    monkeypatch.setattr("tracer.sampling.passes.PASS_SIZES", (2000, 2000, 2000))
    monkeypatch.setattr("tracer.session.local_drawer.PASS_SIZES", (2000, 2000, 2000))
    said = []

    def look(now):
        said.append(now.noise)
        return now.done < 100 * 384

    result = tracer.render(cornell(), noise=1e-6, spp=256, criterion="uniform", progress=look)
    assert 64 < result.report.spp < 128
    assert result.report.noise < 0.95 * said[-2]


def test_there_is_no_noise_in_a_report_without_a_target(cornell):
    pytest.importorskip("mitsuba_oidn")
    result = tracer.render(cornell(), spp=16, denoise=True)
    assert (result.report.noise, result.report.converged) == (None, None)

"""Plain ``mi.render`` with Open Image Denoise, as others would do it."""

from contextlib import ExitStack

import numpy as np
import pytest

from conftest import small_scene
from tracer.errors import DenoiseError
from tracer.image import metrics
from tracer.study.methods import Setting, Studio


@pytest.fixture(scope="module")
def studio():
    with ExitStack() as stack:
        yield Studio(stack, Setting(small_scene((64, 64), "box")), ["multijitter"])


def test_stock_pictures_are_denoised_with_the_same_samples(studio):
    pytest.importorskip("mitsuba_oidn")
    reference = studio.stock("multijitter")(1024, 9).image
    noisy, denoised = (studio.stock("multijitter", denoise)(16, 1) for denoise in (False, True))
    assert denoised.samples == noisy.samples
    assert denoised.image.shape == noisy.image.shape
    assert metrics.relative_mse(denoised.image, reference) < metrics.relative_mse(noisy.image, reference) / 2
    assert denoised.seconds > denoised.seconds_drawing
    again = studio.stock("multijitter")(16, 1)  # the pass for albedo and normal leaves nothing behind
    assert np.array_equal(again.image, noisy.image)


def test_without_a_denoiser_it_is_said_at_once(studio, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "mitsuba_oidn", None)
    with pytest.raises(DenoiseError, match="mitsuba-oidn"):
        studio.stock("multijitter", True)

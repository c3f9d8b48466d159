"""The noise of a picture: what quantiles of normal errors say, and errors that standard errors do not know of."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

import tracer
from tracer.frame import PlainFrame
from tracer.noise import NoiseMeter, bound, within
from tracer.settings import make_settings

FRAME = PlainFrame((96, 128), 0, ["R", "G", "B"], 0, (0, 0, 128, 96))
ABSOLUTE = make_settings(noise=0.1, objective="absolute")


@given(st.floats(1e-6, 1e6), st.floats(0.05, 0.99))
def test_a_bound_is_the_quantile_of_a_normal_error(deviation, share):
    expected = deviation * stats.norm.ppf(0.5 + share / 2)
    assert bound(np.full(5, deviation), share) == pytest.approx(expected, rel=1e-6)
    assert within(np.full(5, deviation), expected) == pytest.approx(share, rel=1e-6)


def test_a_bound_of_many_deviations_is_the_quantile_of_their_errors():
    random = np.random.default_rng(1)
    deviation = random.lognormal(0, 2, 400_000)
    errors = abs(random.normal(0, deviation))
    for share in (0.5, 0.9, 0.95):
        assert bound(deviation, share) == pytest.approx(np.quantile(errors, share), rel=0.02)


def test_pictures_without_noise():
    assert bound(np.zeros(9), 0.95) == 0
    assert bound(np.array([0.0, np.inf]), 0.95) == np.inf


def picture(random, truth, deviation, count):
    return (truth + deviation / np.sqrt(count)[..., None] * random.normal(size=(*FRAME.size, 3))).astype(np.float32)


@pytest.mark.parametrize("misjudged", [0.5, 1.0, 2.5])
def test_how_far_a_picture_moves_corrects_its_standard_errors(misjudged):
    """Means of 8, then 16, then 32 samples; standard errors say ``misjudged`` times what is true."""
    random = np.random.default_rng(2)
    truth, deviation = random.random((*FRAME.size, 1)), random.lognormal(-1, 1, (*FRAME.size, 1))
    meter, samples = NoiseMeter(), [deviation * random.normal(size=(*FRAME.size, 3)) / np.sqrt(8) for _ in range(4)]
    for rounds in (1, 2, 4):
        image = (truth + np.mean(samples[:rounds], axis=0)).astype(np.float32)
        count = np.full(FRAME.size, 8 * rounds, np.uint32)
        stderr = np.broadcast_to(misjudged * deviation / np.sqrt(8 * rounds), image.shape).astype(np.float32)
        meter.follow(FRAME, ABSOLUTE, image, stderr, count)
    found = meter.look(FRAME, ABSOLUTE, image, stderr)
    error = np.sqrt(np.mean((image - truth) ** 2, axis=-1))
    # Three channels that err independently: less spread than the one normal error that is assumed.
    assert found.error == pytest.approx(np.quantile(error, 0.95), rel=0.15)
    assert found.measured
    assert found.needed == pytest.approx((found.error / 0.1) ** 2)


def test_pixels_that_do_not_matter_do_not_count():
    image, stderr = np.ones((2, *FRAME.size, 3), np.float32)
    stderr[:48] = 0.1
    counted = np.zeros(FRAME.size, bool)
    counted[:48] = True
    every, some = (NoiseMeter(counted=each).look(FRAME, ABSOLUTE, image, stderr) for each in (None, counted))
    assert some.error == pytest.approx(0.1 * stats.norm.ppf(0.975), rel=1e-6)
    assert every.error > 5 * some.error


def test_rare_light_that_is_being_discovered_is_expected_to_go_on():
    meter = NoiseMeter(factor=0.2)
    image = np.zeros((*FRAME.size, 3), np.float32)
    stderr = np.ones_like(image)
    meter.image, meter.count = image + np.float32(0.5), np.full(FRAME.size, 4, np.uint32)
    meter.follow(FRAME, ABSOLUTE, image, stderr, np.full(FRAME.size, 8, np.uint32))
    assert meter.scale > 1.2 * meter.factor


def test_a_render_stops_when_its_noise_is_low_enough(cornell):
    settings = {"size": 48, "seed": 1}
    rough, fine = (tracer.render(cornell(), noise=noise, **settings) for noise in (0.2, 0.05))
    for result, noise in ((rough, 0.2), (fine, 0.05)):
        assert result.report.stopped_by == "noise"
        assert result.report.noise <= noise
        assert result.report.converged >= 0.95
    assert rough.samples.mean() < 0.5 * fine.samples.mean()
    stopped = tracer.render(cornell(), noise=0.001, spp=16, **settings)
    assert stopped.report.stopped_by == "spp"
    assert stopped.report.converged < 0.9
    assert 1 - stopped.report.converged > 0.05

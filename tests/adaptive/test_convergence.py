"""The noise of a picture: what quantiles of normal errors say, and errors that standard errors do not know of."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

import tracer
from tracer.adaptive.convergence import NoiseMeter, bound, errors, on_screen, seen, within
from tracer.image import objective
from tracer.image.colour import encode_srgb, luminance
from tracer.scene.frame import PlainFrame
from tracer.settings import make_settings

FRAME = PlainFrame((96, 128), 0, ["R", "G", "B"], 0, (0, 0, 128, 96))
ABSOLUTE = make_settings(noise=0.1, objective="absolute")


@given(st.floats(1e-6, 1e6), st.one_of(st.floats(0.05, 0.99), st.just(0.9999)))
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


def test_a_short_round_is_measured_together_with_the_next():
    """From 16 to 17 samples a few pixels move; what was known of the others stays, until there is more to see."""
    random = np.random.default_rng(7)
    samples = [random.normal(size=(*FRAME.size, 3)) for _ in range(32)]

    def follow(meter, *counts):
        for count in counts:
            image = np.mean(samples[:count], axis=0).astype(np.float32)
            stderr = np.full(image.shape, 1 / np.sqrt(count), np.float32)
            meter.follow(FRAME, ABSOLUTE, image, stderr, np.full(FRAME.size, count, np.uint32))
        return meter

    meter = follow(NoiseMeter(), 8, 16)
    image, factor, scale = meter.image, meter.factor, meter.scale
    still = image.copy()
    still[0] += 0.01  # one row in 96 has moved
    meter.follow(FRAME, ABSOLUTE, still, np.full_like(image, 0.25), np.full(FRAME.size, 17, np.uint32))
    assert (meter.factor, meter.scale) == (factor, scale)
    assert meter.image is image
    assert follow(meter, 17, 32).factor == pytest.approx(factor, rel=0.1)


def test_rare_light_that_is_being_discovered_is_expected_to_go_on():
    meter = NoiseMeter(factor=0.2)
    image = np.zeros((*FRAME.size, 3), np.float32)
    stderr = np.ones_like(image)
    meter.image, meter.count = image + np.float32(0.5), np.full(FRAME.size, 4, np.uint32)
    meter.follow(FRAME, ABSOLUTE, image, stderr, np.full(FRAME.size, 8, np.uint32))
    assert meter.scale > 1.2 * meter.factor


@pytest.mark.parametrize(("trend", "least", "most"), [(0.5, 1.0, 1.0), (1.2, 1.21, 1.44), (5.0, 2.0, 2.0)])
def test_a_rise_goes_on_a_bit_faster_but_not_to_more_than_twice_as_much(trend, least, most):
    random = np.random.default_rng(4)
    before = np.zeros((*FRAME.size, 3), np.float32)
    count = np.full(FRAME.size, 4, np.uint32)
    image = (before + random.normal(size=before.shape)).astype(np.float32)
    meter = NoiseMeter(before, count)
    meter.follow(FRAME, ABSOLUTE, image, np.ones_like(image), 2 * count)
    again = NoiseMeter(before, count, factor=meter.factor / trend)
    again.follow(FRAME, ABSOLUTE, image, np.ones_like(image), 2 * count)
    assert least - 1e-9 <= again.scale / meter.factor <= most + 1e-9


def mean_of_neighbours(values):
    """Return the mean of 3 x 3 neighbours, the edge repeated."""
    padded = np.pad(values.astype(np.float64), 1, mode="edge")
    height, width = values.shape
    return sum(padded[r : r + height, c : c + width] for r in range(3) for c in range(3)) / 9


def test_moves_are_weighed_by_the_objective_and_predicted_from_the_counts_around():
    """A picture that is three times as dense as before, more or less from pixel to pixel."""
    random = np.random.default_rng(5)
    frame = PlainFrame(FRAME.size, 0, ["R", "G", "B", "depth.T"], 1, FRAME.window)
    settings = make_settings(objective="relative", noise_share=0.8)
    old, new, stderr = (random.lognormal(0, 1, (*FRAME.size, 4)).astype(np.float32) for _ in range(3))
    for each in (old, new, stderr):
        each[..., 3] *= 100  # AOVs do not count
    counts = [random.integers(1, 9, FRAME.size).astype(np.uint32)]
    counts.append(counts[0] + random.integers(0, 30, FRAME.size).astype(np.uint32))
    root = 1 / np.sqrt((new[..., :3] @ [0.2126, 0.7152, 0.0722]) ** 2 + 0.01)
    moved = root * np.sqrt(((new - old)[..., :3].astype(np.float64) ** 2).mean(axis=-1))
    deviation = root * np.sqrt((stderr[..., :3].astype(np.float64) ** 2).mean(axis=-1))
    growth = mean_of_neighbours(counts[1]) / mean_of_neighbours(counts[0]) - 1
    errors = abs(deviation * np.sqrt(growth) * random.normal(size=(200, *FRAME.size)))
    meter = NoiseMeter(old, counts[0])
    meter.follow(frame, settings, new, stderr, counts[1])
    # 2.5 million errors: their quantile is known to 0.1 %
    assert meter.factor == pytest.approx(np.quantile(moved, 0.8) / np.quantile(errors, 0.8), rel=5e-3)
    found = NoiseMeter().look(frame, settings, new, stderr)
    errors = abs(deviation * random.normal(size=(200, *FRAME.size)))
    assert found.error == pytest.approx(np.quantile(errors, 0.8), rel=5e-3)
    plain = PlainFrame(FRAME.size, 0, ["R", "G", "B"], 1, FRAME.window)
    target = make_settings(objective="relative", noise_share=0.8, noise=0.1)
    found = NoiseMeter().look(plain, target, new[..., :3], stderr[..., :3])
    assert found.converged == pytest.approx((errors < 0.1).mean(), abs=2e-3)


def test_a_target_that_is_met_needs_no_more():
    image, stderr = np.ones((*FRAME.size, 3), np.float32), np.full((*FRAME.size, 3), 1e-3, np.float32)
    assert NoiseMeter().look(FRAME, ABSOLUTE, image, stderr).needed == 1


def test_of_a_large_picture_all_columns_are_looked_at():
    """2^18 pixels are four times as many as are looked at."""
    columns = np.tile(np.arange(512.0), (512, 1))
    assert set(NoiseMeter().some(columns)) == set(range(512))


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


@given(st.floats(0, 3), st.floats(1e-6, 3))
def test_an_error_on_the_screen_is_that_of_the_curve_and_of_what_it_clips(middle, deviation):
    expected = np.mean([(encode_srgb(middle + sign * deviation) - encode_srgb(middle)) ** 2 for sign in (-1, 1)]) ** 0.5
    found = float(on_screen(np.array(middle), np.array(deviation)))
    assert found == pytest.approx(expected, abs=1e-9)
    assert found <= 1
    if deviation < 0.01 * middle < 0.0095:
        slope = objective.weights("display", middle) ** 0.5
        assert found == pytest.approx(slope * deviation, rel=0.01)


def walk(settings, scale):
    """Return what a meter says of a picture whose light is multiplied by ``scale``, after two rounds."""
    random, meter = np.random.default_rng(5), NoiseMeter()
    truth = random.random((*FRAME.size, 3)) * 1.3
    for count in (8, 16):
        stderr = (0.3 * truth / np.sqrt(count) * scale).astype(np.float32)
        image = ((truth * scale) + stderr * random.normal(size=truth.shape)).astype(np.float32)
        meter.follow(FRAME, settings, image, stderr, np.full(FRAME.size, count, np.uint32))
    return meter.look(FRAME, settings, image, stderr)


@pytest.mark.parametrize("name", objective.OBJECTIVES)
@pytest.mark.parametrize("stops", [-6, 3, 13, 40])
def test_half_the_light_at_one_stop_more_has_the_same_noise(name, stops):
    bright = walk(make_settings(noise=0.05, objective=name), 1.0)
    dark = walk(make_settings(noise=0.05, objective=name, exposure=stops), 2.0**-stops)
    assert dark.error == pytest.approx(bright.error, rel=1e-4)
    assert dark.converged == pytest.approx(bright.converged, rel=1e-4)
    assert dark.needed == pytest.approx(bright.needed, rel=1e-3)


@pytest.mark.parametrize("name", objective.OBJECTIVES)
@pytest.mark.parametrize("exposure", [-3.0, 0.0, 3.0])
def test_an_error_is_seen_as_it_is_measured(name, exposure):
    """Normal errors of known deviation: the root mean square that is said, against that of the definition."""
    random = np.random.default_rng(6)
    radiance = np.repeat(np.array([0.01, 0.1, 0.3, 2.0]) * 2**-exposure, 100_000)
    deviation = 0.1 * radiance
    shown = (radiance + deviation * random.normal(size=radiance.shape)) * 2**exposure
    right = radiance * 2**exposure
    measured = {
        "absolute": shown - right,
        "display": encode_srgb(shown) - encode_srgb(right),
    }.get(name, (shown - right) / np.sqrt(right**2 + 0.01))
    root = np.sqrt(np.mean(measured.reshape(4, -1) ** 2, axis=1))
    said = seen(name, exposure, radiance, deviation).reshape(4, -1)[:, 0]
    assert said == pytest.approx(root, rel=0.03, abs=1e-6)


def test_alpha_counts_as_cover_beside_the_colours():
    frame = PlainFrame((1, 3), 0, ["R", "G", "B", "A", "depth.T"], 0, (0, 0, 3, 1))
    image = np.ones((1, 3, 5), np.float32)
    deviation = np.zeros((1, 3, 5), np.float32)
    deviation[0, 0, :3], deviation[0, 1, 3], deviation[0, 2, 4] = 0.2, -0.3, 9.0  # colour, alpha, an AOV
    for exposure in (0.0, 3.0):
        settings = make_settings(noise=0.1, objective="absolute", exposure=exposure)
        assert errors(frame, settings, image, deviation) == pytest.approx(np.array([[0.2 * 2**exposure, 0.3, 0.0]]))


def fence():
    """Return a scene of black slats before nothing: black everywhere, and alpha at their edges."""
    import mitsuba as mi

    up = mi.ScalarTransform4f()
    slats = {
        f"slat{k}": {
            "type": "rectangle",
            "to_world": up.rotate([0, 0, 1], 8).translate([k / 4, 0, 0]).scale([0.06, 3, 1]),
            "bsdf": {"type": "diffuse", "reflectance": 0.0},
        }
        for k in range(-6, 7)
    }
    film = {"type": "hdrfilm", "width": 32, "height": 32, "pixel_format": "rgba"}
    camera = up.look_at([0, 0, 4], [0, 0, 0], [0, 1, 0])
    sensor = {"type": "perspective", "fov": 35, "to_world": camera, "film": film}
    return {"type": "scene", "integrator": {"type": "path"}, "sensor": sensor, **slats}


def test_a_picture_in_which_only_alpha_varies_is_rendered_until_alpha_is_known():
    reference = tracer.render(fence(), spp=1024, criterion="uniform", seed=9).image
    assert reference[..., :3].max() == 0
    result = tracer.render(fence(), noise=0.01, spp=1024, seed=1)
    error = np.quantile(abs(result.image - reference)[..., 3], 0.95)
    assert result.report.stopped_by == "noise"
    assert result.samples.mean() > 16
    assert error <= result.report.noise <= 0.01


def dim(scene, stops):
    """Return a Cornell box whose lamp is weaker by some stops."""
    radiance = scene["light"]["emitter"]["radiance"]
    scene["light"]["emitter"]["radiance"] = radiance | {"value": [value * 2.0**-stops for value in radiance["value"]]}
    return scene


@pytest.mark.parametrize("name", objective.OBJECTIVES[:3])
def test_a_dark_scene_brightened_is_the_bright_one(cornell, name):
    settings = {"size": 32, "seed": 1, "noise": 0.06, "spp": 256, "objective": name}
    bright = tracer.render(cornell(), **settings)
    dark = tracer.render(dim(cornell(), 13), exposure=13, **settings)
    assert dark.image * 2**13 == pytest.approx(bright.image, rel=1e-3, abs=1e-4)
    assert np.array_equal(dark.samples, bright.samples)
    assert dark.report.noise == pytest.approx(bright.report.noise, rel=1e-3)


@pytest.fixture(scope="module")
def cornell_reference():
    """Return a Cornell box and the picture of many samples of it."""
    import mitsuba as mi

    scene = mi.cornell_box()
    scene["sensor"]["film"] |= {"width": 48, "height": 48}
    return scene, tracer.render(scene, spp=8192, criterion="uniform", seed=99).image


@pytest.mark.slow
@pytest.mark.parametrize("exposure", [-3.0, 0.0, 3.0])
@pytest.mark.parametrize("name", objective.OBJECTIVES)
def test_as_many_pixels_as_are_said_keep_within_what_is_said(cornell_reference, name, exposure):
    """What is said is an estimate: the median of five seeds is to be four fifths of what is measured, or more."""
    shown = {"objective": name, "exposure": exposure}
    scene, radiance = cornell_reference
    reference = radiance * 2**exposure
    target = 0.05 * (2**exposure if name == "absolute" else 1)
    ratios = []
    for seed in range(5):
        result = tracer.render(scene, noise=target, spp=512, seed=seed, **shown)
        image = result.image * 2**exposure
        if name == "display":
            error = np.sqrt(np.mean((encode_srgb(image) - encode_srgb(reference)) ** 2, axis=-1))
        else:
            error = np.sqrt(np.mean((image - reference) ** 2, axis=-1))
            error /= 1.0 if name == "absolute" else np.sqrt(luminance(reference) ** 2 + 0.01)
        ratios.append(result.report.noise / np.quantile(error, 0.95))
    assert np.median(ratios) > 0.8, ratios

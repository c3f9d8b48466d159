"""The estimate from random rays: it converges, and says how far it is off."""

import mitsuba as mi
import numpy as np
import pytest
from scipy import stats

from tracer.core import sphere
from tracer.viewpoint.fast import estimate, estimate_entropy, grassberger
from tracer.viewpoint.item_buffer import Rays, around, at
from tracer.viewpoint.lens import Orthographic, Perspective, WholeSphere
from tracer.viewpoint.surfaces import open_subject
from tracer.viewpoint.survey import survey


@pytest.fixture(scope="module")
def subject():
    """Return 60 small spheres in a cloud."""
    generator = np.random.default_rng(4)
    balls = {
        f"ball{k}": {"type": "sphere", "center": centre.tolist(), "radius": 0.12}
        for k, centre in enumerate(generator.uniform(-1, 1, (60, 3)))
    }
    return open_subject(mi.load_dict({"type": "scene", **balls}))


@pytest.mark.slow
@pytest.mark.parametrize("background", [True, False])
@pytest.mark.parametrize("lens", [Orthographic(1.6), Perspective(60), WholeSphere()])
def test_standard_errors_cover(subject, lens, background):
    # 200 estimates of one view; 3.3 standard errors in all, false alarms 1 in 1000 for each of the three statements.
    place = np.array([[0.1, 0.2, 2.5]])
    view = at(place) if lens.wraps else around(subject.centre, 2.5, sphere.normalised([[1.0, 2.0, 3.0]]))
    truth = survey(subject, view, lens, Rays(side=1200), ["entropy"], background=background)["entropy"][0]
    rays = 40000 if lens.wraps else 4000  # of which 1 in 20 hits
    found = [estimate_entropy(subject, view, lens, rays, seed, background) for seed in range(200)]
    entropy = np.array([one.entropy[0] for one in found])
    stderr = np.array([one.stderr[0] for one in found])
    assert abs(entropy.mean() - truth) < 3.3 * entropy.std() / np.sqrt(200) + 2e-3  # the grid's own error
    covered = np.count_nonzero(np.abs(entropy - truth) < 1.96 * stderr)
    least, most = stats.binom.ppf([5e-4, 1 - 5e-4], 200, 0.95)
    assert covered >= least
    assert covered <= most


def test_the_error_falls_with_the_square_root_of_the_rays(subject):
    views = around(subject.centre, 4, sphere.evenly(40))
    lens = Orthographic(1.6)
    truth = survey(subject, views, lens, Rays(side=1200), ["entropy"])["entropy"]
    numbers = np.array([250, 1000, 4000, 16000])
    errors = []
    for rays in numbers:
        found = [estimate_entropy(subject, views, lens, int(rays), seed).entropy - truth for seed in range(10)]
        errors.append(np.sqrt(np.mean(np.square(found))))
    slope = np.polyfit(np.log(numbers), np.log(errors), 1)[0]
    assert slope == pytest.approx(-0.5, abs=0.06)


@pytest.mark.slow
def test_the_correction_removes_the_bias_of_few_rays(subject):
    view = around(subject.centre, 4, sphere.normalised([[1.0, 2.0, 3.0]]))
    lens = Orthographic(1.6)
    truth = survey(subject, view, lens, Rays(side=1200), ["entropy"])["entropy"][0]
    found = [estimate_entropy(subject, view, lens, 300, seed) for seed in range(400)]
    uncorrected = np.mean([one.uncorrected[0] for one in found]) - truth
    corrected = np.mean([one.entropy[0] for one in found]) - truth
    assert uncorrected < -0.05
    assert abs(corrected) < 0.25 * abs(uncorrected)


def test_shares_of_two_by_hand():
    _, stderr, uncorrected, once = estimate(np.array([3.0, 1.0, 0.0]), 100)
    assert once == 0
    assert uncorrected == pytest.approx(2 - 0.75 * np.log2(3))
    assert stderr == pytest.approx(np.sqrt(0.75 * 0.25) * np.log2(3) / 10)


@pytest.mark.parametrize("rays", [20, 100])
def test_the_expected_estimate_of_two_shares_is_their_entropy(rays):
    counts = np.arange(rays + 1)
    weights = stats.binom.pmf(counts, rays, 0.75)
    found = [grassberger(np.array([n, rays - n])) for n in counts]
    # The number of rays is taken to be random too: 1 / (2 N) nats.
    assert weights @ found == pytest.approx(2 - 0.75 * np.log2(3), abs=0.6 / (rays * np.log(2)))


def test_surfaces_that_one_ray_hit_make_the_error_larger():
    corrected, stderr, uncorrected, once = estimate(np.ones(50), 50)
    assert once == 1
    assert uncorrected == pytest.approx(np.log2(50))
    assert stderr == pytest.approx(corrected - uncorrected)
    assert stderr > 0.3


def test_a_view_of_nothing(subject):
    views = at(np.array([[0.0, 0.0, 50.0]]))
    lens = Orthographic(1)
    away = around(np.array([50.0, 50.0, 50.0]), 1, np.eye(3)[:1])
    for background in (True, False):
        found = estimate_entropy(subject, away, lens, 100, background=background)
        assert (found.entropy, found.stderr) == (0, 0)
    assert estimate_entropy(subject, views, WholeSphere(), 100).entropy >= 0


VIEWS_OF_A_CUBE = sphere.normalised([[0.0, 0, 1], [1, 0, 1], [1, 1, 1]])


def test_one_surface_has_no_entropy_and_is_seen(quads):
    cube = open_subject(quads, "shape")
    views = around(cube.centre, 3, VIEWS_OF_A_CUBE)
    found = estimate_entropy(cube, views, Orthographic(1), 4001, background=False)
    assert found.entropy == pytest.approx([0, 1, np.log2(3)], abs=5e-3)  # H of equal shares falls by their variance
    assert (found.entropy[0], found.stderr[0]) == (0, 0)
    projected = VIEWS_OF_A_CUBE.sum(axis=1) / 4  # a convex body, edge 1, in an image of 2 x 2
    errors = np.sqrt(projected * (1 - projected) / 4001)
    assert np.all(np.abs(found.covered - projected) < 3.3 * errors)  # of three, false alarms 3 in 1000
    away = around(np.array([50.0, 50, 50]), 1, np.eye(3)[:1])
    assert estimate_entropy(cube, away, Orthographic(1), 100).covered == 0

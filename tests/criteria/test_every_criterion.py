"""What holds for all of them."""

import dataclasses

import mitsuba as mi
import numpy as np
import pytest

import tracer
from tracer import criteria
from tracer.criteria import registry
from tracer.sampling.samples import draw
from tracer.scene.view import open_scene
from tracer.session.render import render_request
from tracer.session.request import Request

from .made_up import evidence_of, light, statistics_of

NAMES = criteria.names()
LEARNING = [name for name in NAMES if criteria.get(name).needs_radiance]


@pytest.mark.parametrize("name", NAMES)
def test_it_spends_the_budget_exactly(cornell, name):
    result = tracer.render(cornell(), criterion=name, spp=16)
    assert result.samples.sum(dtype=int) == 16 * 24 * 16
    assert result.samples.min() >= 1
    assert np.all(np.isfinite(result.image))
    assert (np.ptp(result.samples) == 0) == (name == "uniform")


@pytest.mark.parametrize("name", ["cycles", "root_hellinger", "luxcore", "rigau"])
def test_it_can_be_held_out(cornell, name):
    result = tracer.render(cornell(pixel_format="luminance_alpha"), criterion=name, spp=40, pilot_spp=4, unbiased=True)
    assert result.samples.sum(dtype=int) == 32 * 24 * 16


class Flat:
    """What pilot rays see where there is nothing."""

    def __init__(self, grid):
        self.grid = grid
        self.same_shape = self.same_face = np.full((*grid, 4), 4)

    def __getattr__(self, name):
        return np.zeros(self.grid)


WITHIN_RANGE = ("fused", "variance")
"""They take what float32 can square."""


def hard_cases(channels, most):
    """Return samples (N, H, W, C + 1), the last channel alpha: black, one sample, spikes, negative, huge, equal."""
    cases = {n: light(n, 12, 12, channels, seed=n) for n in (1, 2, 5)}
    cases |= {"black": np.zeros((4, 12, 12, channels)), "equal": np.full((4, 12, 12, channels), 0.3)}
    spike = light(4, 12, 12, channels)
    spike[0, 5, 5] = most
    spike[1, 6, 6] = -1
    spike[:, 7:, 7:] = 0
    spike[:, 3, 3] = 1e-38
    cases["spike"] = spike
    return {key: np.concatenate([each, np.ones((*each.shape[:3], 1))], axis=-1) for key, each in cases.items()}


@pytest.mark.parametrize("channels", [1, 3])
@pytest.mark.parametrize("name", LEARNING)
def test_importance_is_finite_and_not_negative(name, channels):
    for key, samples in hard_cases(channels, 1e15 if name in WITHIN_RANGE else 1e30).items():
        known = statistics_of(samples, name, channels)
        before = statistics_of(0.5 * samples[: max(len(samples) // 2, 1)], name, channels)
        before.count[:] = np.maximum(known.count // 2, 1)
        known.count[1, 1] = before.count[1, 1] = 0
        for array in (known.mean, known.variance, known.moments):
            array[1, 1] = 0
        known.peaks[1, 1] = -np.inf
        for past in (None, before):
            evidence = evidence_of(known, past, channels, look=lambda: Flat((12, 12)))
            with np.errstate(all="ignore"):
                values = criteria.get(name).importance(evidence)
            assert values.shape == (12, 12), key
            assert np.all(np.isfinite(values) & (values >= 0)), key


@pytest.mark.parametrize("name", LEARNING)
def test_alpha_and_aovs_do_not_matter(name):
    samples = light(8, 12, 12, 5)
    others = samples.copy()
    others[..., 3:] = 7 * others[::-1, ..., 3:] + 1
    found = []
    for each in (samples, others):
        known, before = (statistics_of(part, name) for part in (each, each[:4]))
        evidence = evidence_of(known, before, look=lambda: Flat((12, 12)))
        found.append(criteria.get(name).importance(evidence))
    assert np.array_equal(*found)


MOMENTS = [name for name in LEARNING if criteria.get(name).moments is not None]


@pytest.mark.parametrize("name", MOMENTS)
def test_sums_of_a_render_are_those_of_its_samples(cornell, monkeypatch, name):
    """The first 4 samples of every pixel, drawn again one by one, give the importance of the first decision."""
    seen = []
    rule = criteria.get(name)

    def spy(evidence):
        seen.append(evidence)
        return rule.importance(evidence)

    monkeypatch.setitem(registry.registered, name, dataclasses.replace(rule, importance=spy))
    with open_scene(cornell()) as view:
        render_request(Request(view, {"criterion": name, "spp": 16, "pilot_spp": 4, "seed": 3}))
        pixel = mi.UInt32(np.arange(view.pixel_count, dtype=np.uint32))
        sampler = mi.load_dict({"type": "owen_sobol"})
        samples = []
        for index in range(4):
            drawn = draw(view, sampler, mi.UInt32(3), pixel, mi.UInt32(index) + pixel * 0, mi.Float(16**-0.5))
            samples.append(np.stack([np.array(each).reshape(view.grid) for each in drawn.values], axis=-1))
    known = statistics_of(samples, name)
    expected = rule.importance(evidence_of(known, look=seen[0].look))
    found = rule.importance(seen[0])
    assert found == pytest.approx(expected, rel=2e-3, abs=1e-4 * expected.max())
    assert expected.max() > 0

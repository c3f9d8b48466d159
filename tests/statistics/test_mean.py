"""What samples that decide and are averaged lose of the mean is given back; with ``unbiased`` nothing is lost."""

import mitsuba as mi
import numpy as np
import pytest
from scipy import stats

import tracer
from conformance.cases import scene

SEEDS = 400
LIMIT = stats.norm.ppf(1 - 0.001 / 2)
"""|z| that a correct estimate exceeds once in a thousand times."""


def brightness(loaded, **settings):
    """Return the mean of the picture for every seed."""
    pictures = (tracer.render(loaded, spp=8, pilot_spp=2, seed=seed, **settings).image for seed in range(SEEDS))
    return np.array([picture.mean(dtype=np.float64) for picture in pictures])


@pytest.mark.slow
def test_the_mean_at_eight_samples(monkeypatch):
    """Pixels that look dark by chance get fewer samples, and so stay dark; eight samples are adapted for this test."""
    monkeypatch.setattr("tracer.adaptive.allocation.predicted_overhead", lambda *_: -1.0)
    loaded = mi.load_dict(scene("path", filter_name="box"))
    truth = np.array(mi.render(loaded, spp=1 << 15, seed=10**6)).mean(dtype=np.float64)

    def error(**settings):
        found = brightness(loaded, min_spp=1, **settings)
        spread = found.std(ddof=1) / np.sqrt(SEEDS)
        print(f"{settings}: {found.mean() / truth - 1:+.3%} of the picture, z = {(found.mean() - truth) / spread:+.1f}")
        return found.mean() - truth, spread

    for settings in ({"criterion": "variance"}, {"criterion": "fused"}, {"criterion": "fused", "unbiased": True}):
        off, spread = error(**settings)
        assert abs(off) < LIMIT * spread, settings
    monkeypatch.setattr("tracer.film.bias.MOST", 0.0)  # nothing is given back
    off, spread = error(criterion="variance")
    assert off < -LIMIT * spread

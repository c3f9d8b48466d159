"""The standard error of a pixel is about as large as its true error."""

from importlib.resources import files

import numpy as np
import pytest

import tracer
from tracer.source import load

SCENES = ("thin_rods", "horizon", "spheres_and_rods", "glass_caustic", "window_interior", "many_lights")
SCENES += ("depth_of_field", "even_noise")


@pytest.mark.slow
@pytest.mark.parametrize("name", SCENES)
def test_errors_are_covered(name):
    loaded = load(str(files("tracer.scenes") / f"{name}.xml"))
    truth = tracer.render(loaded, size=48, spp=1 << 14, seed=10**6, criterion="uniform").image
    for spp in (16, 64, 256):
        ratios = []
        for seed in range(2):
            found = tracer.render(loaded, size=48, spp=spp, seed=seed)
            known = found.stderr > 1e-6 * np.maximum(found.image, 1e-3)
            ratios.append(((found.image - truth) / np.where(known, found.stderr, np.inf))[known])
        rms = float(np.sqrt(np.mean(np.concatenate(ratios) ** 2)))
        print(f"{name}, {spp} spp: RMS of error / standard error {rms:.2f}")
        assert 0.5 <= rms <= 1.2, spp

"""Run the comparison with ``mi.render`` under another variant: ``python -m conformance.variant NAME``."""

import sys

import numpy as np

import tracer

tracer.activate(sys.argv[1])

import mitsuba as mi  # noqa: E402

from conformance.cases import mitsuba_picture, scene  # noqa: E402

for case in ({}, {"integrator": "path", "film": "rgba"}, {"integrator": "volpath"}, {"integrator": "prb"}):
    try:
        loaded = mi.load_dict(scene(**case))
        expected = np.array(mitsuba_picture(loaded, 3, 16))
    except Exception as error:
        if "olariz" not in str(error):  # what Mitsuba itself cannot polarize is no concern here
            raise
        continue
    found = tracer.render(loaded, spp=16, seed=3, criterion="uniform")
    assert found.image.shape == expected.shape, (case, found.image.shape, expected.shape)
    difference = np.abs(found.image - expected).max()
    assert difference < 1e-3 * max(1, np.abs(expected).max()), (case, difference)
    assert expected.mean() > 0.05
    adaptive = tracer.render(loaded, spp=32, seed=4)
    assert adaptive.report.complete
    assert abs(adaptive.image.mean() / expected.mean() - 1) < 0.05, (case, adaptive.image.mean(), expected.mean())

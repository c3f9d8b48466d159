"""What a frame computes on the device is what it computes on the host."""

import numpy as np
import pytest

from tracer.scene.frame import PlainFrame


@pytest.mark.parametrize("channels", [["R", "G", "B", "A"], ["X", "Y", "Z"], ["Y", "A"], ["Y"]])
def test_luminance_is_the_same_on_the_device(channels):
    image = np.random.default_rng(1).lognormal(size=(3, 5, len(channels))).astype(np.float32)
    frame = PlainFrame((3, 5), 0, channels, 0, (0, 0, 5, 3))
    found = frame.luminance_on_device(image).numpy().reshape(3, 5)
    assert found == pytest.approx(frame.luminance(image), rel=1e-6)

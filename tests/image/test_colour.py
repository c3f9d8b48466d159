"""Colour, against values that are known."""

from __future__ import annotations

import numpy as np
import pytest

from tracer.errors import ScoreError
from tracer.image import colour


def test_srgb_of_known_values():
    # IEC 61966-2-1: linear 0.214041 is half of the encoded range
    assert colour.encode_srgb([0.0, 0.21404114, 1.0, 7.0, -1.0]) == pytest.approx([0, 0.5, 1, 1, 0], abs=1e-6)


def test_luminance_is_mitsubas():
    import mitsuba as mi

    rgb = [0.2, 0.7, 0.4]
    expected = mi.luminance(mi.Color3f(rgb))[0]
    assert colour.luminance(np.array(rgb)[None, None])[0, 0] == pytest.approx(expected, abs=1e-6)


@pytest.mark.parametrize("shape", [(4, 4, 4), (4, 4, 2), ()])
def test_luminance_of_other_channels_is_refused(shape):
    with pytest.raises(ScoreError, match="has no luminance"):
        colour.luminance(np.zeros(shape))

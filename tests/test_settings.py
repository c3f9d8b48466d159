"""Settings out of range are one sentence that names them."""

import pytest

from tracer.errors import SettingsError
from tracer.settings import make_settings


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"spp": 0}, "spp: input should be greater than or equal to 1 .was 0."),
        ({"spp": -3}, "spp"),
        ({"spp": "many"}, "spp: .*integer"),
        ({"seed": -1}, "seed"),
        ({"criterion": "shape_entrpy"}, "did you mean 'shape_entropy'"),
        ({"objective": "relatve"}, "did you mean 'relative'"),
        ({"spp": 8, "min_spp": 9}, r"min_spp \(9\) must not exceed spp \(8\)"),
        ({"spp": 8, "max_spp": 7}, "max_spp"),
        ({"spp": 8, "pilot_spp": 9}, "pilot_spp"),
        ({"block": 0}, "block"),
        ({"sppp": 8}, "there is no setting 'sppp', did you mean 'spp'"),
    ],
)
def test_bad_values(values, message):
    with pytest.raises(SettingsError, match=message) as caught:
        make_settings(**values)
    assert "\n" not in str(caught.value)


def test_defaults_follow_the_budget():
    assert make_settings(spp=64).least_samples == 8
    assert make_settings(spp=2).pilot_samples == 2
    assert make_settings(spp=64, max_spp=100).most_samples == 100

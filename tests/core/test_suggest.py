"""The name that a mistaken one is likely to stand for."""

import pytest

from tracer.core.suggest import did_you_mean, known, nearest

NAMES = ["max_spp", "min_spp", "noise", "seed"]


@pytest.mark.parametrize(
    ("name", "hint"),
    [("spp_max", "max_spp"), ("max-spp", "max_spp"), ("nois", "noise"), ("Seed", "seed"), ("xyz", None)],
)
def test_the_nearest_is_found_whatever_the_order_of_its_words(name, hint):
    assert nearest(name, NAMES) == hint
    assert did_you_mean(name, NAMES) == ("." if hint is None else f", did you mean '{hint}'?")
    assert did_you_mean(name, NAMES, otherwise="") == ("" if hint is None else f", did you mean '{hint}'?")


def test_a_name_is_known_or_all_that_are_known_are_named():
    assert known("noise", "setting", NAMES) == "noise"
    with pytest.raises(ValueError, match=r"there is no setting 'nois', did you mean 'noise'\? There are: max_spp, min"):
        known("nois", "setting", NAMES)
    with pytest.raises(ValueError, match=r"there is no setting 'xyz'\. There are: max_spp"):
        known("xyz", "setting", NAMES)

"""Numbers as a person reads them: no digit that says more, and nothing that looks reached before it is."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tracer.core.quantities import mean_count, percent, with_prefix


def test_counts_with_prefixes():
    counts = {0: "0", 384: "384", 999: "999", 1000: "1.00 k", 6144: "6.14 k", 999_499: "999 k", 999_500: "1.00 M"}
    assert {count: with_prefix(count) for count in counts} == counts
    assert with_prefix(2**52) == "4.50 P"  # the most samples of the largest picture


@given(st.integers(0, 2**52))
def test_a_count_is_read_within_half_a_digit(count):
    number, _, prefix = with_prefix(count).partition(" ")
    assert float(number) * {"": 1, "k": 1e3, "M": 1e6, "G": 1e9, "T": 1e12, "P": 1e15}[prefix] == pytest.approx(
        count, rel=0.005
    )
    assert len(number.replace(".", "")) <= 3


@given(st.floats(0, 1), st.integers(0, 2))
def test_a_percentage_never_says_more_than_is_there(share, digits):
    said = float(percent(share, digits))
    assert said <= 100 * share + 1e-5
    assert said > 100 * share - 10.0**-digits - 1e-5


def test_nearly_reached_is_not_reached():
    assert percent(0.9496, 1) == "94.9"
    assert percent(0.999, 0) == "99"
    assert percent(1.0, 0) == "100"
    assert percent(0.29, 0) == "29"  # 28.999999999999996


def test_mean_counts_are_no_powers_of_ten():
    means = {16.0: "16", 40.4: "40.4", 0.0625: "0.0625", 99.96: "100", 1365.33: "1365.3", 4096.0: "4096"}
    assert {mean: mean_count(mean) for mean in means} == means

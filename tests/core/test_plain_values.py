"""Numbers of other libraries are numbers; what is none is one sentence."""

import numpy as np
import pytest

from tracer.core.plain_values import plain, whole_number, whole_numbers
from tracer.errors import SettingsError


class Index:
    def __index__(self):
        return 7


@pytest.mark.parametrize("value", [7, np.int64(7), np.uint8(7), np.array(7), Index()])
def test_anything_like_a_whole_number_is_one(value):
    assert type(plain(value)) is int
    assert whole_number("size", value) == 7
    assert whole_numbers("size", [value, 3], 2, "width and height") == (7, 3)


@pytest.mark.parametrize("value", [7.0, np.float64(7), "7", True, np.True_, None, [7]])
def test_what_is_no_whole_number_says_so(value):
    with pytest.raises(SettingsError, match=r"size: write a whole number \(was "):
        whole_number("size", value)
    with pytest.raises(SettingsError, match=r"size: write 2 whole numbers, width and height \(was "):
        whole_numbers("size", (value, 3), 2, "width and height")


@pytest.mark.parametrize("value", [3, "34", (3,), (3, 4, 5), None])
def test_a_wrong_count_says_so(value):
    with pytest.raises(SettingsError, match="write 2 whole numbers"):
        whole_numbers("size", value, 2, "width and height")

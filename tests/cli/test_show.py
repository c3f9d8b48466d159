"""Tables on a terminal of 80 columns lose nothing."""

import pytest

from tracer.cli.show import SHOWN, narrowed, simple_table, table_width

LINES = [
    ["uniform", "0.000601°", "0.9902", "0.0137", "1.47", "1.00°", "1.00*"],
    [
        "mi.render multijitter + denoiser",
        "0.00853°",
        "0.9860",
        "0.0155",
        "123.18",
        "10.70 [10.69, 10.72]°",
        "0.88 [0.62, 1.13]*",
    ],
]


@pytest.mark.parametrize("width", [80, 120])
def test_a_table_of_a_study_is_shown_whole(capsys, monkeypatch, width):
    monkeypatch.setenv("COLUMNS", str(width))
    simple_table(SHOWN, LINES, "rods, 64 spp")
    shown = capsys.readouterr().out
    assert max(map(len, shown.splitlines())) <= width
    words = [word for line in LINES for cell in line for word in cell.split()]
    assert all(word in shown for word in [*words, *SHOWN])


def test_what_fits_is_left_as_it_is():
    assert narrowed(SHOWN, LINES, 120) == LINES
    assert table_width(["a", "bb"], [["ccc", "d"], ["e\nffff", "g"]]) == 4 + 2 + 2

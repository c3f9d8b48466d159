"""Colours, scale and ends of the scale of a picture of illuminance."""

import matplotlib
import numpy as np
import pytest
from matplotlib.image import imread

from tracer.radiosity.false_colours import COLOURS, MARGIN, NOWHERE, false_colours, limits, write_false_colours


def ramp(rows=480, columns=640):
    lux = np.tile(np.linspace(0, 500, columns), (rows, 1))
    return lux, np.arange(columns)[None] >= np.full((rows, 1), 20)


def test_a_pixel_has_the_colour_of_its_place_on_the_scale(tmp_path):
    lux, lit = ramp()
    write_false_colours(tmp_path / "lux.png", lux, lit)
    picture = imread(tmp_path / "lux.png")[MARGIN:, MARGIN:, :3]
    most = np.percentile(lux[lit], 99.5)
    for column in (100, 320, 600):
        expected = matplotlib.colormaps[COLOURS](lux[240, column] / most)[:3]
        assert picture[240, column] == pytest.approx(expected, abs=0.02)
    assert picture[240, 5] == pytest.approx(NOWHERE, abs=0.01)


@pytest.mark.parametrize("logarithmic", [False, True])
def test_the_scale_is_in_lux_with_ticks(logarithmic):
    lux, lit = ramp()
    figure = false_colours(lux, lit, logarithmic)
    figure.canvas.draw()
    _, bar = figure.axes
    least, most = limits(lux[lit], logarithmic)
    ticks = [tick for tick in bar.get_yticks() if least <= tick <= most]
    assert len(ticks) >= 4
    assert "lux" in bar.get_ylabel()
    assert bar.get_yscale() == ("log" if logarithmic else "linear")
    assert any(label.get_text() for label in bar.get_yticklabels())


def test_few_bright_pixels_do_not_take_all_colours():
    lux = np.full(10_000, 100.0)
    lux[:20] = 1e6
    assert limits(lux, False) == (0.0, 100.0)
    assert limits(np.zeros(4), False) == (0.0, 1.0)
    assert limits(np.zeros(0), True) == (1e-4, 1.0)
    least, most = limits(np.geomspace(1e-9, 1e3, 1000), True)
    assert least == pytest.approx(1e-4 * most)


@pytest.mark.parametrize("logarithmic", [False, True])
def test_small_and_dark_pictures_can_be_read(tmp_path, logarithmic):
    write_false_colours(tmp_path / "lux.png", np.zeros((8, 12)), np.zeros((8, 12), bool), logarithmic)
    assert imread(tmp_path / "lux.png").shape[0] >= 480

"""Colours, scale and ends of the scale of a picture of illuminance."""

import matplotlib
import numpy as np
import pytest
from matplotlib.image import imread

from tracer.errors import SettingsError
from tracer.radiosity.false_colours import (
    COLOURS,
    MARGIN,
    NOWHERE,
    Scale,
    false_colours,
    limits,
    scale_of,
    write_false_colours,
)


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
    figure = false_colours(lux, lit, Scale(logarithmic))
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
    write_false_colours(tmp_path / "lux.png", np.zeros((8, 12)), np.zeros((8, 12), bool), Scale(logarithmic))
    assert imread(tmp_path / "lux.png").shape[0] >= 480


@pytest.mark.parametrize("text", ["0,800", "100,400"])
def test_a_fixed_scale_gives_equal_light_equal_colours_in_two_pictures(tmp_path, text):
    lux, lit = ramp()
    least, most = (float(number) for number in text.split(","))
    for factor in (1.0, 0.5):
        write_false_colours(tmp_path / "lux.png", factor * lux, lit, scale_of(False, text))
        picture = imread(tmp_path / "lux.png")[MARGIN:, MARGIN:, :3]
        for column in (100, 320, 600):
            place = np.clip((factor * lux[240, column] - least) / (most - least), 0, 1)
            assert picture[240, column] == pytest.approx(matplotlib.colormaps[COLOURS](place)[:3], abs=0.02)
    assert scale_of(True, "1,1e3") == Scale(True, (1.0, 1000.0))


@pytest.mark.parametrize("text", ["500", "0,500,2", "a,b", "", "500,0", "5,5", "-1,5", "0,inf", "nan,1"])
def test_a_range_that_is_none_is_refused(text):
    with pytest.raises(SettingsError, match=r"[Rr]ange"):
        scale_of(False, text)
    with pytest.raises(SettingsError, match="begins above 0"):
        scale_of(True, "0,500")

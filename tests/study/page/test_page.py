"""The page in a real browser: what a person does with keys, buttons and pointer."""

import base64
import re

import numpy as np
import pytest

from study.page.conftest import METHODS, made_up
from study.page.driver import captions, click, colour, press, seconds_to_open, settle, shown_srgb
from tracer.study.panels import relative_error

pytestmark = pytest.mark.slow
MOST_SECONDS = 2.0
MOST_BYTES = 1.5 * 2**20
CODED = 12
"""Most that a colour on the screen may be off where pictures are compressed with a loss, of 255."""


def test_it_opens_at_once_and_is_small(browser, page_file):
    assert page_file.stat().st_size < MOST_BYTES
    empty = page_file.with_name("empty.html")
    empty.write_text("<!DOCTYPE html><p class=caption>Nothing</p>")
    nothing, took = (min(seconds_to_open(browser, path) for _ in range(3)) for path in (empty, page_file))
    assert took < max(MOST_SECONDS, 40 * nothing)  # a machine may be slow
    assert browser.get_log("browser") == []
    assert not re.search(r"https?://(?!www\.w3\.org/)", page_file.read_text())


def test_pictures_are_those_that_were_made(page):
    _, pictures = made_up(8, 6)
    press(page, "4")
    assert captions(page) == ["stock a · 64 spp, seed 0 · relMSE 0.000625"]
    for x, y in ((20, 30), (128, 100), (200, 150)):
        expected = shown_srgb(pictures[0].shown[3].image[y, x])
        np.testing.assert_allclose(colour(page, x, y), np.clip(expected, 0, 255), atol=CODED)
    press(page, "r")
    np.testing.assert_allclose(colour(page, 100, 50), shown_srgb(pictures[0].reference[50, 100]), atol=CODED)


def test_methods_flip_at_the_same_place(page):
    page.execute_script("document.querySelector('.pane canvas').focus()")
    press(page, "+")
    press(page, "ArrowRight", shift=True)
    place = page.execute_script("return [state.zoom, state.x, state.y]")
    assert place[0] == 1.5
    assert place[1] > 0.5
    for name in [*METHODS[1:], "reference", METHODS[0]]:
        press(page, "ArrowRight")
        assert captions(page)[0].startswith(name)
        assert page.execute_script("return [state.zoom, state.x, state.y]") == place
    press(page, "ArrowLeft")
    assert captions(page) == ["reference"]
    click(page, '#methods [data-method="1"]')
    assert captions(page)[0].startswith("fused")
    assert page.execute_script("return document.querySelectorAll('#methods [aria-pressed=true]').length") == 1


def test_pan_and_zoom_are_in_step_side_by_side(page):
    press(page, "g")
    assert len(captions(page)) == len(METHODS) + 1
    box = page.execute_script(
        "const b = document.querySelectorAll('.pane canvas')[2].getBoundingClientRect();"
        "return [b.left, b.top, b.width, b.height]"
    )
    page.execute_script(
        """const canvas = document.querySelectorAll('.pane canvas')[2];
        canvas.dispatchEvent(new WheelEvent('wheel', {
          deltaY: -480, clientX: arguments[0], clientY: arguments[1], bubbles: true, cancelable: true}))""",
        box[0] + 0.25 * box[2],
        box[1] + 0.5 * box[3],
    )
    settle(page)
    places = page.execute_script(
        "return [...document.querySelectorAll('.pane canvas')].map(placement).map((p) => [p.scale, p.left, p.top])"
    )
    assert all(place == pytest.approx(places[0]) for place in places)
    assert page.execute_script("return state.zoom") == pytest.approx(4)
    assert page.execute_script("return state.x") < 0.5  # what was under the pointer stays there
    press(page, "0")
    assert page.execute_script("return state.zoom") == 1


def test_exposure_is_of_linear_data(page):
    page.execute_script(
        "const s = document.getElementById('exposure'); s.value = -2; s.dispatchEvent(new Event('input'))"
    )
    settle(page)
    press(page, "r")
    _, pictures = made_up(1, 1)
    np.testing.assert_allclose(colour(page, 200, 50), shown_srgb(pictures[0].reference[50, 200] / 4), atol=1.01)
    assert page.execute_script("return document.getElementById('stops').textContent") == "-2"
    press(page, ".")
    assert page.execute_script("return document.getElementById('exposure').value") == "-1.5"


def test_wipe_shows_two(page):
    press(page, "w")
    page.execute_script(
        "const s = document.getElementById('against'); s.value = 2; s.dispatchEvent(new Event('change'))"
    )
    page.execute_script("const s = document.getElementById('wipe'); s.value = 0.3; s.dispatchEvent(new Event('input'))")
    settle(page)
    assert page.execute_script("return document.querySelector('.caption.right').textContent").startswith("edges")
    _, pictures = made_up(1, 3)
    left, right = pictures[0].shown[0].image, pictures[0].shown[2].image
    np.testing.assert_allclose(colour(page, 60, 90), np.clip(shown_srgb(left[90, 60]), 0, 255), atol=CODED)
    np.testing.assert_allclose(colour(page, 160, 90), np.clip(shown_srgb(right[90, 160]), 0, 255), atol=CODED)


def test_errors_and_counts_have_a_scale(page):
    assert page.execute_script("return getComputedStyle(document.getElementById('scale')).visibility") == "hidden"
    press(page, "e")
    ticks = page.execute_script("return document.getElementById('scale-ticks').innerText").split()
    assert ticks[0] == "0"
    assert page.execute_script("return getComputedStyle(document.getElementById('scale')).visibility") == "visible"
    dark = np.mean([colour(page, x, 60) for x in range(20, 250, 10)])
    press(page, "6")
    assert np.mean([colour(page, x, 60) for x in range(20, 250, 10)]) < 0.5 * dark  # a sixth of the error
    press(page, "s")
    press(page, "2")
    ticks = page.execute_script("return [...document.getElementById('scale-ticks').children].map((t) => t.textContent)")
    assert (int(ticks[0]), int(ticks[-1])) == (8, 511)


def test_values_under_the_pointer(page):
    _, pictures = made_up(1, 2)
    press(page, "2")
    page.execute_script(
        """const canvas = document.querySelector('.pane canvas'), box = canvas.getBoundingClientRect();
        const { scale, left, top } = placement(canvas), ratio = box.width / canvas.width;
        canvas.dispatchEvent(new PointerEvent('pointermove', {
          clientX: box.left + (left + 77.5 * scale) * ratio,
          clientY: box.top + (top + 33.5 * scale) * ratio, bubbles: true }))"""
    )
    settle(page)
    table = page.execute_script(
        "return [...document.querySelectorAll('#value tr')].map((row) => [...row.cells].map((c) => c.textContent))"
    )
    assert table[0] == ["pixel 77, 33", "R", "G", "B", "error", "spp"]
    shown, truth = pictures[0].shown[1], pictures[0].reference
    name, *rgb, error, samples = table[1]
    assert name == "fused"
    np.testing.assert_allclose([float(word) for word in rgb], shown.image[33, 77], atol=0.06)
    square = np.s_[32:34, 76:78]  # maps are of squares of two by two pixels
    expected = np.sqrt(np.mean(relative_error(shown.image, truth)[square] ** 2))
    assert float(error) == pytest.approx(expected, rel=0.3)
    assert int(samples) == pytest.approx(shown.counts[square].mean(), rel=0.3)
    assert table[2][0] == "reference"
    np.testing.assert_allclose([float(word) for word in table[2][1:4]], truth[33, 77], atol=0.02)


def test_scenes_change(page):
    press(page, "]")
    assert page.execute_script("return document.querySelector('.scene:not([hidden]) h3').textContent") == "scene 1"
    assert "disagree" in page.execute_script("return document.querySelector('.scene:not([hidden])').innerText")
    press(page, "[")
    press(page, "[")
    assert page.execute_script("return document.querySelector('.scene:not([hidden]) h3').textContent") == "scene 7"
    assert page.execute_script("return document.querySelectorAll('.scene:not([hidden]) svg.plot').length") == 2


def test_tables_sort(page):
    def column(k):
        rows = "[...document.getElementById('table').tBodies[0].rows]"
        return page.execute_script(f"return {rows}.map((row) => row.cells[arguments[0]].dataset.key)", k)

    assert len(column(0)) == 8 * 6 * 2
    page.execute_script("document.querySelectorAll('#table th button')[3].click()")
    values = [float(value) for value in column(3)]
    assert values == sorted(values)
    page.execute_script("document.querySelectorAll('#table th button')[3].click()")
    values = [float(value) for value in column(3)]
    assert values == sorted(values, reverse=True)
    assert (
        page.execute_script("return document.querySelectorAll('#table th')[3].getAttribute('aria-sort')")
        == "descending"
    )
    page.execute_script("document.querySelectorAll('#table th button')[16].click()")
    unknown = [value == "nan" for value in column(16)]
    assert unknown == sorted(unknown)  # last


def test_light_and_dark(page):
    def paper():
        return page.execute_script("return getComputedStyle(document.body).backgroundColor")

    before = paper()
    press(page, "l")
    assert paper() != before
    click(page, "#theme")
    assert paper() == before


def test_controls_can_be_reached_by_keyboard(page):
    names = page.execute_script(
        """return [...document.querySelectorAll('button, select, input, .pane canvas')]
        .filter((e) => e.offsetParent !== null)
        .map((e) => [e.tabIndex, e.ariaLabel || e.textContent || e.closest('label')?.textContent || ''])"""
    )
    assert all(index == 0 and name.strip() for index, name in names)


def test_print_shows_every_scene(page):
    pdf = base64.b64decode(page.print_page())
    assert pdf.count(b"/Type /Page\n") + pdf.count(b"/Type /Page ") + pdf.count(b"/Type /Page/") >= 9
    page.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "print"})
    hidden = page.execute_script(
        "return [...document.querySelectorAll('.scene')].filter((s) => s.offsetParent === null).length"
    )
    images = page.execute_script(
        "return [...document.querySelectorAll('.sources img')].filter((s) => s.offsetWidth > 100).length"
    )
    viewer = page.execute_script("return document.getElementById('panes').offsetParent")
    page.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": ""})
    assert (hidden, images, viewer) == (0, 8 * (1 + 6 + 6 + 1), None)


def test_text_is_not_taken_for_html(page):
    text = page.execute_script("return document.body.innerText")
    assert "Noise <b>&</b> nothing else." in text
    assert "no <i>luck</i>" in text

"""The page in a real browser: what a person does with keys, buttons and pointer."""

import base64
import re
import time

import numpy as np
import pytest

from conftest import PATIENCE
from study.page.conftest import HEIGHT, METHODS, WIDTH, made_up
from tracer.study.page import build

pytestmark = pytest.mark.slow
MOST_SECONDS = 2.0
MOST_BYTES = 40e6


@pytest.fixture
def page(browser, page_file):
    """Open the page anew and wait until the first picture is drawn."""
    browser.get(page_file.as_uri())
    wait(browser, "document.querySelector('.caption').textContent !== ''")
    yield browser
    assert [entry for entry in browser.get_log("browser") if entry["level"] == "SEVERE"] == []


def wait(browser, condition):
    deadline = time.monotonic() + PATIENCE
    while not browser.execute_script(f"return {condition}"):
        assert time.monotonic() < deadline, condition
        time.sleep(0.02)


def seconds_to_open(browser, path):
    start = time.monotonic()
    browser.get(path.as_uri())
    wait(browser, "document.querySelector('.caption').textContent !== ''")
    return time.monotonic() - start


def press(browser, key, shift=False):
    browser.execute_script(
        "(document.activeElement || document.body).dispatchEvent("
        "new KeyboardEvent('keydown', {key: arguments[0], shiftKey: arguments[1], bubbles: true, cancelable: true}))",
        key,
        shift,
    )
    settle(browser)


def settle(browser):
    """Wait until what was asked for is drawn."""
    browser.execute_async_script("const done = arguments[0]; requestAnimationFrame(() => setTimeout(done, 60))")


def captions(browser):
    return browser.execute_script(
        "return [...document.querySelectorAll('.caption:not(.right)')].map((c) => c.textContent)"
    )


def colour(browser, x, y, pane=0):
    """Return the colour (R, G, B) in the middle of a picture's pixel on the screen."""
    return browser.execute_script(
        """const canvas = document.querySelectorAll('.pane canvas')[arguments[2]];
        const { scale, left, top } = placement(canvas);
        const at = [left + (arguments[0] + 0.5) * scale, top + (arguments[1] + 0.5) * scale].map(Math.floor);
        return [...canvas.getContext('2d').getImageData(...at, 1, 1).data].slice(0, 3);""",
        x,
        y,
        pane,
    )


def shown_srgb(value):
    return 255 * np.where(value <= 0.0031308, 12.92 * value, 1.055 * np.clip(value, 1e-9, 1) ** (1 / 2.4) - 0.055)


def click(browser, selector):
    browser.execute_script("document.querySelector(arguments[0]).click()", selector)
    settle(browser)


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
        np.testing.assert_allclose(colour(page, x, y), np.clip(expected, 0, 255), atol=1.01)
    press(page, "r")
    np.testing.assert_allclose(colour(page, 100, 50), shown_srgb(pictures[0].reference[50, 100]), atol=1.01)


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
    np.testing.assert_allclose(colour(page, 60, 90), np.clip(shown_srgb(left[90, 60]), 0, 255), atol=1.01)
    np.testing.assert_allclose(colour(page, 160, 90), np.clip(shown_srgb(right[90, 160]), 0, 255), atol=1.01)


def test_errors_and_counts_have_a_scale(page):
    assert page.execute_script("return getComputedStyle(document.getElementById('scale')).visibility") == "hidden"
    press(page, "e")
    ticks = page.execute_script("return document.getElementById('scale-ticks').innerText").split()
    assert ticks[0] == "0.0"
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
    text = page.execute_script("return document.getElementById('value').textContent")
    assert text.startswith("pixel 77, 33")
    line = next(line for line in text.splitlines() if line.startswith("fused"))
    shown = pictures[0].shown[1]
    np.testing.assert_allclose([float(word) for word in line.split()[1:4]], shown.image[33, 77], rtol=6e-3, atol=1e-3)
    assert int(line.split()[-1]) == shown.counts[33, 77]


def test_scenes_change(page):
    press(page, "]")
    assert page.execute_script("return document.querySelector('.scene:not([hidden]) h3').textContent") == "scene 1"
    assert "disagree" in page.execute_script("return document.querySelector('.scene:not([hidden])').innerText")
    press(page, "[")
    press(page, "[")
    assert page.execute_script("return document.querySelector('.scene:not([hidden]) h3').textContent") == "scene 7"
    assert page.execute_script("return document.querySelectorAll('.scene:not([hidden]) svg').length") == 1


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
    strips = page.execute_script(
        "return [...document.querySelectorAll('.strip')].filter((s) => s.naturalWidth > 500).length"
    )
    viewer = page.execute_script("return document.getElementById('panes').offsetParent")
    page.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": ""})
    assert (hidden, strips, viewer) == (0, 8, None)


def test_text_is_not_taken_for_html(page):
    text = page.execute_script("return document.body.innerText")
    assert "Noise <b>&</b> nothing else." in text
    assert "no <i>luck</i>" in text


def test_pictures_shrink_when_there_are_too_many(monkeypatch):
    results, pictures = made_up(2, 2)
    blocks, scenes = build.fit(results, pictures)
    assert (scenes[0]["width"], scenes[0]["height"], scenes[0]["factor"]) == (WIDTH, HEIGHT, 1)
    size = sum(map(len, blocks.values()))
    monkeypatch.setattr(build, "MOST_BYTES", size // 3)
    blocks, scenes = build.fit(results, pictures)
    assert (scenes[0]["width"], scenes[0]["factor"]) == (WIDTH // 2, 2)
    assert sum(map(len, blocks.values())) <= size // 3
    monkeypatch.undo()
    small = results.plan.model_copy(update={"page_size": 100})
    results.plan = small
    assert build.fit(results, pictures)[1][0]["width"] == WIDTH // 3
    assert "averaged over 3 × 3" in build.build_page(results, pictures)

"""The page in a real browser: what a person does with keys, buttons and pointer."""

import base64
import re
import time

import numpy as np
import pytest

from conftest import PATIENCE
from study.page.conftest import HEIGHT, METHODS, WIDTH, made_up
from tracer.study.page.build import write_page
from tracer.study.panels import relative_error

pytestmark = pytest.mark.slow
MOST_SECONDS = 2.0
MOST_BYTES = 1.5 * 2**20
CODED = 12
"""Most that a colour on the screen may be off where pictures are compressed with a loss, of 255."""
SIZES = {"laptop": (1366, 768), "desktop": (1920, 1080), "phone": (390, 844)}


@pytest.fixture
def page(browser, page_file):
    """Open the page anew and wait until the first picture is drawn."""
    browser.get(page_file.as_uri())
    wait(browser, "document.querySelector('.caption')?.textContent")
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
    wait(browser, "document.querySelector('.caption')?.textContent")
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


@pytest.fixture(params=SIZES)
def window(request, browser, page_file):
    """Open the page in a window of one of SIZES, and give the browser its size back afterwards."""
    width, height = SIZES[request.param]
    phone = request.param == "phone"
    metrics = {"width": width, "height": height, "deviceScaleFactor": 2 if phone else 1, "mobile": phone}
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)
    browser.get(page_file.as_uri())
    wait(browser, "document.querySelector('.caption')?.textContent")
    yield browser, width, height
    browser.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})


def boxes(browser, selector):
    """Return left, top, width and height of what is chosen."""
    return browser.execute_script(
        "return [...document.querySelectorAll(arguments[0])].map((e) => e.getBoundingClientRect())"
        ".map((b) => [b.left, b.top, b.width, b.height])",
        selector,
    )


def test_pictures_fit_the_window_and_keep_their_aspect(window):
    browser, width, height = window
    for mode in ("f", "w", "g"):
        press(browser, mode)
        panes = boxes(browser, ".pane canvas")
        for left, _, across, down in panes:
            assert across / down == pytest.approx(WIDTH / HEIGHT, rel=0.02)
            assert left >= 0
            assert left + across <= width
        tops, bottoms = [pane[1] for pane in panes], [pane[1] + pane[3] for pane in panes]
        assert max(bottoms) - min(tops) <= height
        assert max(bottoms) - boxes(browser, "#scenes")[0][1] <= height + 10  # the row of scenes is in sight, too
        used = sum(pane[2] * pane[3] for pane in panes)
        room = boxes(browser, "#panes")[0][2] * (height if width > 900 else max(bottoms) - min(tops))
        assert used > 0.4 * room


def test_nothing_is_wider_than_the_window(window):
    browser, width, height = window
    assert browser.execute_script("return document.documentElement.scrollWidth") <= width
    assert all(box[3] <= height for box in boxes(browser, ".wide"))
    assert all(box[0] >= 0 and box[0] + box[2] <= width for box in boxes(browser, "svg.plot, #panel, #scenes"))
    if width > 900:
        table = "document.getElementById('table').parentElement"
        assert browser.execute_script(f"return {table}.scrollWidth - {table}.clientWidth") <= 0


def test_scenes_are_chosen_by_thumbnail(page):
    page.execute_script("return Promise.all([...document.querySelectorAll('#scenes img')].map((i) => i.decode()))")
    thumbnails = page.execute_script(
        "return [...document.querySelectorAll('#scenes button')]"
        ".map((b) => [b.textContent, b.querySelector('img').naturalWidth, b.querySelector('img').clientHeight])"
    )
    assert thumbnails == [[f"scene {k}", WIDTH, 52] for k in range(8)]
    click(page, "#scenes button:nth-child(4)")
    assert page.execute_script("return state.scene") == 3
    page.execute_script("document.querySelectorAll('#scenes button')[3].focus()")
    press(page, "ArrowRight")
    assert page.execute_script("return [state.scene, document.activeElement.textContent]") == [4, "scene 4"]
    press(page, "ArrowUp")
    assert page.execute_script("return [state.scene, document.activeElement.textContent]") == [3, "scene 3"]


def test_arrows_change_methods_wherever_the_focus_is_but_in_sliders(page):
    press(page, "ArrowRight")
    assert page.execute_script("return state.method") == 1
    page.execute_script("document.querySelector('.pane canvas').focus()")
    press(page, "ArrowDown")
    assert page.execute_script("return [state.scene, state.method]") == [1, 1]
    page.execute_script("document.getElementById('exposure').focus()")
    press(page, "ArrowRight")
    assert page.execute_script("return state.method") == 1


def touch(browser, start, end):
    """Put a finger on the first picture at a share of its width, move it to another, and lift it."""
    browser.execute_script("document.getElementById('panes').scrollIntoView({ block: 'center' })")
    left, top, width, height = boxes(browser, ".pane canvas")[0]
    places = [{"x": left + share * width, "y": top + 0.5 * height} for share in np.linspace(start, end, 5)]
    dispatch = "Input.dispatchTouchEvent"
    browser.execute_cdp_cmd(dispatch, {"type": "touchStart", "touchPoints": [places[0]]})
    for place in places[1:] if start != end else []:
        browser.execute_cdp_cmd(dispatch, {"type": "touchMove", "touchPoints": [place]})
    browser.execute_cdp_cmd(dispatch, {"type": "touchEnd", "touchPoints": []})
    settle(browser)


def test_a_finger_switches_methods(page):
    page.execute_cdp_cmd("Emulation.setTouchEmulationEnabled", {"enabled": True})
    try:
        for start, end, expected in ((0.8, 0.2, 1), (0.8, 0.3, 2), (0.2, 0.8, 1), (0.5, 0.5, 2)):
            touch(page, start, end)
            assert page.execute_script("return state.method") == expected
        press(page, "+")
        touch(page, 0.8, 0.3)
        assert page.execute_script("return state.method") == 2  # it moved the picture instead
        assert page.execute_script("return state.x") > 0.5
        press(page, "g")
        touch(page, 0.5, 0.5)
        assert page.execute_script("return [state.mode, state.method]") == ["flip", -1]
    finally:
        page.execute_cdp_cmd("Emulation.setTouchEmulationEnabled", {"enabled": False})


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_the_page_follows_the_system(page, scheme):
    features = {"features": [{"name": "prefers-color-scheme", "value": scheme}]}
    page.execute_cdp_cmd("Emulation.setEmulatedMedia", features)
    paper, series = page.execute_script(
        "return [getComputedStyle(document.body).backgroundColor,"
        "getComputedStyle(document.querySelector('svg.plot .interval')).stroke]"
    )
    page.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": []})
    bright = [np.mean([float(word) for word in re.findall(r"\d+", text)]) for text in (paper, series)]
    assert (bright[0] > 128) == (scheme == "light")
    assert (bright[1] < 128) == (scheme == "light")


def test_the_overview_is_on_top(page):
    first = page.execute_script("return document.querySelector('section svg.plot').getAttribute('aria-label')")
    assert first.startswith("Gain over uniform at equal samples, 64 spp, on a logarithmic axis. fused: 4.00")
    assert page.execute_script("return document.querySelectorAll('details.overview').length") == 1
    assert boxes(page, "svg.plot")[0][1] < boxes(page, "#viewer")[0][1]


def test_own_metrics_are_columns(browser, tmp_path):
    write_page(tmp_path / "own.html", *made_up(1, 2, own_metric=True))
    browser.get((tmp_path / "own.html").as_uri())
    heading, cell = browser.execute_script(
        "const t = document.getElementById('table');"
        "return [t.tHead.rows[0], t.tBodies[0].rows[1]].map((row) => row.cells[row.cells.length - 1].textContent)"
    )
    assert heading == "worst_error"
    assert float(cell) == pytest.approx(0.15)


def test_fourteen_scenes_and_four_methods_are_small(tmp_path):
    path = tmp_path / "large.html"
    write_page(path, *made_up(14, 4))
    assert path.stat().st_size < MOST_BYTES

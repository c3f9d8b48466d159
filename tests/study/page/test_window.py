"""The page in a real browser: in windows of any size, by touch, in dark and light, and what is on top."""

import re

import numpy as np
import pytest

from study.page.conftest import HEIGHT, WIDTH, made_up
from study.page.driver import click, press, settle, wait
from tracer.study.page.build import write_page

pytestmark = pytest.mark.slow
MOST_BYTES = 1.5 * 2**20
SIZES = {"laptop": (1366, 768), "desktop": (1920, 1080), "phone": (390, 844)}


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

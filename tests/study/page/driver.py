"""What a person does with a page in a browser, and what they then see."""

import time

import numpy as np

from conftest import PATIENCE


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

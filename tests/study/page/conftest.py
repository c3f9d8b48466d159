"""A page of eight scenes and six methods, made up, and a browser to open it with."""

import os
import shutil

import numpy as np
import pytest

from study.page.driver import wait
from tracer.image.metrics import Scores
from tracer.study.cells import Cell, RenderCost
from tracer.study.page.build import write_page
from tracer.study.page.scene import ScenePictures, Shown
from tracer.study.plan import Budget, make_plan
from tracer.study.records import Failure, Measurement, SceneFacts
from tracer.study.results import Results

METHODS = ["uniform", "fused", "edges", "stock a", "stock b", "stock c"]
HEIGHT, WIDTH = 192, 256


def made_up(scene_count, method_count, seed=0, own_metric=False):
    """Return results and pictures of grey noise: method k errs 1 / (k + 1) as much as the first."""
    generator = np.random.default_rng(seed)
    methods = METHODS[:method_count]
    plan = make_plan(
        {
            "name": "made up",
            "about": "Noise <b>&</b> nothing else.",
            "spp": [16, 64],
            "seeds": 2,
            "scenes": [{"bundled": "*"}],
            "methods": [
                {"name": name, "criterion": "uniform"} if k < 3 else {"name": name, "sampler": "independent"}
                for k, name in enumerate(methods)
            ],
        }
    )
    results = Results(plan, finished=True)
    pictures = []
    for k in range(scene_count):
        name = f"scene {k}"
        ramp = np.linspace(0, 2, WIDTH)[None, :, None] * np.array([1.0, 0.7, 0.4])
        truth = np.broadcast_to(ramp, (HEIGHT, WIDTH, 3))
        results.scenes.append(SceneFacts(name, WIDTH, HEIGHT, 8192, 1e-6, 1e-6, k != 1, 0.3, 2.5))
        shown = []
        for m, method in enumerate(methods):
            spread = 0.1 / (m + 1)
            image = (truth + spread * generator.standard_normal((HEIGHT, WIDTH, 1))).astype(np.float32)
            counts = np.full(truth.shape[:2], 64, np.float32)
            if m == 1:
                counts = generator.integers(8, 512, truth.shape[:2]).astype(np.float32)
            shown.append(Shown(method, image, counts, spread**2))
            for spp in plan.spp:
                for one in plan.all_seeds:
                    error = spread**2 * 64 / spp * (1 + 0.1 * one)
                    took = RenderCost(spp, spp * HEIGHT * WIDTH, 1e-2 * spp * (1 + m), 1e-2 * spp, "run", "a machine")
                    scores = Scores(error, error, error / 2, 30.0 + m, 0.9, 0.05, 1e-3)
                    cell = Cell(name, method, Budget("spp", spp), one, "key")
                    own = {"worst_error": 3 * spread} if own_metric else {}
                    results.measurements.append(Measurement(cell, took, scores, m == 5, own))
        pictures.append(ScenePictures(name, "64 spp", 0, truth, shown))
    results.failures.append(Failure("scene 0", "fused", "16 spp", 1, "no <i>luck</i>"))
    return results, pictures


@pytest.fixture(scope="session")
def page_file(tmp_path_factory):
    """Return the path of a large page."""
    path = tmp_path_factory.mktemp("page") / "index.html"
    write_page(path, *made_up(8, 6))
    return path


@pytest.fixture(scope="session")
def browser():
    """Return a headless Chromium; without one the test is skipped, unless TRACER_REQUIRE_CHROMIUM is set."""
    program, driver = shutil.which("chromium"), shutil.which("chromedriver")
    if not (program and driver):
        assert not os.environ.get("TRACER_REQUIRE_CHROMIUM"), "there is no chromium, or no chromedriver"
        pytest.skip("there is no chromium, or no chromedriver")
    from selenium.webdriver import Chrome, ChromeOptions, ChromeService

    options = ChromeOptions()
    options.binary_location = program
    for argument in ("--headless=new", "--no-sandbox", "--disable-dev-shm-usage", "--window-size=1300,1200"):
        options.add_argument(argument)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    opened = Chrome(options=options, service=ChromeService(driver))
    yield opened
    opened.quit()


@pytest.fixture
def page(browser, page_file):
    """Open the page anew and wait until the first picture is drawn."""
    browser.get(page_file.as_uri())
    wait(browser, "document.querySelector('.caption')?.textContent")
    yield browser
    assert [entry for entry in browser.get_log("browser") if entry["level"] == "SEVERE"] == []

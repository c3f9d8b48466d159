"""The images of a page fit into its bytes."""

import numpy as np
import pytest

from study.page.conftest import HEIGHT, WIDTH, made_up
from study.page.test_encode import decode
from tracer.study.page import pictures
from tracer.study.page.build import build_page
from tracer.study.page.encode import HEADROOM
from tracer.study.page.pictures import Fineness, encode_scene, fineness, fit
from tracer.study.page.plots import convergence
from tracer.study.panels import relative_error


def total(scenes):
    return sum(len(source.url) for scene in scenes for source in scene.sources)


def test_first_exact_then_compressed_then_smaller():
    assert [fineness(step) for step in range(5)] == [
        Fineness(True, 0, 1),
        Fineness(False, 0, 1),
        Fineness(False, 0, 2),
        Fineness(False, 1, 1),
        Fineness(False, 1, 2),
    ]


def test_pictures_shrink_when_there_are_too_many(monkeypatch):
    results, shown = made_up(2, 2)
    monkeypatch.setattr(pictures, "PICTURE_BYTES", 0)
    monkeypatch.setattr(pictures, "MOST_BYTES", 10**9)
    exact = fit(results, shown)
    assert (exact[0].viewer["width"], exact[0].viewer["height"], exact[0].viewer["factor"]) == (WIDTH, HEIGHT, 1)
    monkeypatch.setattr(pictures, "MOST_BYTES", total(exact) - 1)
    compressed = fit(results, shown)
    assert total(compressed) < total(exact)
    assert compressed[0].viewer["width"] == WIDTH
    monkeypatch.setattr(pictures, "MOST_BYTES", total(compressed) // 3)
    small = fit(results, shown)
    assert total(small) <= total(compressed) // 3
    assert small[0].viewer["width"] == WIDTH // small[0].viewer["factor"] < WIDTH
    monkeypatch.setattr(pictures, "MOST_BYTES", 1)
    assert fit(*made_up(0, 2)) == []
    monkeypatch.undo()
    results.plan = results.plan.model_copy(update={"page_size": 100})
    assert fit(results, shown)[0].viewer["width"] == WIDTH // 3
    assert "averaged over 3 × 3" in build_page(results, shown)


def test_errors_are_those_of_the_pictures_as_they_were_rendered():
    """The map on the page does not change with how the pictures on the page are compressed."""
    results, shown = made_up(1, 2)
    exact, lossy = (encode_scene(0, shown[0], results.scenes[0], 1, Fineness(exact, 0, 2)) for exact in (True, False))
    error = relative_error(shown[0].shown[0].image, shown[0].reference)
    squares = np.sqrt((error**2).reshape(HEIGHT // 2, 2, WIDTH // 2, 2).mean(axis=(1, 3)))
    assert exact.viewer["errorTop"] == lossy.viewer["errorTop"] == pytest.approx(np.quantile(squares, 0.99))
    source = next(source for source in lossy.sources if source.id == lossy.viewer["methods"][0]["error"])
    codes = decode(source.url)
    codes = codes[..., 0] if codes.ndim == 3 else codes
    restored = HEADROOM * lossy.viewer["errorTop"] * (codes / 255.0) ** 2
    assert np.mean(restored) == pytest.approx(np.mean(squares), rel=0.02)
    assert np.corrcoef(restored.ravel(), squares.ravel())[0, 1] > 0.97


def test_plots_take_little_room():
    results, _ = made_up(1, 6)
    plots = convergence(results.tables()[0], "scene 0", [method.name for method in results.plan.methods])
    assert len(plots) == 2
    assert all(len(plot) < 6000 for plot in plots)
    assert ">16<" in plots[0]
    assert ">64<" in plots[0]

"""In every scene that comes along, what is learned leaves the expected picture as it is."""

from importlib.resources import files

import mitsuba as mi
import numpy as np
import pytest
from scipy import stats

from tracer.guiding import effort
from tracer.scene.view import open_scene
from tracer.session import guidance
from tracer.session.render import render_request
from tracer.session.request import Request

FILES = [file for file in files("tracer.scenes").iterdir() if file.name.endswith(".xml")]
SCENES = {file.name.removesuffix(".xml"): file for file in FILES}
FALSE_ALARM, SIZE, BLOCK = 1e-4, (32, 24), 8
"""BLOCK: side of the squares of pixels whose means are compared, as few samples of a pixel are far from normal."""
MINE, THEIRS = 12, 6
"""Number of pictures with what was learned, and without."""


def blocks(image):
    """Return the means of squares of pixels, in all channels."""
    height, width, channels = image.shape
    return image.reshape(height // BLOCK, BLOCK, width // BLOCK, BLOCK, channels).mean(axis=(1, 3), dtype=float)


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(SCENES))
def test_the_mean_is_that_of_path(name, monkeypatch):
    monkeypatch.setattr(guidance, "pays", lambda *_: True)
    monkeypatch.setattr(guidance, "is_worth_a_look", lambda *_: True)
    monkeypatch.setattr(effort, "WORTH_A_LOOK", 0.0)  # it learns from a second look in any case
    scene = mi.load_file(str(SCENES[name]))
    with open_scene(scene, 0, None, SIZE) as opened:
        view = guidance.guided_view(opened)
        lesson = guidance.learn_lights(view, spp=4096, seed=7)
        assert lesson is not None
        assert np.any(lesson.learned.row > 0)
        theirs = np.stack([blocks(draw(opened, 1000 + seed, 128)) for seed in range(THEIRS)])
        monkeypatch.setattr(guidance, "learn_lights", lambda *_, **__: lesson)
        mine = np.stack([blocks(draw(view, seed, 64, guide=True)) for seed in range(MINE)])
    error = np.sqrt(mine.var(axis=0, ddof=1) / MINE + theirs.var(axis=0, ddof=1) / THEIRS)
    scores = (mine.mean(axis=0) - theirs.mean(axis=0)) / np.maximum(error, 1e-5)
    per_value = 1 - (1 - FALSE_ALARM) ** (1 / scores.size)
    assert abs(scores).max() < stats.t.ppf(1 - per_value / 2, THEIRS - 1)


def draw(view, seed, spp, **settings):
    """Return a picture with as many samples in each pixel."""
    return render_request(Request(view, {"spp": spp, "seed": seed, "criterion": "uniform", **settings})).rgb

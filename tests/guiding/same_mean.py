"""Whether pictures with what was really learned about lights have the mean of those of ``path``: a Z-test."""

from contextlib import contextmanager

import numpy as np
import pytest
from scipy import stats

from tracer.guiding import effort
from tracer.scene.view import open_scene
from tracer.session import guidance
from tracer.session.render import render_request
from tracer.session.request import Request

FALSE_ALARM, SIZE, BLOCK, TEACHING_SPP = 1e-4, (32, 24), 8, 4096
"""BLOCK: side of the squares of pixels whose means are compared, as few samples of a pixel are far from normal.
TEACHING_SPP: samples per pixel for which it learns, though it does not draw as many."""
PICTURES = 12
"""Number of pictures with what was learned, and as many without."""


def require_same_mean(scene, integrator=None, spp=64):
    """Fail if pictures of ``scene`` surely have another mean with what was learned than without.

    ``integrator`` takes the place of the scene's, which must be ``path``; ``spp``: samples per pixel of each picture.
    Return the score of the brightness of whole pictures, normal if the means are the same, for
    ``require_same_brightness``.
    """
    with open_scene(scene, 0, integrator, SIZE) as opened, learning_in_any_case() as patch:
        view = guidance.guided_view(opened)
        lesson = guidance.learn_lights(view, spp=TEACHING_SPP, seed=7)
        assert lesson is not None
        assert np.any(lesson.learned.row > 0)
        theirs = np.stack([means(draw(opened, 1000 + seed, spp)) for seed in range(PICTURES)])
        patch.setattr(guidance, "learn_lights", lambda *_, **__: lesson)
        mine = np.stack([means(draw(view, seed, spp, guide=True)) for seed in range(PICTURES)])
    assert theirs.max() > 0
    error = np.sqrt((mine.var(axis=0, ddof=1) + theirs.var(axis=0, ddof=1)) / PICTURES)
    scores = (mine.mean(axis=0) - theirs.mean(axis=0)) / np.maximum(error, 1e-5)
    per_value = 1 - (1 - FALSE_ALARM) ** (1 / scores.size)
    assert abs(scores).max() < stats.t.ppf(1 - per_value / 2, PICTURES - 1)
    return normal_score(brightness(mine), brightness(theirs))


def require_same_brightness(scores):
    """Fail if many cases together are surely brighter or darker with what was learned (Stouffer's sum of scores).

    A case alone misses an error of 1 % of the brightness more often than it finds it; together they find it.
    """
    assert abs(together(scores)) < stats.norm.isf(FALSE_ALARM / 2)


def together(scores):
    """Return the sum of independent normal scores, scaled to be normal itself."""
    return np.sum(scores) / np.sqrt(len(scores))


def normal_score(mine, theirs):
    """Return the score of the difference of two means, (PICTURES,) values each: normal if there is none."""
    score, probability = stats.ttest_ind(mine, theirs)
    return np.sign(score) * stats.norm.isf(probability / 2)


def brightness(pictures):
    """Return the brightness of each whole picture, (PICTURES,), from what ``means`` returns of each."""
    return pictures[:, -1].mean(axis=-1)


@contextmanager
def learning_in_any_case():
    """Let it learn from a second look, whether that pays or not; yield what patches."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(guidance, "pays", lambda *_: True)
        patch.setattr(guidance, "is_worth_a_look", lambda *_: True)
        patch.setattr(effort, "WORTH_A_LOOK", 0.0)
        yield patch


def draw(view, seed, spp, **settings):
    """Return a picture with as many samples in each pixel."""
    return render_request(Request(view, {"spp": spp, "seed": seed, "criterion": "uniform", **settings})).rgb


def means(image):
    """Return the means of all channels of squares of pixels, and of the whole picture."""
    height, width, channels = image.shape
    squares = image.reshape(height // BLOCK, BLOCK, width // BLOCK, BLOCK, channels).mean(axis=(1, 3), dtype=float)
    return np.concatenate([squares.reshape(-1, channels), image.mean(axis=(0, 1), dtype=float)[None]])

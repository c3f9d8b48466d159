"""A render learns which lights matter where: less noise, the same mean, and the same picture however it is drawn."""

import mitsuba as mi
import numpy as np
import pytest

import tracer
from guiding.lights import scene_with_lights
from tracer.scene.view import open_scene
from tracer.session import guidance
from tracer.settings import make_settings

LAMPS = ("sphere", *["far lamp"] * 39)
"""One lamp that matters, and 39 behind the floor."""


NOT_WORTH_IT = "Not guided: to learn which lights matter where is not expected to pay here."


def render(scene, **settings):
    return tracer.render(scene, **{"spp": 64, "size": 64, "criterion": "uniform", **settings})


def squared_error(pictures, truth):
    return np.mean([(picture - truth) ** 2 for picture in pictures])


@pytest.fixture(scope="module")
def lamps():
    return scene_with_lights(*LAMPS, integrator={"type": "path", "max_depth": 3, "hide_emitters": True})


def test_it_has_less_noise_at_the_same_mean(lamps):
    truth = np.mean([render(lamps, spp=1024, seed=10 + seed).image for seed in range(4)], axis=0)
    plain = [render(lamps, seed=seed).image for seed in range(4)]
    guided = [render(lamps, seed=seed, guide=True) for seed in range(4)]
    assert all(any(note.startswith("Guided: ") for note in result.report.notes) for result in guided)
    assert all(result.report.seconds_guiding > 0 for result in guided)
    images = [result.image for result in guided]
    assert squared_error(images, truth) < 0.7 * squared_error(plain, truth)
    assert np.mean(images) == pytest.approx(truth.mean(), rel=0.02)


def test_a_resumed_render_chooses_by_what_was_learned(lamps, tmp_path, monkeypatch):
    path, settings = tmp_path / "state.ckpt", {"guide": True, "criterion": "fused"}
    straight = render(lamps, **settings)
    stopped = render(lamps, **settings, checkpoint=path, progress=lambda progress: progress.done < 64 * 48 * 20)
    assert not stopped.report.complete
    monkeypatch.setattr(guidance, "learn_lights", None)  # what was learned is in the file
    resumed = render(lamps, **settings, checkpoint=path, resume=True)
    assert np.array_equal(resumed.image, straight.image)


@pytest.mark.parametrize(("first", "then"), [(False, True), (True, False)])
def test_a_resumed_render_is_guided_if_it_was(lamps, tmp_path, monkeypatch, first, then):
    """Whether it would look for something to learn may have changed, as with the number of samples."""
    path, settings = tmp_path / "state.ckpt", {"criterion": "fused", "size": 128}
    monkeypatch.setattr(guidance, "learns_unasked", lambda *_: first)
    straight = render(lamps, **settings)
    assert any(note.startswith("Guided: ") for note in straight.report.notes) == first
    stopped = render(lamps, **settings, checkpoint=path, progress=lambda progress: progress.done < 128 * 96 * 20)
    assert not stopped.report.complete
    monkeypatch.setattr(guidance, "learns_unasked", lambda *_: then)
    resumed = render(lamps, **settings, checkpoint=path, resume=True)
    assert np.array_equal(resumed.image, straight.image)


def test_the_same_scene_may_be_rendered_with_and_without(lamps):
    first, plain, again = (render(lamps, guide=guide).image for guide in (True, None, True))
    assert np.array_equal(first, again)
    assert not np.array_equal(first, plain)


@pytest.mark.parametrize("kinds", [(), ("point",), ("sun",)], ids=str)
def test_where_there_is_nothing_to_choose_nothing_is_learned(kinds, monkeypatch):
    monkeypatch.setattr(guidance, "recorded_training", None)
    scene = scene_with_lights(*kinds)
    result = render(scene, guide=True)
    assert not any(note.startswith("Guided") for note in result.report.notes)
    assert np.allclose(result.image, render(scene).image, rtol=1e-4, atol=1e-5)


def test_where_nothing_is_gained_it_draws_as_path(monkeypatch):
    """Two lamps at nearly the same place: to know which is which gains nothing."""
    monkeypatch.setattr(guidance, "is_worth_a_look", lambda *_: True)
    scene = scene_with_lights(
        light0={"type": "point", "position": [0, 0, 3.0]}, light1={"type": "point", "position": [0.1, 0, 3.0]}
    )
    result = render(scene, guide=True, spp=512)
    assert result.report.seconds_guiding > 0.01
    assert result.report.notes == [NOT_WORTH_IT]
    assert np.allclose(result.image, render(scene, spp=512).image, rtol=1e-4, atol=1e-5)


def test_a_small_picture_of_few_lights_is_not_worth_a_look():
    scene = scene_with_lights("point", "sphere")
    assert render(scene, guide=True, spp=64).report.seconds_guiding < 0.01


@pytest.mark.parametrize(
    ("kinds", "size", "settings", "learns"),
    [
        (("point", "sphere"), 64, {}, False),  # to look would be felt
        (("point", "sphere"), 1280, {}, True),
        (("point", "sphere"), 1280, {"spp": 16}, False),
        (LAMPS, 256, {}, True),  # there is much to be gained
        (LAMPS, 192, {}, False),
        ((), 1280, {}, False),
        (("point", "sphere"), 1280, {"guide": False}, False),
        (LAMPS, 320, {"guide": False}, False),
        (LAMPS, 320, {"time": 20}, False),
        (LAMPS, 640, {"time": 100}, True),
        (LAMPS, 320, {"criterion": "uniform"}, False),
    ],
    ids=str,
)
def test_unasked_it_learns_where_that_may_pay(kinds, size, settings, learns):
    with open_scene(scene_with_lights(*kinds), 0, None, size) as view:
        assert guidance.learns_unasked(view, make_settings(**{"spp": 64, **settings})) == learns


@pytest.mark.slow
def test_the_default_is_guided_where_there_are_many_lights():
    lamps = scene_with_lights("sphere", *["far lamp"] * 79, integrator={"type": "path", "hide_emitters": True})
    asked = {"criterion": "fused", "size": 320}
    default = render(lamps, **asked)
    assert any(note.startswith("Guided: ") for note in default.report.notes)
    assert np.array_equal(default.image, render(lamps, **asked, guide=True).image)
    plain = render(lamps, **asked, guide=False)
    assert not any(note.startswith("Guided: ") for note in plain.report.notes)
    assert not np.array_equal(default.image, plain.image)


FOG = {"type": "cube", "bsdf": {"type": "null"}, "interior": {"type": "homogeneous", "sigma_t": 0.2}}
"""A box around the middle of a scene, with a medium in it."""
OTHERS = [
    (
        {"type": "volpath"},
        {"fog": FOG},
        "only the integrators 'path' and 'guided' learn about lights, and this is 'volpath'.",
    ),
    (
        {"type": "volpath"},
        {},
        "only the integrators 'path' and 'guided' learn about lights, and this is 'volpath'; the scene has no medium, "
        "so 'path' has the same expected picture.",
    ),
    ({"type": "prb"}, {}, "only the integrators 'path' and 'guided' learn about lights, and this is 'prb'."),
    (
        {"type": "aov", "aovs": "z:depth", "image": {"type": "path"}},
        {},
        "within 'aov' only the integrator 'guided' learns about lights; name it there instead of 'path'.",
    ),
]
"""Integrators other than path, what else there is, and why they do not learn."""


@pytest.mark.parametrize(("integrator", "more", "why"), OTHERS, ids=["medium", "no medium", "prb", "aov"])
def test_other_integrators_draw_as_they_do_and_say_so(integrator, more, why):
    scene = scene_with_lights("area", "point", integrator=integrator, **more)
    result = render(scene, guide=True, spp=16)
    assert result.report.notes == [f"Not guided: {why}"]
    assert np.array_equal(result.image, render(scene, spp=16).image)


def test_within_aov_it_learns(lamps):
    """It makes the same picture as alone, whether anything was recorded before, and leaves nothing behind."""
    guided = {"type": "guided", "max_depth": 3, "hide_emitters": True}
    nested = mi.load_dict({"type": "aov", "aovs": "z:depth", "image": guided})
    for seed in (3, 4):
        found, alone = (render(lamps, integrator=integrator, seed=seed) for integrator in (nested, guided))
        assert any(note.startswith("Guided: ") for note in found.report.notes)
        assert found.report.notes == alone.report.notes
        assert np.array_equal(found.image[..., :3], alone.image)
        assert found.image.shape[-1] == 8  # those of the film, of the nested integrator, and the depth
    plain = render(lamps, integrator=nested, seed=3, guide=False).image
    assert np.allclose(plain[..., :3], render(lamps, seed=3).image, rtol=1e-4, atol=1e-5)


def test_the_integrator_asks_for_it(lamps):
    asked = render(lamps, integrator={"type": "guided", "max_depth": 3, "hide_emitters": True})
    assert np.array_equal(asked.image, render(lamps, guide=True).image)
    refused = render(lamps, integrator={"type": "guided", "max_depth": 3, "hide_emitters": True}, guide=False)
    assert np.allclose(refused.image, render(lamps).image, rtol=1e-4, atol=1e-5)


def test_within_adaptive_it_learns():
    lamps = scene_with_lights(*LAMPS, size=(48, 36), integrator={"type": "path", "max_depth": 3, "hide_emitters": True})
    nested = {"type": "guided", "max_depth": 3, "hide_emitters": True}
    adaptive = mi.load_dict({"type": "adaptive", "criterion": "uniform", "nested": nested})
    picture = np.array(mi.render(lamps, integrator=adaptive, spp=256))
    assert any(note.startswith("Guided: ") for note in adaptive.result.report.notes)
    assert picture.mean() == pytest.approx(render(lamps, spp=1024).image.mean(), rel=0.05)


def test_paths_without_a_limit_and_with_one_are_told_from_text():
    for depth in (-1, 7):
        guided = guidance.guided_like(mi.load_dict({"type": "path", "max_depth": depth, "rr_depth": 4}), False)
        assert f"max_depth = {depth}" in str(guided)
        assert "rr_depth = 4" in str(guided)


def test_weights_that_a_person_gave_to_lights_are_kept():
    lights = {
        f"light{k}": {
            "type": "point",
            "position": [0.05 * k, 0, 2.0],
            "intensity": 0.1,
            "sampling_weight": 0.0 if k else 1.0,
        }
        for k in range(20)
    }
    scene = scene_with_lights(**lights)
    result = render(scene, guide=True)
    assert not any(note.startswith("Guided") for note in result.report.notes)
    assert np.allclose(result.image, render(scene).image, rtol=1e-4, atol=1e-5)


def test_after_a_change_of_the_integrator_it_is_as_it_says(lamps):
    shown = scene_with_lights(*LAMPS)
    before = render(shown, guide=True).image
    shown.integrator().hide_emitters = True
    after = render(shown, guide=True).image
    assert np.max(before) > 2 * np.max(after)

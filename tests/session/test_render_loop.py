"""The loop: exact budgets, bounds, repeatability, sources, stopping."""

import dataclasses
import gc
import weakref

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest

import tracer
from tracer import criteria
from tracer.adaptive import prediction
from tracer.errors import SettingsError
from tracer.report import empty_pixels
from tracer.scene.view import open_scene
from tracer.session.render import begun, complete, render_request
from tracer.session.render_loop import Rendering
from tracer.session.request import Request

ALL = ["face_entropy", "fused", "shape_entropy", "uniform", "variance"]


@pytest.mark.parametrize("criterion", ALL)
@pytest.mark.parametrize("spp", [1, 5, 16, 37])
def test_budget_is_spent_exactly(cornell, criterion, spp):
    result = tracer.render(cornell(), spp=spp, criterion=criterion)
    assert result.samples.sum() == spp * result.samples.size
    assert result.samples.min() >= 1
    assert sum(one.samples for one in result.report.rounds) == spp * result.samples.size
    assert result.report.complete


def test_what_a_result_holds(cornell):
    result = tracer.render(cornell(pixel_format="rgba"), spp=32)
    assert result.image.shape == result.stderr.shape == (16, 24, 4)
    assert result.samples.shape == result.complexity.shape == (16, 24)
    kinds = (result.image.dtype, result.samples.dtype, result.stderr.dtype, result.complexity.dtype)
    assert kinds == (np.float32, np.uint32, np.float32, np.float32)
    assert result.channels == ["R", "G", "B", "A"]
    assert result.complexity.max() > 0.5
    assert result.seconds > 0
    assert "<img" in result._repr_html_()


def test_criteria_are_found_by_themselves():
    assert set(ALL) <= set(criteria.names())


def test_bounds_are_kept(cornell):
    result = tracer.render(cornell(), spp=32, min_spp=20, max_spp=40, criterion="variance")
    assert result.samples.min() >= 20
    assert result.samples.max() <= 40
    assert np.ptp(result.samples) > 0


def test_seeds_repeat_and_differ(cornell):
    first, again, other = (tracer.render(cornell(), spp=16, seed=seed) for seed in (1, 1, 2))
    assert np.array_equal(first.samples, again.samples)
    assert first.image == pytest.approx(again.image, rel=1e-6, abs=1e-7)
    assert not np.allclose(first.image, other.image)


def test_uniform_is_the_picture_of_mitsuba_with_the_same_sampler(cornell):
    scene = cornell()
    scene["sensor"]["sampler"] = {"type": "owen_sobol", "sample_count": 16}
    expected = np.array(mi.render(mi.load_dict(scene), spp=16, seed=5))
    result = tracer.render(scene, spp=16, seed=5, criterion="uniform")
    assert result.image == pytest.approx(expected, rel=1e-4, abs=1e-4)
    assert np.all(result.samples == 16)


def test_path_dictionary_and_scene_are_the_same(tmp_path, cornell):
    path = tmp_path / "cornell.xml"
    state = mi.parser.parse_dict(mi.parser.ParserConfig(mi.variant()), cornell())
    mi.parser.write_file(state, str(path))
    pictures = [tracer.render(s, spp=8, seed=1).image for s in (cornell(), str(path), path, mi.load_dict(cornell()))]
    for picture in pictures[1:]:
        assert picture == pytest.approx(pictures[0], rel=1e-3, abs=1e-4)


def test_size_sensor_and_integrator(cornell):
    scene = cornell()
    scene["second"] = scene["sensor"] | {"film": scene["sensor"]["film"] | {"width": 10, "height": 6}}
    assert tracer.render(scene, spp=1, sensor=1).image.shape == (6, 10, 3)
    assert tracer.render(scene, spp=1, size=12).image.shape == (8, 12, 3)
    direct = tracer.render(scene, spp=64, integrator="direct").image
    assert direct.mean() < tracer.render(scene, spp=64).image.mean()


def test_progress_is_told_and_can_stop(cornell):
    told = []
    tracer.render(cornell(), spp=16, progress=told.append)
    assert [one.done for one in told] == sorted(one.done for one in told)
    assert told[-1].done == told[-1].total == 16 * 24 * 16
    stopped = tracer.render(cornell(), spp=64, progress=lambda one: False)
    assert not stopped.report.complete
    assert "Stopped after" in stopped.report.notes[-1]
    assert stopped.samples.sum() < 64 * 24 * 16
    assert np.all(np.isfinite(stopped.image))
    assert stopped.image.mean() > 0.05


def test_a_scene_with_nothing_to_gain_is_rendered_uniformly():
    sky = {"type": "constant", "radiance": 0.5}
    film = {"type": "hdrfilm", "width": 16, "height": 16}
    result = tracer.render({"type": "scene", "sky": sky, "sensor": {"type": "perspective", "film": film}}, spp=32)
    assert np.ptp(result.samples) == 0
    assert "to adapt the rest would gain a factor of 1.000" in result.report.notes[0]
    assert len(result.report.rounds) == 2
    assert result.image == pytest.approx(np.full((16, 16, 3), 0.5), rel=1e-5)
    assert result.stderr.max() < 1e-6


def test_thin_things_get_more_samples_than_the_sky():
    rod = {"type": "cylinder", "p0": [0, -2, 0], "p1": [0, 2, 0], "radius": 0.02}
    camera = mi.ScalarTransform4f().look_at([0, 0, 4], [0, 0, 0], [0, 1, 0])
    sensor = {"type": "perspective", "to_world": camera, "film": {"type": "hdrfilm", "width": 33, "height": 33}}
    scene = {"type": "scene", "i": {"type": "path"}, "rod": rod, "sky": {"type": "constant"}, "sensor": sensor}
    scene["rod"] |= {"bsdf": {"type": "diffuse", "reflectance": 0.1}}
    samples = tracer.render(scene, spp=64).samples
    assert samples[:, 15:18].mean() > 4 * samples[:, :10].mean()


def test_too_small_a_budget_is_uniform_and_says_so(cornell):
    result = tracer.render(cornell(), spp=7)
    assert np.ptp(result.samples) == 0
    assert "Uniform: 7 spp leave nothing to decide" in result.report.notes[0]


def test_too_many_shapes_for_a_small_picture_are_uniform_and_it_says_so(cornell, monkeypatch):
    monkeypatch.setattr(prediction, "WORK_OF_OBJECT", 1e3)
    result = tracer.render(cornell(), spp=64)
    assert np.ptp(result.samples) == 0
    assert "Uniform: with 9 shapes and lights, a decision takes" in result.report.notes[0]
    assert np.ptp(tracer.render(cornell(), spp=64, pilot_spp=8).samples) > 0


def test_kernels_are_compiled_in_the_first_render_only(cornell):
    with open_scene(cornell()) as view:
        for spp in (64, 32):
            render_request(Request(view, {"spp": spp}))
        dr.kernel_history_clear()
        with dr.scoped_set_flag(dr.JitFlag.KernelHistory):
            for spp, seed in ((64, 1), (48, 2), (200, 3)):
                render_request(Request(view, {"spp": spp, "seed": seed}))
        compiled = [kernel for kernel in dr.kernel_history() if kernel["type"] == dr.KernelType.JIT]
    assert len(compiled) > 20
    missed = [(kernel["size"], kernel["operation_count"]) for kernel in compiled if not kernel["cache_hit"]]
    # Dr.Jit finds one loop of the path tracer now with, now without three of its unchanging variables.
    assert len(missed) <= 1, missed


def test_samples_that_decide_are_not_in_an_unbiased_picture(cornell):
    result = tracer.render(cornell(), spp=64, unbiased=True)
    assert [one.samples for one in result.report.rounds] == [2 * 384, 2 * 384, 60 * 384]
    assert result.samples.sum() == 60 * 384
    assert tracer.render(cornell(), spp=8, unbiased=True, min_spp=1, pilot_spp=1).samples.min() == 1
    assert "4 samples per pixel decided and are not in the picture" in " ".join(result.report.notes)
    assert np.ptp(result.samples) > 0
    assert tracer.render(cornell(), spp=31, unbiased=True).samples.min() == 31
    without_radiance = tracer.render(cornell(), spp=16, unbiased=True, criterion="shape_entropy")
    assert without_radiance.samples.sum() == 16 * 384


def test_pixels_without_a_finite_sample_are_named():
    empty = np.zeros((4, 5), bool)
    assert empty_pixels(empty) == ""
    empty[2, 3] = True
    assert empty_pixels(empty).endswith("or black: (3, 2)")
    assert empty_pixels(np.ones((4, 5), bool)).endswith("(2, 1) and 12 more")


def test_a_render_lets_go_of_its_scene(cornell):
    views = []
    for _ in range(3):
        with open_scene(cornell()) as view:
            render_request(Request(view, {"spp": 16}))
            views.append(weakref.ref(view))
        del view
        gc.collect()
    assert [view() for view in views] == [None] * 3


def test_a_stopped_unbiased_picture_has_no_holes(cornell, monkeypatch):
    monkeypatch.setattr("tracer.sampling.passes.PASS_SIZES", (1000, 1000, 1000))
    with open_scene(cornell()) as view:
        request = Request(view, {"spp": 64, "unbiased": True}, progress=lambda now: now.done < 0.3 * now.total)
        with begun(request, view) as rendering:
            rendering.drawer.pass_size = 1000
            result = complete(rendering, request)
    assert not result.report.complete
    assert result.samples.min() >= 4
    assert "Not unbiased" in " ".join(result.report.notes)


def test_least_samples_hold_in_an_unbiased_picture(cornell):
    assert tracer.render(cornell(), spp=64, unbiased=True, min_spp=40).samples.min() >= 40
    with pytest.raises(SettingsError, match="min_spp"):
        tracer.render(cornell(), spp=64, unbiased=True, min_spp=62)


def test_luminance_is_that_of_the_films_channels(cornell):
    found = {}
    for pixel_format in ("rgb", "xyza", "luminance"):
        with open_scene(cornell(pixel_format=pixel_format)) as view:
            found[pixel_format] = view.luminance(
                render_request(Request(view, {"spp": 16, "criterion": "uniform"})).image
            )
    for pixel_format in ("xyza", "luminance"):
        assert found[pixel_format] == pytest.approx(found["rgb"], rel=1e-3, abs=1e-4)


def test_a_criterion_sees_the_moments_that_it_asks_for(cornell):
    seen = []

    def moments(colour, index):
        return [colour[0] * colour[0], mi.Float(index)], [colour[1]]

    @criteria.criterion("made up for moments", needs_radiance=True, moments=moments)
    def made_up(evidence):
        seen.append(evidence.statistics)
        return np.ones_like(evidence.weight)

    try:
        tracer.render(cornell(), spp=16, criterion="made up for moments")
    finally:
        del criteria.registry.registered["made up for moments"]
    known = seen[0]
    count, mean = known.count[..., None].astype(np.float64), known.mean.astype(np.float64)
    square = known.variance * (count - 1) / count + mean**2
    assert known.moments[..., 0] == pytest.approx(square[..., 0], rel=1e-4, abs=1e-6)
    assert np.all(known.moments[..., 1] == 1.5)
    assert np.all(known.peaks[..., 0] >= known.mean[..., 1] * (1 - 1e-6))
    assert np.all(known.peaks[..., 0] <= known.mean[..., 1] * 4.0001)
    assert known.work.min() >= 1
    assert known.work.max() > 3


def test_a_preview_that_cannot_be_written_does_not_end_the_render(cornell, tmp_path):
    def preview(now):
        mi.util.write_bitmap(str(tmp_path / "nowhere" / "preview.exr"), mi.TensorXf(now.image))  # asynchronous

    result = tracer.render(cornell(), spp=8, progress=preview)
    assert result.report.complete
    assert any("asynchronously cannot be written" in sentence for sentence in result.report.unwritten)


def test_a_render_under_way_is_few_things():
    assert len(dataclasses.fields(Rendering)) <= 8

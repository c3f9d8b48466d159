"""Measurements and their summaries."""

import numpy as np
import pytest

from conftest import LIT
from tracer import loop
from tracer.study import reference as references
from tracer.study import table
from tracer.study.compare import Measurement, interval, judge, measure
from tracer.study.run import scene_name

BALL = '<shape type="sphere"><point name="center" x="0.3" y="0" z="4"/></shape>'


def test_interval_is_students_on_logarithms():
    found = interval([1.0, 2.0, 4.0])
    half = 4.302653 * np.log(2) / np.sqrt(3)
    assert found.mean == pytest.approx(2)
    assert found.low == pytest.approx(2 * np.exp(-half), rel=1e-5)
    assert found.high == pytest.approx(2 * np.exp(half), rel=1e-5)
    assert np.isnan(interval([3.0]).low)


def one(method, seed, error, samples=100, seconds=1.0):
    return Measurement("s", method, 4, seed, error, error, 20.0, 0.9, samples, seconds)


def test_gains_are_per_sample_and_per_second():
    measurements = [one("uniform", 0, 0.2), one("fused", 0, 0.1, samples=200, seconds=4.0)]
    row = next(row for row in table.rows(measurements) if row.method == "fused")
    assert row.gain_samples.mean == pytest.approx(1.0)
    assert row.gain_time.mean == pytest.approx(0.5)
    assert "| s | 4 | fused |" in table.markdown([row])


def test_overall_is_the_geometric_mean_over_scenes():
    measurements = [one("uniform", 0, 0.4), one("fused", 0, 0.1)]
    other = [Measurement("t", *(getattr(m, f) for f in list(vars(m))[1:])) for m in measurements]
    other[1] = Measurement("t", "fused", 4, 0, 0.4, 0.4, 20.0, 0.9, 100, 1.0)
    means = {method: samples.mean for _, method, samples, _ in table.overall(table.rows(measurements + other))}
    assert means == {"uniform": pytest.approx(1), "fused": pytest.approx(2)}


def test_every_method_is_measured_with_every_seed(scene_file):
    scene = scene_file(LIT + BALL)
    truth = references.reference(scene, 64)
    found = measure(scene, "ball", truth.image, [4, 9], range(2), ["variance"])
    methods = {"uniform", "variance", "independent", "multijitter"}
    assert {(m.method, m.spp, m.seed) for m in found} == {(m, b, s) for m in methods for b in (4, 9) for s in (0, 1)}
    used = {m.samples for m in found if m.method == "multijitter" and m.spp == 9}
    assert used == {12 * 8 * 9}
    assert all(m.seconds > 0 and m.relative_mse > 0 for m in found)


def test_a_perfect_picture():
    picture = np.random.default_rng(0).random((8, 8, 3)).astype(np.float32)
    found = judge("s", "m", 1, 0, picture, picture, 64, 1.0)
    assert (found.mse, found.relative_mse, found.ssim) == (0, 0, pytest.approx(1))


def test_references_are_kept_by_content_and_settings(scene_file, monkeypatch):
    scene = scene_file(LIT)
    first = references.reference(scene, 16)

    def refuse(*arguments, **options):
        raise AssertionError("rendered although it was kept")

    monkeypatch.setattr(references, "render", refuse)
    kept = references.reference(scene, 16)
    assert np.array_equal(first.image, kept.image)
    assert kept.image.shape == (8, 12, 3)
    for change in ({"spp": 17}, {"spp": 16, "size": 6}, {"spp": 16, "integrator": "direct"}):
        with pytest.raises(AssertionError, match="although it was kept"):
            references.reference(scene, **change)
    scene.write_text(scene.read_text() + " ")
    with pytest.raises(AssertionError, match="although it was kept"):
        references.reference(scene, 16)


def test_half_a_reference_is_not_kept(scene_file):
    scene = scene_file(LIT)
    with pytest.raises(KeyboardInterrupt):
        references.reference(scene, 40000, progress=lambda progress: False)
    assert not list(references.cache_folder().rglob("*.exr"))
    assert references.reference(scene, 16).image.shape == (8, 12, 3)


def test_scene_names(tmp_path):
    assert scene_name(tmp_path / "dining-room" / "scene.xml") == "dining-room"
    assert scene_name(tmp_path / "rods.xml") == "rods"


def test_loop_and_reference_share_one_render():
    assert references.render is loop.render

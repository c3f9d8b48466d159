"""A render that goes on from its checkpoint is the one that was never stopped; a checkpoint of another is refused."""

import json
from dataclasses import replace

import mitsuba as mi
import numpy as np
import pytest

import tracer
from conftest import files_of_at_most
from tracer.errors import CheckpointError, OutputError
from tracer.session import checkpoint
from tracer.session.merge import merge

SETTINGS = {"spp": 32, "seed": 3}


@pytest.fixture
def small_passes(monkeypatch):
    """Make passes so small that a render has dozens of them."""
    monkeypatch.setattr("tracer.sampling.passes.PASS_SIZES", (500, 500, 500))
    monkeypatch.setattr("tracer.session.local_drawer.PASS_SIZES", (500, 500, 500))


def stop_after(samples):
    return lambda now: now.done < samples


def same(one, other):
    for name in ("image", "samples", "stderr", "complexity", "importance", "cost"):
        assert np.array_equal(getattr(one, name), getattr(other, name)), name


@pytest.mark.parametrize(
    "settings",
    [{}, {"criterion": "rigau"}, {"unbiased": True, "spp": 64}, {"noise": 0.3}, {"denoise": True}],
)
@pytest.mark.parametrize("part", [0.02, 0.15, 0.3, 0.7, 0.9])
def test_a_resumed_render_is_the_one_that_was_never_stopped(cornell, tmp_path, small_passes, settings, part):
    settings = SETTINGS | settings
    whole = tracer.render(cornell(), **settings)
    path = tmp_path / "state.ckpt"
    drawn = sum(one.samples for one in whole.report.rounds)
    first = tracer.render(cornell(), progress=stop_after(part * drawn), checkpoint=path, **settings)
    assert first.report.stopped_by == "person"
    resumed = tracer.render(cornell(), checkpoint=path, resume=True, **settings)
    assert resumed.report.complete
    same(resumed, whole)
    assert [one.samples for one in resumed.report.rounds] == [one.samples for one in whole.report.rounds]
    assert [note for note in resumed.report.notes if "Stopped" in note] == []


def test_features_are_drawn_once(cornell, tmp_path, monkeypatch):
    path = tmp_path / "state.ckpt"
    tracer.render(cornell(), spp=16, checkpoint=path)
    monkeypatch.setattr("tracer.session.render.draw_denoising_features", None)
    monkeypatch.setattr("tracer.session.develop.draw_denoising_features", None)
    resumed = tracer.render(cornell(), spp=32, checkpoint=path, resume=True, denoise=True)
    assert resumed.noisy is not None


def test_a_larger_budget_goes_on_where_the_smaller_ended(cornell, tmp_path):
    path = tmp_path / "state.ckpt"
    tracer.render(cornell(), spp=32, seed=3, checkpoint=path)
    more = tracer.render(cornell(), spp=64, seed=3, checkpoint=path, resume=True)
    same(more, tracer.render(cornell(), spp=64, seed=3))
    again = tracer.render(cornell(), spp=64, seed=3, checkpoint=path, resume=True)  # nothing is left to do
    assert np.array_equal(again.image, more.image)


def test_another_budget_may_end_within_the_round_that_was_under_way(cornell, tmp_path, small_passes):
    path = tmp_path / "state.ckpt"
    pixels = 24 * 16
    stopped = tracer.render(cornell(), criterion="uniform", spp=32, progress=stop_after(10 * pixels), checkpoint=path)
    done = int(stopped.samples.sum())
    assert 10 * pixels <= done < 12 * pixels
    resumed = tracer.render(cornell(), criterion="uniform", spp=16, checkpoint=path, resume=True)
    assert resumed.samples.sum() == 16 * pixels
    assert resumed.samples.max() == 32  # drawn before
    fewer = tracer.render(cornell(), criterion="uniform", spp=4, checkpoint=path, resume=True)
    assert fewer.samples.sum() == 16 * pixels


def test_without_a_checkpoint_there_is_nothing_to_resume_and_all_is_done(cornell, tmp_path):
    path = tmp_path / "state.ckpt"
    same(tracer.render(cornell(), spp=8, checkpoint=path, resume=True), tracer.render(cornell(), spp=8))
    assert path.exists()
    with pytest.raises(OutputError, match=r"state\.ckpt' exists"):
        tracer.render(cornell(), spp=8, checkpoint=path)


def brighter(scene):
    scene["light"]["emitter"]["radiance"]["value"] = [20.0, 15.0, 10.0]
    return scene


@pytest.mark.parametrize(
    ("change", "settings", "message"),
    [
        (lambda scene: scene, {"seed": 4}, "seed 3 there and 4 here"),
        (lambda scene: scene, {"criterion": "variance"}, "criterion fused there and variance here"),
        (lambda scene: scene, {"size": 12}, r"size \[24, 16\] there and \[12, 8\] here"),
        (lambda scene: scene, {"integrator": "direct"}, "another integrator"),
        (lambda scene: scene, {"importance": np.eye(16, 24)}, "another importance"),
        (brighter, {}, "another scene"),
    ],
)
def test_a_checkpoint_of_another_render_is_refused(cornell, tmp_path, change, settings, message):
    path = tmp_path / "state.ckpt"
    tracer.render(cornell(), checkpoint=path, **SETTINGS)
    before = path.read_bytes()
    with pytest.raises(CheckpointError, match=message):
        tracer.render(change(cornell()), checkpoint=path, resume=True, **SETTINGS | settings)
    assert path.read_bytes() == before


def test_another_version_is_refused(cornell, tmp_path, monkeypatch):
    path = tmp_path / "state.ckpt"
    tracer.render(cornell(), checkpoint=path, **SETTINGS)
    monkeypatch.setattr(checkpoint, "release", lambda: "99")
    with pytest.raises(CheckpointError, match=r"version 0\.1\.0 there and 99 here"):
        tracer.render(cornell(), checkpoint=path, resume=True, **SETTINGS)


def test_damage_is_noticed_wherever_it_is(cornell, tmp_path):
    path = tmp_path / "state.ckpt"
    tracer.render(cornell(size=(4, 4)), spp=8, checkpoint=path)
    whole = path.read_bytes()
    random = np.random.default_rng(0)
    undamaged = checkpoint.read(path)
    for k in range(300):
        damaged = bytearray(whole)
        place = int(random.integers(len(whole)))
        if k % 3:
            damaged[place] ^= int(random.integers(1, 256))
        else:
            del damaged[place:]
        path.write_bytes(damaged)
        try:
            found = checkpoint.read(path)
        except CheckpointError as error:
            assert "damaged" in str(error)  # noqa: PT017
        else:  # bytes that nobody reads, such as a date
            assert json.dumps(found.plain) == json.dumps(undamaged.plain)
            assert all(np.array_equal(found.arrays[name], array) for name, array in undamaged.arrays.items())


def test_a_checkpoint_that_cannot_be_written_does_not_stop_the_render(cornell, tmp_path, monkeypatch):
    path = tmp_path / "state.ckpt"
    tracer.render(cornell(), spp=8, checkpoint=path)
    before = path.read_bytes()

    def full(*arguments, **keywords):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(np, "savez", full)
    result = tracer.render(cornell(), spp=16, checkpoint=path, resume=True)
    assert result.report.complete
    assert "No space left on device" in result.report.notes[-1]
    assert "could be written is still there, with 50 % of the samples" in result.report.notes[-1]
    assert result.report.unwritten == result.report.notes[-1:]
    assert path.read_bytes() == before
    assert [each.name for each in tmp_path.iterdir()] == ["state.ckpt"]


def test_a_checkpoint_that_may_not_be_read_is_not_called_damaged(tmp_path, monkeypatch):
    path = tmp_path / "state.ckpt"
    path.touch()

    def refuse(*arguments):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr("zipfile.ZipFile", refuse)
    with pytest.raises(CheckpointError, match=r"Cannot read '.*state\.ckpt': Permission denied"):
        checkpoint.read(path)


@pytest.mark.parametrize(
    ("before", "overwrite", "said"),
    [(None, False, "There is no checkpoint."), ("another", True, "before is still there")],
)
def test_what_was_never_there_is_not_promised(cornell, tmp_path, before, overwrite, said):
    path = tmp_path / "state.ckpt"
    if before is not None:
        path.write_text(before)
    scene = tracer.scene.load.load(cornell())  # before files may be no larger, as compiling needs some
    tracer.render(scene, spp=2)
    with files_of_at_most(2000):
        result = tracer.render(scene, spp=2, checkpoint=path, overwrite=overwrite)
    (complaint,) = result.report.unwritten
    assert complaint.startswith(f"Cannot write '{path}': File too large. ")
    assert said in complaint
    assert "could be written" not in complaint
    assert [entry.name for entry in tmp_path.iterdir()] == ([path.name] if before else [])


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"size": 12}, r"another render: size \[24, 16\] there and \[12, 8\] here\. Resume"),
        ({"crop": (1, 2, 8, 8)}, r"another render: crop \[0, 0, 24, 16\] there and \[1, 2, 8, 8\] here\. Resume"),
        (
            {"size": 12, "seed": 4},
            r"render: size \[24, 16\] there and \[12, 8\] here; seed 3 there and 4 here\. Resume",
        ),
        ({"importance": np.eye(16, 24)}, r"another render: another importance\. Resume"),
    ],
)
def test_only_what_really_differs_is_named(cornell, tmp_path, settings, message):
    path = tmp_path / "state.ckpt"
    tracer.render(cornell(), checkpoint=path, **SETTINGS)
    with pytest.raises(CheckpointError, match=message):
        tracer.render(cornell(), checkpoint=path, resume=True, **SETTINGS | settings)


def test_a_camera_that_prints_alike_is_another_one(cornell, tmp_path):
    def camera(x):
        film = {"type": "hdrfilm", "width": 6, "height": 4}
        to_world = mi.ScalarTransform4f().look_at([x, 0, 4], [x, 0, 0], [0, 1, 0])
        return mi.load_dict({"type": "perspective", "to_world": to_world, "film": film})

    near, far = camera(2000.004), camera(1999.996)
    assert str(near) == str(far)
    scene, path = mi.load_dict(cornell(size=(6, 4))), tmp_path / "state.ckpt"
    tracer.render(scene, sensor=near, spp=4, checkpoint=path)
    with pytest.raises(CheckpointError, match="another sensor"):
        tracer.render(scene, sensor=far, spp=8, checkpoint=path, resume=True)


SHAPED = ["before.mean", "before.count", "unbiased.total", "unbiased.weight", "chance", "features.albedo"]


@pytest.mark.parametrize("name", SHAPED)
@pytest.mark.parametrize("shape", [lambda array: array[..., None], lambda array: array[:-1], lambda array: array[0]])
def test_an_array_of_another_shape_is_damage(cornell, tmp_path, name, shape):
    path = tmp_path / "state.ckpt"
    tracer.render(cornell(size=(12, 8)), spp=16, checkpoint=path)
    kept = checkpoint.read(path)
    checkpoint.write(replace(kept, arrays={**kept.arrays, name: shape(kept.arrays[name])}))
    with pytest.raises(CheckpointError, match="damaged"):
        tracer.render(cornell(size=(12, 8)), spp=32, checkpoint=path, resume=True)
    with pytest.raises(CheckpointError, match="damaged"):
        merge([path])

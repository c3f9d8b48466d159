"""Parts add up to the whole, and share no samples."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import tracer
from tracer.errors import CheckpointError, SettingsError
from tracer.io.exr import read_metadata
from tracer.jobs.job import make_job
from tracer.jobs.run import perform
from tracer.session import checkpoint, merge
from tracer.session.shards import Part, missing, parse_part, settings_of_part
from tracer.settings import make_settings


@given(st.integers(1, 500), st.integers(1, 60), st.integers(0, 2**32 - 1))
def test_shares_add_up_and_seeds_differ(spp, total, seed):
    settings = make_settings(spp=spp, seed=seed)
    if spp < total:
        with pytest.raises(SettingsError, match="cannot be shared"):
            settings_of_part(settings, Part(1, total))
        return
    shares = [settings_of_part(settings, Part(number, total)) for number in range(1, total + 1)]
    assert sum(each["spp"] for each in shares) == spp
    assert len({each["seed"] for each in shares} | {seed}) == total + 1
    assert shares == [settings_of_part(settings, Part(number, total)) for number in range(1, total + 1)]


@pytest.mark.parametrize("text", ["0/8", "9/8", "3", "3/0", "a/b", "-1/3", "1/99999", ""])
def test_what_is_no_part_is_refused(text):
    with pytest.raises(ValueError, match="part: write"):
        parse_part(text)


def test_missing_parts_are_named():
    assert missing(["seed 0, part 1 of 2", "seed 0, part 2 of 2", "seed 4"]) == ""
    assert "1 of 3, 3 of 3 would" in missing(["seed 0, part 2 of 3"])
    assert "and 12 more" in missing([Part(1, 21).source(0)])


def test_bounds_are_shared_too():
    settings = make_settings(spp=64, min_spp=16, max_spp=128)
    assert {name: settings_of_part(settings, Part(2, 4))[name] for name in ("min_spp", "max_spp")} == {
        "min_spp": 4,
        "max_spp": 32,
    }


@pytest.fixture
def parts(scene_file, tmp_path):
    from conftest import LIT

    scene = scene_file(LIT + '<shape type="sphere"/>')

    def render(number, total, **more):
        path = tmp_path / f"part{number}.ckpt"
        given_options = {"scene": scene, "checkpoint": path, "part": f"{number}/{total}", "spp": 33, "seed": 7, **more}
        for _ in perform(make_job(given_options)):
            pass
        return path

    return render


def test_parts_are_merged_to_a_picture_of_all_samples(parts, tmp_path):
    paths = [parts(number, 4) for number in (1, 2, 3, 4)]
    result, whole = merge.merge(paths)
    assert result.samples.sum() == 33 * 96
    assert not any("Not all parts" in note for note in result.report.notes)
    assert whole.sources == [f"seed 7, part {number} of 4" for number in (1, 2, 3, 4)]
    fewer, _ = merge.merge(paths[1:3])
    assert any("1 of 4, 4 of 4" in note for note in fewer.report.notes)
    with pytest.raises(CheckpointError, match="part 2 of 4"):
        merge.merge([paths[1], paths[1]])


def test_a_part_that_was_stopped_goes_on(parts, tmp_path):
    kept = checkpoint.read(parts(1, 2)).arrays
    (tmp_path / "part1.ckpt").unlink()
    job = {"scene": tmp_path / "scene.xml", "checkpoint": tmp_path / "part1.ckpt", "part": "1/2", "spp": 33, "seed": 7}
    (_, stopped), *_ = perform(make_job(job), progress=lambda now: False)
    assert not stopped.report.complete
    again = checkpoint.read(parts(1, 2, resume=True)).arrays
    assert all(np.array_equal(kept[name], again[name]) for name in kept)


def test_a_job_must_write_something(scene_file):
    with pytest.raises(SettingsError, match="nothing would be written"):
        make_job({"scene": scene_file(""), "part": "1/2"})


def test_large_seeds_are_written(cornell, tmp_path):
    from tracer.result import metadata, write_result

    result = tracer.render(cornell(), spp=1, seed=2**32 - 1)
    write_result(tmp_path / "out.exr", result, metadata(result, "0"))
    assert int(read_metadata(tmp_path / "out.exr")["seed"]) == 2**32 - 1
    assert np.isfinite(result.image).all()

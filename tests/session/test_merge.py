"""Merged checkpoints are the mean of their pictures by counts; the same samples twice are refused."""

from dataclasses import replace

import numpy as np
import pytest

import tracer
from tracer.errors import CheckpointError
from tracer.session import checkpoint
from tracer.session.merge import merge


def part(cornell, path, seed, **settings):
    return tracer.render(cornell(filter_name="box"), checkpoint=path, seed=seed, **{"spp": 8} | settings)


def test_a_merge_is_the_mean_by_counts(cornell, tmp_path):
    paths = [tmp_path / f"{k}.ckpt" for k in range(3)]
    budgets = zip(paths, (1, 2, 3), (8, 16, 40), strict=True)
    parts = [part(cornell, path, seed, spp=spp, criterion="shape_entropy") for path, seed, spp in budgets]
    result, whole = merge(paths, tmp_path / "all.ckpt")
    counts = np.stack([each.samples for each in parts]).astype(np.float64)
    images = np.stack([each.image for each in parts])
    expected = (images * counts[..., None]).sum(axis=0) / counts.sum(axis=0)[..., None]
    assert np.array_equal(result.samples, counts.sum(axis=0))
    assert result.image == pytest.approx(expected, rel=1e-5, abs=1e-7)
    assert whole.sources == ["seed 1", "seed 2", "seed 3"]
    assert result.report.settings.spp == 64
    assert result.stderr.mean() < min(each.stderr.mean() for each in parts)


def test_merges_merge(cornell, tmp_path):
    paths = [tmp_path / f"{k}.ckpt" for k in range(3)]
    for seed, path in enumerate(paths):
        part(cornell, path, seed)
    at_once, _ = merge(paths)
    merge(paths[:2], tmp_path / "two.ckpt")
    in_steps, _ = merge([tmp_path / "two.ckpt", paths[2]])
    assert in_steps.image == pytest.approx(at_once.image, rel=1e-6, abs=1e-8)
    assert np.array_equal(in_steps.samples, at_once.samples)
    with pytest.raises(CheckpointError, match="is a merge"):
        tracer.render(cornell(filter_name="box"), checkpoint=tmp_path / "two.ckpt", resume=True, seed=0, spp=8)
    with pytest.raises(CheckpointError, match="seed 1"):
        merge([tmp_path / "two.ckpt", paths[1]])


def test_what_cannot_be_merged(cornell, tmp_path):
    one, other, seven = tmp_path / "one.ckpt", tmp_path / "other.ckpt", tmp_path / "seven.ckpt"
    part(cornell, one, 1)
    part(cornell, other, 2, size=12)
    part(cornell, seven, 1, spp=16)
    with pytest.raises(CheckpointError, match="nothing to merge"):
        merge([])
    with pytest.raises(CheckpointError, match=r"not of the picture of .*size"):
        merge([one, other])
    with pytest.raises(CheckpointError, match=r"holds samples that are in those before it \(seed 1\)"):
        merge([one, seven])
    with pytest.raises(CheckpointError, match="no checkpoint"):
        merge([one, tmp_path / "nothing.ckpt"])


def test_a_filter_wider_than_a_pixel(cornell, tmp_path):
    paths = [tmp_path / f"{seed}.ckpt" for seed in (1, 2)]
    images = [
        tracer.render(cornell(), checkpoint=path, seed=seed, spp=8, criterion="uniform").image
        for seed, path in enumerate(paths, 1)
    ]
    found = merge(paths)[0].image
    assert np.abs(found - np.mean(images, axis=0)).max() < 0.05 * np.abs(images[0] - images[1]).max()


def test_a_merge_is_denoised_like_a_render(cornell, tmp_path):
    pytest.importorskip("mitsuba_oidn")
    scene = cornell(size=(48, 32), filter_name="gaussian")
    path = tmp_path / "one.ckpt"
    rendered = tracer.render(scene, spp=8, seed=3, checkpoint=path, denoise=True)
    alone, _ = merge([path], denoise=True)
    assert np.array_equal(alone.image, rendered.image)
    assert np.array_equal(alone.noisy, rendered.noisy)
    paths = [tmp_path / f"{seed}.ckpt" for seed in range(3)]
    for seed, part_path in enumerate(paths):
        tracer.render(scene, spp=8, seed=seed, checkpoint=part_path)  # nobody has asked for denoising yet
    at_once, _ = merge(paths, denoise=True)
    reference = tracer.render(scene, spp=1024, seed=9, criterion="uniform").image
    errors = [np.mean((image - reference[..., :3]) ** 2) for image in (at_once.image[..., :3], at_once.noisy)]
    assert errors[0] < errors[1]
    merge(paths[:2], tmp_path / "two.ckpt")
    in_steps, _ = merge([tmp_path / "two.ckpt", paths[2]], denoise=True)
    assert in_steps.noisy == pytest.approx(at_once.noisy, rel=1e-5, abs=1e-7)
    assert in_steps.image == pytest.approx(at_once.image, rel=1e-3, abs=1e-4)


@pytest.mark.parametrize("denoise", [False, True])
def test_a_merge_misses_what_denoising_needs(cornell, tmp_path, denoise):
    pytest.importorskip("mitsuba_oidn")
    path = tmp_path / "one.ckpt"
    part(cornell, path, 1)
    stored = checkpoint.read(path)
    without = {name: array for name, array in stored.arrays.items() if not name.startswith("features.")}
    wrong = {**stored.frame, "filter": {**stored.frame["filter"], "variance": float("nan")}}
    for damaged in (replace(stored, arrays=without), replace(stored, frame=wrong)):
        checkpoint.write(damaged)
        with pytest.raises(CheckpointError, match="damaged"):
            merge([path], denoise=denoise)


@pytest.mark.parametrize(
    "wrong", [{"size": (10**9, 10**9)}, {"kinds": (10**9, 0)}, {"reach": 500}, {"kinds": (0,)}, {"size": (16,)}]
)
def test_sums_are_those_of_the_picture_that_a_file_tells(cornell, tmp_path, wrong):
    """Before anything is made of it: nobody has the memory for pictures that a damaged file tells."""
    path = tmp_path / "one.ckpt"
    part(cornell, path, 1)
    stored = checkpoint.read(path)
    no_sums = {name: array for name, array in stored.arrays.items() if not name.startswith("estimate.")}
    for arrays in (stored.arrays, no_sums):
        checkpoint.write(replace(stored, arrays=arrays, frame={**stored.frame, **wrong}))
        with pytest.raises(CheckpointError, match="damaged"):
            merge([path])


def test_a_merge_counts_as_many_renders_as_it_has(cornell, tmp_path):
    """Features of three renders, two of which were merged before, are those of all three at once."""
    paths = [tmp_path / f"{seed}.ckpt" for seed in range(3)]
    for seed, path in enumerate(paths):
        part(cornell, path, seed)
    merge(paths, tmp_path / "all.ckpt")
    merge(paths[:2], tmp_path / "two.ckpt")
    merge([tmp_path / "two.ckpt", paths[2]], tmp_path / "steps.ckpt")
    at_once, in_steps, alone = (
        checkpoint.read(tmp_path / name).arrays for name in ("all.ckpt", "steps.ckpt", "0.ckpt")
    )
    for name in ("features.albedo", "features.normal"):
        assert in_steps[name] == pytest.approx(at_once[name], abs=1e-6)
        assert not np.array_equal(alone[name], at_once[name])

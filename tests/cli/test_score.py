"""``tracer score``: what it prints, and which layers it compares."""

import json

import numpy as np
import pytest


def test_score_prints_what_a_study_measures(tracer_program, tmp_path):
    import json

    from tracer.image.metrics import all_scores
    from tracer.io.exr import write_exr

    generator = np.random.default_rng(0)
    truth = generator.random((16, 24, 3)).astype(np.float32)
    image = truth + 0.05 * generator.standard_normal(truth.shape).astype(np.float32)
    for name, values in (("a.exr", image), ("b.exr", truth)):
        write_exr(tmp_path / name, ["R", "G", "B"], values, {})
    code, out, _ = tracer_program("score", tmp_path / "a.exr", tmp_path / "b.exr", "--json")
    assert code == 0
    assert json.loads(out)[str(tmp_path / "a.exr")] == pytest.approx(vars(all_scores(image, truth)))
    code, out, _ = tracer_program("score", tmp_path / "a.exr", tmp_path / "b.exr")
    assert code == 0
    for word in ("relMSE", "SSIM", "FLIP", "bias"):
        assert word in out


def test_score_takes_a_layer_of_the_pictures_and_the_picture_of_the_reference(tracer_program, tmp_path):
    from tracer.image.metrics import all_scores
    from tracer.io.exr import write_exr

    truth, denoised, noisy, spare = np.random.default_rng(0).random((4, 16, 24, 3)).astype(np.float32)
    own = [*"RGB", *(f"noisy.{channel}" for channel in "RGB")]
    write_exr(tmp_path / "d.exr", own, np.concatenate([denoised, noisy], axis=-1), {})
    write_exr(tmp_path / "ref.exr", ["R", "G", "B"], truth, {})
    write_exr(tmp_path / "deep.exr", own, np.concatenate([truth, spare], axis=-1), {})

    def scored(reference, *options):
        code, out, err = tracer_program("score", tmp_path / "d.exr", tmp_path / reference, "--json", *options)
        assert code == 0, err
        return json.loads(out)[str(tmp_path / "d.exr")], err

    for reference, options, pair, said in (
        (
            "ref.exr",
            ["--layer", "noisy"],
            (noisy, truth),
            f"'noisy' of the pictures against the picture of '{tmp_path}",
        ),
        ("deep.exr", ["--layer", "noisy"], (noisy, spare), f"of the pictures against layer 'noisy' of '{tmp_path}"),
        ("deep.exr", ["--layer", "noisy", "--reference-layer", ""], (noisy, truth), "against the picture of"),
        (
            "deep.exr",
            ["--reference-layer", "noisy"],
            (denoised, spare),
            "The pictures themselves against layer 'noisy'",
        ),
        ("deep.exr", [], (denoised, truth), ""),
    ):
        found, err = scored(reference, *options)
        assert found == pytest.approx(vars(all_scores(*pair))), options
        assert said in err
        assert bool(err) == bool(options)
    for options in (["--layer", "noisi"], ["--reference-layer", "noisi"]):
        code, out, err = tracer_program("score", tmp_path / "d.exr", tmp_path / "deep.exr", *options)
        assert (code, out) == (2, "")
        assert "no layer 'noisi', did you mean 'noisy'" in err

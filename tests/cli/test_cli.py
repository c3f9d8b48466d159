"""The program: what it writes, and one sentence for every mistake."""

import json
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

from conftest import LIT, PATIENCE, SENSOR
from tracer import criteria
from tracer.cli import repeat_option
from tracer.criteria import registry
from tracer.io.exr import read_exr


def test_render_writes_an_exr(tracer_program, scene_file, tmp_path):
    code, out, _ = tracer_program("render", scene_file(LIT), "-o", tmp_path / "out.exr", "--spp", 8, "--size", 6)
    assert code == 0
    assert "6 x 4" in out
    names, values, own = read_exr(tmp_path / "out.exr")
    assert values.shape[:2] == (4, 6)
    assert values[..., names.index("samples.Y")].sum() == 8 * 24
    assert own["complete"] == 1


BAD = [
    (("render", "no.xml", "-o", "out.exr"), 2, "There is no scene file 'no.xml'"),
    (("render", "SCENE", "-o", "no/out.exr"), 2, "There is no folder 'no'"),
    (("render", "SCENE", "-o", "there.exr"), 2, "'there.exr' exists"),
    (("render", "SCENE", "-o", "out.exr", "--spp", "0"), 2, "spp"),
    (("render", "SCENE", "-o", "out.exr", "--spp", "-4"), 2, "spp"),
    (("render", "SCENE", "-o", "out.exr", "--criterion", "fusd"), 2, "did you mean 'fused'"),
    (("render", "SCENE", "-o", "out.exr", "--integrator", "ptracer"), 2, "cannot be sampled pixel by pixel"),
    (("render", "SCENE", "-o", "out.exr", "--integrator", "pth"), 2, "Did you mean 'path'"),
    (("render", "SCENE", "-o", "out.exr", "--sensor", "1"), 2, "There is no sensor 1"),
    (("render", "BROKEN", "-o", "out.exr"), 2, "does not load"),
    (("render", "BLIND", "-o", "out.exr"), 2, "has no sensor"),
    (("render", "SCENE", "-o", "out.exr", "--noise", "0"), 2, "noise: input should be greater than 0"),
    (("render", "SCENE", "-o", "out.exr", "--noise", "0.1", "--unbiased"), 2, "noise cannot be combined"),
    (("render", "SCENE", "-o", "out.exr", "--time", "-1"), 2, "time: input should be greater than 0"),
    (("render", "SCENE", "-o", "out.exr", "--resume"), 2, "name the checkpoint with --checkpoint"),
    (("render", "SCENE", "-o", "out.exr", "--checkpoint", "there.exr"), 2, "'there.exr' exists"),
    (("render", "SCENE", "-o", "out.exr", "--checkpoint", "there.exr", "--resume"), 2, "a damaged one; remove it"),
    (("render", "SCENE", "-o", "out.exr", "--crop", "1,2,3"), 2, "crop: write x,y,width,height"),
    (("render", "SCENE", "-o", "out.exr", "--crop", "10,2,3,4"), 2, "is not within the picture, 12 x 8"),
    (("render", "SCENE", "-o", "out.exr", "--frames", "1-2"), 2, "is the same in every frame"),
    (("render", "SCENE", "-o", "out.exr", "--frames", "2-1"), 2, "frames: write"),
    (("render", "SCENE", "-o", "out.exr", "--define", "x=1"), 2, "unused parameters: - $x=1"),
    (("render", "SCENE", "-o", "out.exr", "--define", "x"), 2, "define: write name=value"),
    (("render", "SCENE", "-o", "out.exr", "--sensor", "first"), 2, "sensor: write numbers from 0"),
    (("render", "SCENE", "-o", "out.exr", "--variant", "llvm_rgb"), 2, "There is no Mitsuba variant"),
    (("render", "SCENE", "-o", "out.exr", "--variant", "llvm_ad_nope"), 2, "There is no Mitsuba variant"),
    (("render", "SCENE", "-o", "out.exr", "--layers", "some"), 2, "layers: input should be 'all' or 'rgb'"),
    (("render", "SCENE", "-o", "out.exr", "--layers", "rgb", "--features"), 2, "features are layers of their own"),
    (("render", "SCENE", "-o", "out.exr", "--noise", "5"), 2, "noise must be below 1"),
    (("render", "SCENE", "-o", "out.exr", "--shape-weight", "lamp=2"), 2, "no shape 'lamp', nor any other"),
    (("render", "SCENE", "-o", "there.exr"), 2, "or --overwrite to replace it"),
    (("render", "SCENE", "-o", "out.exr", "--memory", "0.01"), 2, "memory: this render needs about"),
    (("render", "SCENE", "-o", "out.exr", "--config", "no.toml"), 2, "Cannot read 'no.toml'"),
    (("render", "SCENE", "-o", "out.exr", "--live", "out.exr"), 2, "must end in .png"),
    (("render", "SCENE", "-o", "out.exr", "--tev", "localhost:x"), 2, "tev: write host:port"),
    (("merge", "there.exr", "-o", "out.exr"), 2, "is no checkpoint"),
    (("merge", "no.ckpt", "-o", "out.exr", "--layers", "some"), 2, "layers: write all or rgb (was 'some')"),
    (("radiosity", "SCENE", "-o", "out.exr", "--layers", "some"), 2, "layers: write all or rgb (was 'some')"),
    (("merge", "no.ckpt", "-o", "out.exr"), 2, "There is no checkpoint 'no.ckpt'"),
    (("merge", "there.exr", "-o", "there.exr"), 2, "'there.exr' exists"),
    (("compare", "no.xml"), 2, "there is no scene file"),
    (("compare", "SCENE", "--sensor", "1"), 2, "There is no sensor 1"),
    (("compare", "BLIND"), 2, "has no sensor"),
    (("compare", "SCENE", "--spp", "16", "0"), 2, "a budget must be above 0 (was 0)"),
    (("compare", "SCENE", "--criterion", "nothing"), 2, "there is no criterion"),
    (("compare", "SCENE", "SCENE"), 2, "two scenes are named"),
    (("compare", "SCENE", "--size", "6"), 2, "needs at least 7 a side"),
    (("compare", "SCENE", "-o", "."), 2, "'.' has files that are not from a study, such as"),
    (("compare", "SCENE", "-o", ".", "--overwrite"), 2, "'.' has files that are not from a study, such as"),
    (("study", "smoke", "-o", "."), 2, "'.' has files that are not from a study, such as"),
    (("compare", "SCENE", "--reference-spp", "8"), 2, "reference_spp"),
    (("study", "smke", "-o", "out"), 2, "did you mean 'smoke'"),
    (("study", "no.toml", "-o", "out"), 2, "Cannot read 'no.toml'"),
    (("study", "public", "-o", "out"), 2, "needs the folder of its scenes"),
    (("study", "public", "no", "-o", "out"), 2, "There is no folder 'no'"),
    (("study", "public", ".", "-o", "out"), 2, "study 'public', line 12: there is no scene file"),
    (("study", "smoke", "-o", "no/out"), 2, "There is no folder 'no'"),
    (("study", "smoke", "-o", "there.exr"), 2, "'there.exr' is a file"),
    (("score", "there.exr", "there.exr"), 2, "Cannot read 'there.exr'"),
    (("score", "no.exr", "there.exr"), 2, "Cannot read 'there.exr'"),
    (("demo", "-o", "no"), 2, "There is no folder"),
]


@pytest.mark.parametrize(("arguments", "code", "message"), BAD)
def test_mistakes_are_one_sentence(tracer_program, scene_file, tmp_path, monkeypatch, arguments, code, message):
    files = {
        "SCENE": scene_file(LIT, "lit.xml"),
        "BROKEN": scene_file("<shape>", "broken.xml"),
        "BLIND": scene_file('<integrator type="path"/>', "blind.xml"),
    }
    monkeypatch.chdir(tmp_path)
    (tmp_path / "there.exr").write_text("mine")
    (tmp_path / "results.md").write_text("mine")
    before = sorted(path.name for path in tmp_path.iterdir())
    found, out, err = tracer_program(*(files.get(argument, argument) for argument in arguments))
    assert found == code
    assert out == ""
    assert err.count("\n") == 1
    assert message in err
    assert "Traceback" not in err
    assert sorted(path.name for path in tmp_path.iterdir() if path.name != "cache") == before
    assert (tmp_path / "there.exr").read_text() == (tmp_path / "results.md").read_text() == "mine"


def test_settings_of_the_scenes_integrator_are_the_defaults(tracer_program, scene_file, tmp_path):
    settings = '<integer name="spp" value="5"/><string name="criterion" value="uniform"/>'
    scene = scene_file(LIT.replace('type="path"/>', f'type="adaptive">{settings}</integrator>'))
    code, _, _ = tracer_program("render", scene, "-o", tmp_path / "out.exr")
    assert code == 0
    _, _, own = read_exr(tmp_path / "out.exr")
    assert (own["spp"], own["criterion"]) == (5, "uniform")


def read_samples(path):
    names, values, own = read_exr(path)
    return values[..., names.index("samples.Y")], own


def test_a_farm_renders_parts_and_merges_them(tracer_program, scene_file, tmp_path, monkeypatch):
    scene = scene_file(LIT + '<shape type="sphere"><point name="center" x="0" y="0" z="4"/></shape>')
    parts = [tmp_path / f"{seed}.ckpt" for seed in (1, 2)]
    for seed, part in enumerate(parts, 1):
        code, _, _ = tracer_program(
            "render", scene, "-o", tmp_path / f"{seed}.exr", "--spp", 8, "--seed", seed, "--checkpoint", part, "-q"
        )
        assert code == 0
    code, out, _ = tracer_program("merge", *parts, "-o", tmp_path / "all.exr", "--json")
    assert code == 0
    assert json.loads(out)["notes"] == ["Merged: seed 1; seed 2."]
    counts = [read_samples(tmp_path / name)[0] for name in ("1.exr", "2.exr", "all.exr")]
    assert np.array_equal(counts[0] + counts[1], counts[2])
    assert tracer_program("merge", *parts, "-o", tmp_path / "plain.exr", "--layers", "rgb")[0] == 0
    names, values, _ = read_exr(tmp_path / "plain.exr")
    everything, merged, _ = read_exr(tmp_path / "all.exr")
    assert names == ["R", "G", "B"]
    assert np.array_equal(values, merged[..., [everything.index(name) for name in names]])
    assert tracer_program("merge", *parts, "-o", tmp_path / "denoised.exr", "--denoise", "-q")[0] == 0
    names, values, _ = read_exr(tmp_path / "denoised.exr")
    noisy = values[..., [names.index(f"noisy.{channel}") for channel in "RGB"]]
    assert np.array_equal(noisy, merged[..., [everything.index(channel) for channel in "RGB"]])
    monkeypatch.setitem(sys.modules, "mitsuba_oidn", None)
    code, _, err = tracer_program("merge", *parts, "-o", tmp_path / "never.exr", "--denoise")
    assert (code, "mitsuba-oidn" in err) == (2, True)
    assert not (tmp_path / "never.exr").exists()


def test_a_checkpoint_is_resumed_to_a_larger_budget(tracer_program, scene_file, tmp_path):
    common = ("render", scene_file(LIT), "-o", tmp_path / "out.exr", "--checkpoint", tmp_path / "state.ckpt", "-q")
    assert tracer_program(*common, "--spp", 4)[0] == 0
    code, _, err = tracer_program(*common, "--spp", 8)
    assert (code, "--overwrite" in err) == (2, True)
    assert tracer_program(*common, "--spp", 8, "--resume")[0] == 0
    assert read_samples(tmp_path / "out.exr")[0].sum() == 8 * 96
    assert tracer_program(*common, "--spp", 2, "--overwrite")[0] == 0
    assert read_samples(tmp_path / "out.exr")[0].sum() == 2 * 96


def test_frames_and_sensors_and_a_configuration(tracer_program, scene_file, tmp_path):
    scene = scene_file(
        f'<integrator type="path"/>{SENSOR}{SENSOR}<emitter type="constant">'
        '<rgb name="radiance" value="$frame"/></emitter>'
    )
    configuration = tmp_path / "render.toml"
    configuration.write_text('spp = 3\nseed = 5\nsensor = "all"\ncrop = [2, 1, 4, 5]\n')
    arguments = ("render", scene, "-o", tmp_path / "o.##.exr", "--config", configuration, "--frames", "7-8")
    code, out, err = tracer_program(*arguments, "--spp", 2)
    assert (code, err) == (0, "")
    names = [f"o.0{frame}-{sensor}.exr" for frame in (7, 8) for sensor in (0, 1)]
    assert sorted(path.name for path in tmp_path.glob("*.exr")) == names
    assert out.count("\n") >= 4
    for name in names:
        _, values, own = read_exr(tmp_path / name)
        assert values.shape[:2] == (5, 4)
        assert values[..., 0] == pytest.approx(int(name[3]))
        job, settings = json.loads(own["job"]), json.loads(own["report"])["settings"]
        assert (settings["spp"], settings["seed"], job["crop"], job["sensor"]) == (2, 5, [2, 1, 4, 5], "all")


def test_overwrite(tracer_program, scene_file, tmp_path):
    path = tmp_path / "out.png"
    path.write_text("old")
    code, _, _ = tracer_program("render", scene_file(LIT), "-o", path, "--spp", 1, "--overwrite", "--quiet")
    assert code == 0
    assert path.read_bytes().startswith(b"\x89PNG")


def test_info_names_the_library(tracer_program):
    code, out, _ = tracer_program("info")
    assert code == 0
    for word in ("tracer", "mitsuba", "drjit", "llvm", "libLLVM", "threads", "variant"):
        assert word in out


@pytest.mark.slow
def test_compare_prints_a_table_and_keeps_the_reference(tracer_program, scene_file, tmp_path):
    ball = '<shape type="sphere"><point name="center" x="0" y="0" z="4"/></shape>'
    scene = scene_file(LIT + ball)
    arguments = ("compare", scene, "--spp", "4", "8", "--seeds", "2", "--size", "14", "--reference-spp", "32")
    code, out, _ = tracer_program(*arguments, "-o", tmp_path / "results")
    assert code == 0
    for word in ("uniform", "independent", "multijitter", "fused", "relMSE"):
        assert word in out
    last = out.splitlines()[-1]
    assert "at 8 spp, fused " in last
    assert f"; use: tracer render {scene} --spp 8" in last
    assert last.endswith("--size 14")
    assert all(len(line) <= 80 for line in out.splitlines()[:-1])
    assert "…" not in out
    written = {path.name for path in (tmp_path / "results").iterdir()}
    assert written == {"results.json", "results.csv", "results.md", "overview.svg", "index.html", "cells"}
    kept = {path: path.stat().st_mtime_ns for path in (tmp_path / "cache").rglob("*.npz")}
    assert len(kept) == 2
    assert tracer_program(*arguments)[0] == 0
    assert {path: path.stat().st_mtime_ns for path in (tmp_path / "cache").rglob("*.npz")} == kept
    other = scene_file(LIT, "other.xml")
    code, _, err = tracer_program("compare", other, "-o", tmp_path / "results")
    assert code == 2
    assert "holds the study 'compare" in err


def test_several_budgets_may_follow_one_option():
    given = ["compare", "a.xml", "--spp", "16", "64", "--seeds", "3"]
    assert repeat_option(given, "--spp") == ["compare", "a.xml", "--spp", "16", "--spp", "64", "--seeds", "3"]
    assert repeat_option(["--spp", "16", "7.xml"], "--spp") == ["--spp", "16", "7.xml"]


def test_without_a_name_the_picture_has_that_of_the_scene(tracer_program, scene_file, tmp_path, monkeypatch):
    scene = scene_file(LIT, "lit.xml")
    (tmp_path / "work").mkdir()
    monkeypatch.chdir(tmp_path / "work")
    code, out, _ = tracer_program("render", scene, "--spp", 3)
    assert (code, out.partition(":")[0]) == (0, "lit.exr")
    assert "12 x 8, 3 samples per pixel" in out
    code, _, err = tracer_program("render", scene, "--spp", 3)
    assert (code, "'lit.exr' exists" in err) == (2, True)
    assert tracer_program("render", scene, "--part", "1/2", "--checkpoint", "one.ckpt", "--spp", 8)[0] == 0
    assert sorted(path.name for path in (tmp_path / "work").iterdir()) == ["lit.exr", "one.ckpt"]


def test_the_samples_of_the_scene_are_drawn(tracer_program, scene_file, tmp_path):
    scene = scene_file(
        LIT.replace('"independent"/>', '"independent"><integer name="sample_count" value="6"/></sampler>')
    )
    assert tracer_program("render", scene, "-o", tmp_path / "out.exr")[0] == 0
    assert read_samples(tmp_path / "out.exr")[0].sum() == 6 * 96


OWN_CRITERION = """from tracer.criteria import criterion

@criterion("mine", needs_radiance=True)
def mine(evidence):
    return evidence.wanted * WORTH
"""


def test_a_criterion_in_a_file(tracer_program, scene_file, tmp_path, monkeypatch):
    criteria.names()
    monkeypatch.setattr(registry, "registered", dict(registry.registered))
    file, configuration = tmp_path / "mine.py", tmp_path / "render.toml"
    configuration.write_text('criterion = "mine.py"\nspp = 16\n')
    for worth, code in (("2.0", 0), ("[]", 2), ("-1", 2)):
        file.write_text(OWN_CRITERION.replace("WORTH", worth))
        for given in (("--criterion", file, "--spp", 16), ("--config", configuration)):
            arguments = ("render", scene_file(LIT), "-o", tmp_path / "out.exr", "--overwrite", *given)
            found, _, err = tracer_program(*arguments)
            assert (found, err.count("\n")) == (code, min(code, 1))
            assert worth != "[]" or "mine.py', line 5: ValueError: operands" in err
            assert worth != "-1" or "mine must return an importance >= 0" in err
    assert read_exr(tmp_path / "out.exr")[2]["criterion"] == "mine"


def test_ctrl_c_leaves_what_there_is_clearly_marked(scene_file, tmp_path):
    scene = scene_file(LIT.replace('value="12"', 'value="256"').replace('value="8"', 'value="256"'))
    output, state = tmp_path / "out.exr", tmp_path / "state.ckpt"
    keep = ["--checkpoint", str(state), "--checkpoint-every", "0"]
    command = [sys.executable, "-m", "tracer", "render", str(scene), "-o", str(output), "--spp", "20000", *keep]
    process = subprocess.Popen(command, stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True, cwd=tmp_path)
    while not state.exists():  # until it draws
        assert process.poll() is None
        time.sleep(0.05)
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=PATIENCE)
    assert process.returncode == 130, err
    assert "Stopped after" in out
    names, values, own = read_exr(output)
    assert own["complete"] == 0
    assert 0 < values[..., names.index("samples.Y")].sum() < 20000 * 256 * 256
    assert np.all(np.isfinite(values))


def test_a_study_that_fails_in_part_says_so(tracer_program, scene_file, tmp_path, monkeypatch):
    from tracer.study import render_cells

    def never(studio, sampler, denoise=False):
        if sampler == "independent":
            raise RuntimeError("no luck")
        return stock(studio, sampler)

    stock = render_cells.Studio.stock
    monkeypatch.setattr(render_cells.Studio, "stock", never)
    scene = scene_file(LIT, "lit.xml")
    arguments = ("compare", scene, "--spp", "4", "--seeds", "1", "-q", "-o", tmp_path / "out")
    code, out, err = tracer_program(*arguments)
    assert (code, out) == (1, "")
    assert "1 of 4 cells failed" in err
    assert "RuntimeError: no luck" in err
    assert (tmp_path / "out" / "results.json").exists()


def test_plain_rgb_and_the_note_of_a_scene_without_light(tracer_program, scene_file, tmp_path):
    dark = LIT.replace('<emitter type="constant"/>', '<shape type="sphere"/>')
    code, out, _ = tracer_program("render", scene_file(dark), "-o", tmp_path / "out.exr", "--spp", 1, "--layers", "rgb")
    assert code == 0
    assert out.count("no emitter") == 1
    assert read_exr(tmp_path / "out.exr")[0] == ["R", "G", "B"]


def test_a_renamed_aov_is_noted(tracer_program, scene_file, tmp_path):
    aovs = '<integrator type="aov"><string name="aovs" value="albedo:albedo"/><integrator type="path"/></integrator>'
    scene = scene_file(LIT.replace('<integrator type="path"/>', aovs) + '<shape type="sphere"/>')
    arguments = ("render", scene, "-o", tmp_path / "out.exr", "--spp", 1, "--overwrite")
    code, out, _ = tracer_program(*arguments, "--features")
    assert (code, "written as aov.albedo." in out) == (0, True)
    code, out, _ = tracer_program(*arguments)
    assert (code, "aov.albedo" in out) == (0, False)


def test_a_full_disk_keeps_the_picture(tracer_program, scene_file, tmp_path, small_disk, monkeypatch):
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    monkeypatch.setattr("tempfile.tempdir", str(elsewhere))
    output = small_disk(4096) / "out.exr"
    (output.parent / "full").write_bytes(bytes(4096))
    arguments = ("render", scene_file(LIT), "-o", output, "--spp", 2)
    code, out, err = tracer_program(*arguments)
    assert (code, out) == (5, "")
    assert err.count("\n") == 1
    assert f"Cannot write '{output}'" in err
    (kept,) = elsewhere.rglob("out.exr")
    assert f"The picture is kept as '{kept}'." in err
    assert read_samples(kept)[0].sum() == 2 * 96
    checkpoint = tmp_path / "state.ckpt"
    code, _, err = tracer_program(*arguments, "--checkpoint", checkpoint)
    assert code == 5
    assert f"All samples are in the checkpoint '{checkpoint}'; make room and go on with --resume." in err
    again = ("render", scene_file(LIT), "-o", tmp_path / "out.exr", "--spp", 2, "--checkpoint", checkpoint, "--resume")
    assert tracer_program(*again)[0] == 0
    assert np.array_equal(read_exr(tmp_path / "out.exr")[1], read_exr(kept)[1])


@pytest.mark.parametrize("how", [(), ("-q",), ("--json",)])
def test_a_checkpoint_that_was_never_written_is_an_error(tracer_program, scene_file, tmp_path, small_disk, how):
    checkpoint = small_disk(4096) / "state.ckpt"
    arguments = ("render", scene_file(LIT), "-o", tmp_path / "out.exr", "--spp", 2, "--checkpoint", checkpoint)
    code, out, err = tracer_program(*arguments, *how)
    assert code == 5
    assert err == f"tracer: Cannot write '{checkpoint}': No space left on device. There is no checkpoint.\n"
    assert how == ("--json",) or "No space" not in out
    assert read_samples(tmp_path / "out.exr")[0].sum() == 2 * 96
    assert list(checkpoint.parent.iterdir()) == []


def test_a_live_picture_that_does_not_fit_costs_nothing_else(tracer_program, scene_file, tmp_path, small_disk):
    live = small_disk(4096) / "now.png"
    (live.parent / "full").write_bytes(bytes(4096))
    arguments = ("render", scene_file(LIT), "-o", tmp_path / "out.exr", "--spp", 2, "--live", live)
    code, _, err = tracer_program(*arguments)
    assert (code, err.count("\n"), f"Cannot write '{live}'" in err) == (5, 1, True)
    assert read_samples(tmp_path / "out.exr")[0].sum() == 2 * 96

"""Studies as a whole: what they write, that nothing is rendered twice, and that one failure does not stop the rest."""

import csv
import json
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import tracer
from conftest import LIT
from tracer.errors import OutputError, SceneError, SettingsError
from tracer.image import metrics
from tracer.study import cells, methods, render_cells, source_hash
from tracer.study.plan import make_plan, parse_plan
from tracer.study.reference import make_reference
from tracer.study.run import run_study
from tracer.study.toml_location import Origin

BALL = '<shape type="sphere"><point name="center" x="0.3" y="0" z="4"/></shape>'
METHODS = [
    {"name": "uniform", "criterion": "uniform"},
    {"name": "fused", "criterion": "fused"},
    {"name": "stock", "sampler": "multijitter"},
]


@pytest.fixture
def scene(scene_file):
    return scene_file(LIT + BALL, "ball.xml")


def plan_of(scene, **changes):
    values = {"name": "small", "spp": [4, 16], "seeds": 2, "scenes": [{"path": str(scene)}], "methods": METHODS}
    return make_plan({**values, "reference_spp": 9000, **changes})


def count_renders(monkeypatch):
    """Return a list that grows by one with every cell that is rendered and kept."""
    rendered = []
    store = render_cells.store

    def counted(cell, *arguments):
        rendered.append(cell)
        store(cell, *arguments)

    monkeypatch.setattr(render_cells, "store", counted)
    return rendered


def test_every_number_is_written(scene, tmp_path, monkeypatch):
    # A place on one machine is written as seen from the current folder.
    monkeypatch.setattr(sys, "argv", ["tracer", "study", "small.toml", str(Path.cwd().parent / "scenes")])
    results = run_study(plan_of(scene), tmp_path / "out")
    assert not results.failures
    assert results.finished
    record = json.loads((tmp_path / "out" / "results.json").read_text())
    assert record["command"] == "tracer study small.toml ../scenes"
    assert len(record["cells"]) == 3 * 2 * 2
    assert {(row["budget"], row["method"]) for row in record["rows"]} == {
        (budget, method["name"]) for budget in ("4 spp", "16 spp") for method in METHODS
    }
    table = list(csv.DictReader((tmp_path / "out" / "results.csv").open()))
    assert [float(line["relative_mse"]) for line in table] == [cell["relative_mse"] for cell in record["cells"]]
    assert "## Gains, 16 spp" in (tmp_path / "out" / "results.md").read_text()
    assert (tmp_path / "out" / "index.html").stat().st_size > 50_000


def test_scores_are_those_of_the_pictures(scene, tmp_path):
    plan = plan_of(scene, spp=[8], seeds=1)
    results = run_study(plan, tmp_path / "out")
    reference = make_reference(plan.find_scenes()[0].setting, results.scenes[0].reference_spp)
    for one in results.measurements:
        picture, took = cells.load(one.cell, tmp_path / "out")
        assert one.scores.mse == pytest.approx(metrics.mse(picture.image, reference.image) - reference.mse)
        assert one.scores.bias == pytest.approx(metrics.bias(picture.image, reference.image))
        assert took.samples == 12 * 8 * picture.counts.mean()
    alone = tracer.render(scene, spp=8, seed=0, criterion="fused")
    fused = next(one.cell for one in results.measurements if one.cell.method == "fused")
    np.testing.assert_array_equal(cells.load(fused, tmp_path / "out")[0].image, alone.image)


@pytest.mark.slow
def test_nothing_is_rendered_twice(scene, tmp_path, monkeypatch):
    rendered = count_renders(monkeypatch)
    first = run_study(plan_of(scene), tmp_path / "out")
    assert (len(rendered), first.kept) == (12, 0)
    again = run_study(plan_of(scene), tmp_path / "out")
    assert (len(rendered), again.kept) == (12, 12)
    assert str(again.tables()) == str(first.tables())  # NaN is not itself
    run_study(plan_of(scene, seeds=3), tmp_path / "out")
    assert len(rendered) == 12 + 6
    run_study(plan_of(scene, methods=[*METHODS, {"name": "even", "sampler": "independent"}]), tmp_path / "out")
    assert len(rendered) == 18 + 4
    monkeypatch.setattr(source_hash, "criterion_hash", lambda name: f"{name} was edited")
    run_study(plan_of(scene), tmp_path / "out")
    assert len(rendered) == 22 + 8  # not those of mi.render
    run_study(plan_of(scene), tmp_path / "out", overwrite=True)
    assert len(rendered) == 30 + 12


@pytest.mark.slow
def test_times_of_several_runs_are_marked(scene, tmp_path):
    run_study(plan_of(scene, spp=[4], methods=METHODS[:2]), tmp_path / "out")
    results = run_study(plan_of(scene, spp=[4]), tmp_path / "out")
    paired = {row.method: row.paired for row in results.tables()[0]}
    assert paired == {"uniform": True, "fused": True, "stock": False}
    assert "*" in next(
        line
        for line in (tmp_path / "out" / "results.md").read_text().splitlines()
        if line.startswith("| ball | 4 spp | stock")
    )


def test_stopped_and_started_again(scene, tmp_path, monkeypatch):
    rendered = count_renders(monkeypatch)
    with pytest.raises(KeyboardInterrupt):
        run_study(plan_of(scene), tmp_path / "out", lambda text, done, total: done < 5)
    assert 4 <= len(rendered) <= 6
    results = run_study(plan_of(scene), tmp_path / "out")
    assert len(rendered) == 12
    assert len(results.measurements) == 12


def test_an_overwriting_run_that_is_stopped_loses_nothing(scene, tmp_path, monkeypatch):
    first = run_study(plan_of(scene), tmp_path / "out")
    results_file = tmp_path / "out" / "results.json"
    written = results_file.read_bytes()
    rendered = count_renders(monkeypatch)
    with pytest.raises(KeyboardInterrupt):
        run_study(plan_of(scene), tmp_path / "out", lambda text, done, total: done < 5, overwrite=True)
    replaced = len(rendered)
    assert 4 <= replaced <= 6
    assert results_file.read_bytes() == written
    second = run_study(plan_of(scene), tmp_path / "out")
    assert (len(rendered), second.kept) == (replaced, 12)
    errors = [{one.cell: one.scores.mse for one in results.measurements} for results in (first, second)]
    assert errors[1] == pytest.approx(errors[0], rel=1e-5)  # mi.render adds samples in any order
    assert len({one.took.run for one in second.measurements}) == 2


def test_a_cell_that_fails_while_overwriting_is_not_measured_by_its_older_picture(scene, tmp_path, monkeypatch):
    plan = plan_of(scene, spp=[4], seeds=1)
    run_study(plan, tmp_path / "out")
    own = methods.render_request

    def without_fused(request):
        if request.settings.criterion == "fused":
            raise RuntimeError("out of luck")
        return own(request)

    monkeypatch.setattr(methods, "render_request", without_fused)
    results = run_study(plan, tmp_path / "out", overwrite=True)
    assert [one.method for one in results.failures] == ["fused"]
    assert {one.cell.method for one in results.measurements} == {"uniform", "stock"}
    assert len(run_study(plan, tmp_path / "out").measurements) == 3  # the older picture is not lost


def finished(folder):
    return {path for path in folder.rglob("*seed*.exr") if not path.name.startswith(".")}


@pytest.mark.slow
def test_killed_and_started_again(scene, tmp_path, monkeypatch):
    """Whenever the process dies, what was finished is whole, and the rest is made."""
    plan = tmp_path / "small.toml"
    plan.write_text(
        f'name = "small"\nspp = [4]\nseeds = 300\nreference_spp = 9000\n[[scenes]]\npath = "{scene}"\n'
        '[[methods]]\nname = "uniform"\ncriterion = "uniform"\n[[methods]]\nname = "stock"\nsampler = "multijitter"\n'
    )
    command = [sys.executable, "-m", "tracer", "study", str(plan), "-o", str(tmp_path / "out"), "-q"]
    process = subprocess.Popen(command, cwd=Path(tracer.__file__).parents[1])
    folder = tmp_path / "out" / "cells"
    while len(finished(folder)) < 8:
        assert process.poll() is None
        time.sleep(0.05)
    process.send_signal(signal.SIGKILL)
    process.wait()
    kept = finished(folder)
    assert 8 <= len(kept) < 600
    rendered = count_renders(monkeypatch)
    text = plan.read_text().replace("seeds = 300", f"seeds = {len(kept)}")
    results = run_study(parse_plan(text, Origin("small.toml", text), tmp_path, None), tmp_path / "out")
    assert not results.failures
    assert len(rendered) + len(kept) == len(results.measurements) == 2 * len(kept)


@pytest.mark.slow
def test_one_failure_does_not_stop_the_rest(scene, tmp_path, monkeypatch):
    own = methods.render_request

    def sometimes(request):
        settings = request.settings
        if settings.criterion == "fused" and settings.spp == 16 and settings.seed == 1:
            raise RuntimeError("out of luck\nsecond line")
        return own(request)

    monkeypatch.setattr(methods, "render_request", sometimes)
    results = run_study(plan_of(scene), tmp_path / "out")
    assert [(one.method, one.budget, one.seed, one.message) for one in results.failures] == [
        ("fused", "16 spp", 1, "RuntimeError: out of luck")
    ]
    assert len(results.measurements) == 11
    row = next(row for row in results.tables()[0] if (row.method, row.budget) == ("fused", "16 spp"))
    assert row.seeds == 1
    assert "out of luck" in (tmp_path / "out" / "index.html").read_text()
    monkeypatch.setattr(methods, "render_request", own)
    rendered = count_renders(monkeypatch)
    assert not run_study(plan_of(scene), tmp_path / "out").failures
    assert len(rendered) == 1


def test_a_method_that_never_works(scene, tmp_path, monkeypatch):
    def never(studio, sampler, denoise=False):
        def render(spp, seed):
            if seed > 100:
                return stock(studio, sampler)(spp, seed)  # the reference
            raise RuntimeError("no")

        return render

    stock = render_cells.Studio.stock

    monkeypatch.setattr(render_cells.Studio, "stock", never)
    results = run_study(plan_of(scene), tmp_path / "out")
    assert {one.method for one in results.failures} == {"stock"}
    assert len(results.failures) == 4
    assert {one.method for one in results.tables()[1]} == {"uniform", "fused"}


@pytest.mark.slow
def test_a_budget_in_seconds_is_spent(scene, tmp_path):
    tracer.render(scene, size=64, spp=16)  # compiles
    start = time.monotonic()
    tracer.render(scene, size=64, spp=16)
    seconds = round(0.4 + 2 * (time.monotonic() - start), 1)  # as slow as the machine is
    results = run_study(plan_of(scene, spp=[], seconds=[seconds], size=64), tmp_path / "out")
    for one in results.measurements:
        assert 0.1 * seconds < one.took.seconds < 20 * seconds
        assert one.took.spp > 16
    assert {row.budget for row in results.tables()[0]} == {f"{seconds:g} s"}


@pytest.mark.slow
def test_references_are_good_enough_or_it_is_said(scene, tmp_path):
    results = run_study(plan_of(scene, spp=[4], size=64, reference_spp=2**17), tmp_path / "good")
    smallest = min(one.scores.relative_mse for one in results.measurements)
    assert results.scenes[0].reference_relative_mse <= 0.01 * smallest
    assert not any(row.too_close for row in results.tables()[0])
    assert "Too close" not in (tmp_path / "good" / "index.html").read_text()
    results = run_study(plan_of(scene, spp=[1024], seeds=1, size=65, reference_spp=16), tmp_path / "poor")
    assert all(row.too_close for row in results.tables()[0])
    assert "Too close" in (tmp_path / "poor" / "index.html").read_text()


@pytest.mark.slow
def test_a_folder_of_another_study(scene, tmp_path):
    run_study(plan_of(scene, spp=[4], seeds=1), tmp_path / "out")
    text = (
        'spp = [4]\nname = "other"\n[[scenes]]\n'
        f'path = "{scene}"\n[[methods]]\nname = "uniform"\ncriterion = "uniform"\n'
    )
    other = parse_plan(text, Origin("other.toml", text), tmp_path, None)
    with pytest.raises(SettingsError, match=r"^other\.toml, line 2: '.*out' holds the study 'small', not 'other'"):
        run_study(other, tmp_path / "out")
    (tmp_path / "out" / "results.json").write_text("{}")
    with pytest.raises(OutputError, match="is not from a study"):
        run_study(other, tmp_path / "out")
    assert run_study(other, tmp_path / "out", overwrite=True).plan.name == "other"


BROKEN = [
    ('<integrator type="pth"/>' + LIT, {}, r"line 3: .*does not load.*Did you mean 'path'"),
    (LIT, {"sensor": 3}, r"line 4: There is no sensor 3"),
    (LIT, {"integrator": "ptracer"}, r"line 4: .*cannot be sampled pixel by pixel"),
    (LIT, {"size": 5}, r"line 4: .*needs at least 7 a side"),
]


@pytest.mark.parametrize(("body", "override", "message"), BROKEN)
def test_scenes_that_cannot_be_used(scene_file, tmp_path, body, override, message):
    scene = scene_file(body, "bad.xml")
    entry = "".join(f"{name} = {json.dumps(value)}\n" for name, value in override.items())
    text = f'name = "bad"\n[[scenes]]\npath = "{scene}"\n{entry}[[methods]]\nname = "uniform"\ncriterion = "uniform"\n'
    plan = parse_plan("spp = [4]\n" + text, Origin("bad.toml", text), tmp_path, None)
    with pytest.raises((SettingsError, SceneError)) as caught:
        run_study(plan, tmp_path / "out")
    assert re.search(message, str(caught.value))
    assert not (tmp_path / "out").exists()


def test_a_sampler_that_does_not_exist(scene, tmp_path):
    with pytest.raises(SettingsError, match=r"methods\.0\.sampler: .*multijiter.*Did you mean 'multijitter'"):
        run_study(plan_of(scene, methods=[{"name": "a", "sampler": "multijiter"}]), tmp_path / "out")


def test_pictures_with_pixels_that_are_not_finite(scene, tmp_path, monkeypatch):
    stock = render_cells.Studio.stock

    def spoilt(studio, sampler, denoise=False):
        render = stock(studio, sampler)

        def other(spp, seed):
            if seed > 100:
                return render(spp, seed)  # the reference
            picture = render(spp, seed)
            picture.image[2, 3, 1] = np.nan
            return picture

        return other

    monkeypatch.setattr(render_cells.Studio, "stock", spoilt)
    results = run_study(plan_of(scene, spp=[4], seeds=1), tmp_path / "out")
    assert [one.message for one in results.failures] == ["1 pixels of the picture are not finite"]
    assert {one.cell.method for one in results.measurements} == {"uniform", "fused"}


def test_two_at_once(scene, tmp_path):
    from tracer.study.check import one_at_a_time

    with one_at_a_time(tmp_path / "out"), pytest.raises(OutputError, match=r"Another study is at work in '.*out'"):
        run_study(plan_of(scene), tmp_path / "out")


@pytest.mark.slow
def test_damaged_pictures_are_made_again(scene, tmp_path, monkeypatch):
    run_study(plan_of(scene), tmp_path / "out")
    damaged = sorted(finished(tmp_path / "out"))[:2]
    damaged[0].write_bytes(damaged[0].read_bytes()[:-200])
    damaged[1].write_bytes(b"")
    rendered = count_renders(monkeypatch)
    results = run_study(plan_of(scene), tmp_path / "out")
    if results.failures:  # its header was whole, its pixels were not
        results = run_study(plan_of(scene), tmp_path / "out")
    assert not results.failures
    assert len(rendered) == 2
    assert len(results.measurements) == 12


@pytest.mark.slow
def test_results_of_more_scenes_stay(scene, tmp_path):
    other = scene.with_name("other.xml")
    other.write_text(scene.read_text())
    scenes = [{"path": str(scene)}, {"path": str(other)}]
    run_study(plan_of(scene, scenes=scenes, spp=[4], seeds=1), tmp_path / "out")

    def stop_in_the_second(text, done, total):
        return not text.startswith("other")

    with pytest.raises(KeyboardInterrupt):
        run_study(plan_of(scene, scenes=scenes, spp=[4], seeds=2), tmp_path / "out", stop_in_the_second)
    record = json.loads((tmp_path / "out" / "results.json").read_text())
    assert [one["name"] for one in record["scenes"]] == ["ball", "other"]
    run_study(plan_of(scene, scenes=scenes, spp=[4], seeds=2), tmp_path / "out")
    record = json.loads((tmp_path / "out" / "results.json").read_text())
    assert len(record["cells"]) == 2 * 2 * 3

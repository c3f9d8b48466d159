"""A study by workers keeps the pictures that it keeps alone."""

import subprocess
import sys

import numpy as np
import pytest

from conftest import LIT, PATIENCE
from tracer import criteria
from tracer.criteria import registry
from tracer.errors import ClusterError
from tracer.study import cells, render_cells_remote
from tracer.study.plan import make_plan
from tracer.study.run import run_study

METHODS = [
    {"name": "uniform", "criterion": "uniform"},
    {"name": "fused", "criterion": "fused"},
    {"name": "stock", "sampler": "multijitter"},
]


@pytest.fixture
def plan(scene_file):
    scene = scene_file(LIT + '<shape type="sphere"><point name="center" x="0.3" y="0" z="4"/></shape>', "ball.xml")
    values = {"name": "small", "spp": [4, 16], "seeds": 2, "scenes": [{"path": str(scene)}], "methods": METHODS}
    return make_plan({**values, "reference_spp": 4000})


@pytest.mark.slow
def test_workers_keep_the_same_pictures(plan, tmp_path, two_workers):
    there = run_study(plan, tmp_path / "there", cluster=two_workers)
    here = run_study(plan, tmp_path / "here")
    assert not there.failures
    assert len(there.measurements) == len(here.measurements) == 12
    (scene,) = plan.find_scenes()
    for block in cells.cells_of(plan, scene):
        for cell in block:
            one, other = (cells.load(cell, tmp_path / name) for name in ("there", "here"))
            # Mitsuba's own film adds up in an order that threads decide.
            assert np.allclose(one[0].image, other[0].image, rtol=1e-5 if cell.method == "stock" else 0, atol=0), cell
            assert "threads" in one[1].machine
    again = run_study(plan, tmp_path / "there", cluster=two_workers)
    assert again.kept == 12


def test_what_fails_on_a_worker_is_a_failure_of_its_cell(plan, tmp_path, two_workers, monkeypatch):
    monkeypatch.setattr(registry, "registered", {**registry.registered})

    @criteria.criterion("only_here", needs_radiance=False)
    def only_here(evidence):
        return np.ones_like(evidence.wanted)

    values = plan.model_dump(exclude_none=True)
    odd = make_plan({**values, "methods": [METHODS[0], {"name": "odd", "criterion": "only_here"}]})
    results = run_study(odd, tmp_path / "out", cluster=two_workers)
    assert len(results.measurements) == 4
    assert {one.method for one in results.failures} == {"odd"}
    assert all("there is no criterion 'only_here'" in one.message for one in results.failures)


def test_a_study_on_workers_can_be_stopped(plan, tmp_path, two_workers):
    with pytest.raises(KeyboardInterrupt):
        run_study(plan, tmp_path / "out", lambda text, done, total: "opening" not in text, cluster=two_workers)


def test_a_worker_of_another_version_ends_a_study(plan, tmp_path, two_workers, monkeypatch):
    monkeypatch.setattr(render_cells_remote, "software", lambda: {"tracer": "0.0"})
    with pytest.raises(ClusterError, match="has tracer 0"):
        run_study(plan, tmp_path / "out", cluster=two_workers)


@pytest.mark.slow
def test_the_command_takes_workers(scene_file, tmp_path):
    scene_file(LIT, "sky.xml")
    (tmp_path / "small.toml").write_text("""
name = "small"
spp = [16]
seeds = 2
reference_spp = 256
scenes = [{path = "sky.xml"}]
methods = [{name = "uniform", criterion = "uniform"}, {name = "fused", criterion = "fused"}]
""")
    command = [sys.executable, "-m", "tracer", "study", "small.toml", "-o", "small", "--workers", "2"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE, check=False, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "small" / "index.html").stat().st_size > 50_000
    assert len(list((tmp_path / "small").rglob("*.exr"))) == 4

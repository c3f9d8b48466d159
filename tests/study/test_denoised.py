"""Denoised over noisy: the ratio of errors of methods that differ in nothing but denoising."""

from dataclasses import replace

import numpy as np
import pytest

from study.page.conftest import made_up
from tracer.study.denoised import denoised_over_noisy, pairs
from tracer.study.plan import make_plan
from tracer.study.tables import markdown

METHODS = [
    {"name": "uniform", "criterion": "uniform"},
    {"name": "clean", "criterion": "fused", "denoise": True},
    {"name": "fused", "criterion": "fused"},
    {"name": "other", "criterion": "fused", "pilot_spp": 3, "denoise": True},
]


def results_with(methods):
    """Return made-up results whose methods have other plans; the second one has a quarter of the first one's error."""
    results, _ = made_up(2, 3)
    names = [method.name for method in results.plan.methods]
    plans = [{**plan, "name": name} for plan, name in zip(methods, names, strict=False)]
    results.plan = results.plan.model_copy(update={"methods": [method_of(plan) for plan in plans]})
    return results, names


def method_of(plan):
    return make_plan({"name": "x", "spp": [64], "scenes": [{"bundled": "*"}], "methods": [plan]}).methods[0]


def test_only_methods_that_differ_in_nothing_else_are_compared():
    plan = make_plan({"name": "x", "spp": [64], "scenes": [{"bundled": "*"}], "methods": METHODS})
    assert pairs(plan) == [("fused", "clean")]


def test_ratios_are_those_of_the_mean_errors():
    results, names = results_with([METHODS[2], METHODS[1]])
    headings, lines = denoised_over_noisy(results, "64 spp")
    assert headings == [f"{names[1]} over {names[0]}, {error}" for error in ("relMSE", "trimmed")]
    assert list(lines) == ["scene 0", "scene 1", "geometric mean"]
    for scene in ("scene 0", "scene 1"):
        errors = [
            np.mean([m.scores.relative_mse for m in results.measurements if key(m) == (scene, "64 spp", name)])
            for name in names[:2]
        ]
        assert lines[scene][0].mean == pytest.approx(errors[1] / errors[0])
    assert "## Denoised over noisy, 64 spp" in markdown(results)


def key(measured):
    return measured.cell.scene, measured.cell.budget.label, measured.cell.method


def test_a_method_that_failed_has_no_ratio_and_without_denoising_there_is_no_table():
    results, names = results_with([METHODS[2], METHODS[1]])
    results.measurements = [measured for measured in results.measurements if measured.cell.method != names[1]]
    assert denoised_over_noisy(results, "64 spp")[1]["scene 0"] == [None, None]
    plain, _ = results_with([METHODS[0], METHODS[2]])
    assert "Denoised over noisy" not in markdown(replace(plain))

"""A round is cut into units that have all of its samples, each in one of them."""

import ast
import itertools
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import tracer.cluster
from tracer.cluster.units import Unit, cut, cut_round
from tracer.cluster.work_balancer import Region

COUNTS = st.lists(st.one_of(st.just(0), st.integers(0, 1_000_000)), min_size=1, max_size=100)


@given(COUNTS, st.sets(st.integers(1, 99), max_size=8), st.integers(1, 600), st.sampled_from([None, 1e-7, 1e-3]))
def test_units_have_each_sample_of_a_round_once(counts, borders, worker_count, pace):
    """Whatever the counts, however the picture is cut already, and for any number of workers."""
    counts = np.array(counts, np.uint32)
    ends = sorted({0, *(border for border in borders if border < len(counts)), len(counts)})
    regions = [Region(first, end - first, pace=pace) for first, end in itertools.pairwise(ends)]
    parts, units = cut_round(regions, counts, 3 * counts, worker_count)
    covered = np.concatenate([np.arange(part.first, part.first + part.size) for part in parts])
    assert np.array_equal(covered, np.arange(len(counts)))
    drawn, times = np.zeros(len(counts), np.int64), np.zeros(len(counts), int)
    for unit in units:
        drawn[unit.region.pixels] += unit.counts
        times[unit.region.pixels] += 1
        assert np.array_equal(unit.goal, 3 * unit.counts)
        assert unit.counts.any()
    assert np.array_equal(drawn, counts)
    assert times.max(initial=0) <= 1


@given(st.floats(0.0, 1.0), st.lists(st.integers(0, 50), min_size=1, max_size=30))
def test_both_parts_of_a_cut_are_the_whole(share, counts):
    whole = np.array(counts, np.uint32)
    unit = Unit(Region(7, len(counts), source="held", skip=3), whole, 2 * whole, 4.0)
    rest = cut(unit, share)
    parts = [unit] if rest is None else [unit, rest]
    assert np.array_equal(np.concatenate([part.counts for part in parts]), whole)
    assert np.array_equal(np.concatenate([part.goal for part in parts]), 2 * whole)
    at = 0
    for part in parts:
        assert (part.region.first, part.region.skip, part.region.size) == (7 + at, 3 + at, len(part.counts))
        at += part.region.size
    assert at == len(counts)
    assert abs(sum(part.seconds for part in parts) - 4.0) < 1e-9


def test_of_a_cut_unit_each_part_takes_the_time_of_its_samples():
    counts = np.array([70, 10, 10, 10], np.uint32)
    unit = Unit(Region(0, 4), counts, counts, 10.0)
    rest = cut(unit, 0.5)
    assert (unit.region.size, unit.seconds, rest.seconds) == (1, 7.0, 3.0)


PURE = ["work_balancer", "units", "work_pool", "round_policy"]
TRANSPORT = {"dask", "distributed", "time", "queue", "drjit", "mitsuba"}


@pytest.mark.parametrize("name", PURE)
def test_what_decides_knows_neither_dask_nor_a_clock(name):
    tree = ast.parse((Path(tracer.cluster.__file__).parent / f"{name}.py").read_text())
    imported = {alias.name for node in ast.walk(tree) if isinstance(node, ast.Import) for alias in node.names}
    imported |= {node.module for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)}
    own = {module for module in imported if module.startswith("tracer.cluster")}
    assert own <= {f"tracer.cluster.{pure}" for pure in PURE}
    assert not {module.split(".")[0] for module in imported} & TRANSPORT

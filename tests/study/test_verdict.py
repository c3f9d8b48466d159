"""What a comparison says in the end."""

from dataclasses import replace

import pytest

from tracer.image.metrics import Scores
from tracer.study import verdict
from tracer.study.gains import Interval
from tracer.study.records import Row

NAN = float("nan")
EVEN = Interval(1.0, 1.0, 1.0)
ROW = Row(
    scene="rods",
    budget="64 spp",
    method="fused",
    seeds=5,
    spp=64.0,
    samples=1e6,
    seconds=1.0,
    drawing=0.9,
    scores=Scores(*7 * [0.1]),
    gain_samples=Interval(3.334, 3.2, 3.5),
    gain_time=Interval(1.9, 1.8, 2.0),
    gain_trimmed=EVEN,
    gain_trimmed_time=EVEN,
    oracle_share=None,
    oracle_time_share=None,
    paired=True,
    too_close=False,
)


@pytest.mark.parametrize(
    ("changes", "clause", "pays"),
    [
        ({}, "fused has 3.33 times less relMSE with as many samples, and 1.90 times less in the same time", True),
        ({"gain_time": Interval(0.8, 0.7, 0.9)}, "and 1.25 times more in the same time", False),
        (
            {"gain_time": Interval(1.1, 0.9, 1.3)},
            "1.10 times less in the same time, which 5 seeds cannot tell from none",
            True,
        ),
        (
            {"gain_samples": EVEN, "gain_time": EVEN},
            "On rods at 64 spp, fused gains nothing over uniform sampling: with as many samples it has the same",
            True,
        ),
        (
            {"seeds": 1, "gain_time": Interval(1.2, NAN, NAN)},
            "1.20 times less in the same time, as far as a single",
            True,
        ),
        (
            {"seeds": 1, "gain_time": Interval(0.8, NAN, NAN)},
            "1.25 times more in the same time, as far as a single",
            False,
        ),
    ],
)
def test_a_gain_in_words(changes, clause, pays):
    row = replace(ROW, **changes)
    assert clause in verdict.in_words(row, "relMSE")
    assert " rods at 64 spp, fused " in verdict.in_words(row, "relMSE")
    assert verdict.pays(row) == pays


def test_the_best_is_that_which_gains_most_in_the_same_time():
    slower = replace(ROW, method="variance", gain_samples=Interval(9, 8, 10), gain_time=Interval(1.2, 1.1, 1.3))
    failed = replace(ROW, method="rigau", gain_time=None)
    assert verdict.best([slower, failed, ROW, replace(ROW, method="uniform", gain_time=Interval(5, 5, 5))]) == ROW
    assert verdict.best([failed]) is None

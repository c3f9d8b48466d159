"""When a checkpoint is written."""

from types import SimpleNamespace

import pytest

from tracer.core.wording import speaking_to_command_line
from tracer.session import keeper
from tracer.session.keeper import LONGEST_SHARE, Keeper, Writes
from tracer.session.request import CheckpointFile


@pytest.fixture
def now(monkeypatch):
    clock = [100.0]
    monkeypatch.setattr(keeper.time, "monotonic", lambda: clock[0])
    return clock


def test_writes_are_as_far_apart_as_asked_and_take_a_small_share_of_the_time(now):
    writes = Writes(every=10.0, last=now[0])
    assert not writes.are_due()
    now[0] += 10.0
    assert writes.are_due()
    start, now[0] = now[0], now[0] + 2.0
    writes.note(start)
    now[0] += 2.0 / LONGEST_SHARE - 1e-6
    assert not writes.are_due()
    now[0] += 1e-3
    assert writes.are_due()
    assert writes.count == 1


@pytest.mark.parametrize("at_risk", [False, True])
def test_sums_that_can_be_lost_are_kept_after_the_first_round(now, tmp_path, monkeypatch, at_risk):
    found = Keeper(CheckpointFile(tmp_path / "state.ckpt", every=60.0), None, at_risk)
    monkeypatch.setattr(Keeper, "save", lambda self, state: self.writes.note(now[0]))
    for _ in range(3):
        now[0] += 1.0
        found.save_if_due(SimpleNamespace())
        found.save_after_round(SimpleNamespace())
    assert found.writes.count == at_risk


def test_what_is_asked_of_the_caller_fits_the_caller(tmp_path):
    found = Keeper(CheckpointFile(tmp_path / "state.ckpt"), None)
    assert found.in_words(10).startswith("There is no checkpoint")
    assert found.all_is_kept() == ""
    found.kept = 5
    assert found.in_words(10).endswith("has 50.0 % of the samples; go on with resume=True.")
    assert found.all_is_kept().endswith("make room and go on with resume=True.")
    with speaking_to_command_line():
        assert found.in_words(10).endswith("go on with --resume.")

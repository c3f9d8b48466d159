"""Whatever a person has for a scene, a mesh, a picture or a checkpoint: a right result, or one sentence."""

from collections import Counter

import pytest

from .kinds import KINDS
from .pool import run_all
from .verdict import complaint

WORKERS = 2
FEW, MANY = 1, 12
"""Inputs of each kind."""


def judge_all(seeds, folder):
    """Run inputs of all kinds; return exit codes, and complaints with what makes the input again."""
    inputs = [(kind, seed) for seed in seeds for kind in KINDS]

    def judge(outcome):
        wrong = complaint(outcome)
        return (outcome.kind, outcome.seed), outcome.code, f"{outcome}\n  {wrong}" if wrong else ""

    verdicts = {one: (code, wrong) for one, code, wrong in run_all(inputs, folder, WORKERS, judge)}
    assert len(verdicts) == len(inputs)
    for kind, seed in [one for one, (code, wrong) in verdicts.items() if wrong and (code is None or code < 0)]:
        # A busy machine may have taken too long; and what Mitsuba has read beyond its memory for an earlier input may
        # kill the process at a later one. A person's command has a process of its own.
        again = folder / "again" / f"{kind} {seed}"
        again.mkdir(parents=True)
        ((_, *verdict),) = run_all([(kind, seed)], again, 1, judge)
        verdicts[kind, seed] = tuple(verdict)
    return Counter(code for code, _ in verdicts.values()), [wrong for _, wrong in verdicts.values() if wrong]


def test_a_few_broken_inputs(tmp_path):
    codes, wrong = judge_all(range(FEW), tmp_path)
    assert not wrong, "\n".join(wrong)
    assert codes[0] > 0 < codes[2]


@pytest.mark.slow
def test_hundreds_of_broken_inputs(tmp_path):
    codes, wrong = judge_all(range(1000, 1000 + MANY), tmp_path)
    print(dict(codes))
    assert not wrong, "\n".join(wrong)
    assert codes.total() >= 210
    assert codes[0] > 39 < codes[2]


def test_every_kind_makes_the_same_input_again(tmp_path):
    from random import Random

    for kind, make in KINDS.items():
        made = []
        for name in ("a", "b"):
            folder = tmp_path / name / "in"
            (tmp_path / name / "out").mkdir(parents=True, exist_ok=True)
            folder.mkdir(exist_ok=True)
            arguments = make(Random(f"{kind} 5"), folder)
            files = {path.name: path.read_bytes() for path in folder.iterdir() if path.suffix in (".xml", ".toml", "")}
            made.append(([one.replace(str(tmp_path / name), "") for one in arguments], files))
            for path in folder.iterdir():
                path.rmdir() if path.is_dir() else path.unlink()
        assert made[0] == made[1], kind

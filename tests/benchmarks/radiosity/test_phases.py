"""The phases of a solution."""

from dataclasses import replace

from benchmarks.radiosity import phases
from benchmarks.radiosity.scenes import examples


def test_every_phase_of_a_solution_takes_time():
    cornell = next(example for example in examples() if example.name == "Cornell box")
    steps = []
    rows = phases.phases(replace(cornell, size=0.2), steps.append)
    assert len(steps) == phases.step_count()
    spent = {row["method"]: {name for name, seconds in row["seconds"].items() if seconds > 0} for row in rows}
    assert spent["gathering"] == {"cutting", "lights", "rays", "rounds", "looks", "picture"}
    assert spent["shooting"] == {"cutting", "step", "picture"}

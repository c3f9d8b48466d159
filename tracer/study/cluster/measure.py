"""Two workers of one thread each against one process of two, in turns, and what travels."""

from __future__ import annotations

import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import drjit as dr
import numpy as np

from tracer.cluster.remote_drawer import open_remote_drawer
from tracer.result import Result
from tracer.scene.fingerprint import fingerprint
from tracer.scene.view import open_scene
from tracer.session.render_loop import render_view
from tracer.session.terms import Terms
from tracer.settings import make_settings
from tracer.study.cluster.model import Constants

Told = Callable[[str], None]
SIZE = (512, 512)
SPP = 256
WORKERS = 2
SEEDS = (0, 1, 2)

MEMORY = """
import sys, tracer
from pathlib import Path

if __name__ == "__main__":
    tracer.render(sys.argv[1], size=({width}, {height}), spp=16, cluster={cluster})
    lines = Path("/proc/self/status").read_text().splitlines()
    print(next(line.split()[1] for line in lines if line.startswith("VmHWM")))
"""


@dataclass
class Pair:
    """A scene, rendered alone and by workers in turns."""

    scene: str
    pixels: int
    alone: list[float] = field(default_factory=list)
    """Seconds, a seed each."""
    workers: list[float] = field(default_factory=list)
    rounds: list[int] = field(default_factory=list)
    traffic: list[dict[str, Any]] = field(default_factory=list)
    constants: list[Constants] = field(default_factory=list)
    differing: int = 0
    """Values of picture, counts and standard errors that differ, of all seeds."""
    difference: float = 0.0
    """Largest difference of such values, relative to the larger."""
    programs: dict[str, float] = field(default_factory=dict)
    """Seconds of the whole program, start-up included."""
    memory: dict[str, float] = field(default_factory=dict)
    """Most memory of the client, GiB, by number of workers."""

    @property
    def throughput(self) -> list[float]:
        """That of the workers over that of one process, a seed each."""
        return [one / other for one, other in zip(self.alone, self.workers, strict=True)]


def pair(name: str, path: Path, told: Told) -> Pair:
    """Render a scene in both ways, one after the other, after a first time that is not measured."""
    with open_remote_drawer(WORKERS) as hired, open_scene(path, size=SIZE) as view:
        drawer = hired(path, fingerprint(path), None, 0, size=SIZE)
        found = Pair(name, view.pixel_count)
        for seed in (None, *SEEDS):
            told(f"{name}: {'warming up' if seed is None else f'seed {seed}'}")
            settings = make_settings(spp=64 if seed is None else SPP, seed=seed or 0)
            start = time.perf_counter()
            alone = render_view(view, settings)
            middle, processor = time.perf_counter(), time.process_time()
            other = render_view(view, settings, Terms(drawer=drawer))
            end, processor = time.perf_counter(), time.process_time() - processor
            if seed is None:
                continue
            found.alone.append(middle - start)
            found.workers.append(end - middle)
            found.rounds.append(len(other.report.rounds))
            found.traffic.append(other.report.elsewhere)
            found.constants.append(constants_of(found, alone, other, processor))
            for layer in ("image", "samples", "stderr"):
                one, two = (np.asarray(getattr(each, layer), np.float64) for each in (alone, other))
                apart = np.abs(one - two) / np.maximum(np.maximum(np.abs(one), np.abs(two)), 1e-30)
                found.differing += int(np.count_nonzero(apart))
                found.difference = max(found.difference, float(apart.max()))
    for workers in (0, WORKERS):
        told(f"{name}: whole program")
        found.programs[str(workers)] = program_seconds(path, workers)
        found.memory[str(workers)] = client_memory(path, workers)
    return found


def constants_of(found: Pair, alone: Result, other: Result, processor: float) -> Constants:
    """Return what a pair of renders says of the constants of the model; ``processor``: seconds of the client's."""
    report, elsewhere = alone.report, other.report.elsewhere
    samples = sum(one.samples for one in report.rounds)
    rounds = len(report.rounds)
    drawn = sum(one.seconds for one in report.rounds)
    deciding = report.seconds_deciding + report.seconds_pilot
    developing = max(other.seconds - sum(one.seconds for one in other.report.rounds) - deciding, 0.0)
    return Constants(
        sample=drawn * dr.thread_count() / samples,
        unit=max(processor - deciding - developing, 0.0) / elsewhere["units"],
        deciding=deciding / (max(rounds - 1, 1) * found.pixels),
        developing=developing / found.pixels,
        round_bytes=(elsewhere["bytes_received"] - elsewhere["bytes_of_sums"]) / (rounds * found.pixels),
        sums_bytes=elsewhere["bytes_of_sums"] / found.pixels,
    )


def program_seconds(path: Path, workers: int) -> float:
    """Return the seconds of a render by the command line."""
    more = ["--workers", str(workers)] if workers else []
    with tempfile.TemporaryDirectory() as folder:
        output = Path(folder) / "out.exr"
        command = [sys.executable, "-m", "tracer", "render", str(path), "-o", str(output), "--spp", str(SPP), "-q"]
        start = time.perf_counter()
        subprocess.run([*command, "--size", str(SIZE[0]), *more], check=True)
        return time.perf_counter() - start


def client_memory(path: Path, workers: int) -> float:
    """Return the most memory (GiB) of a process that renders, alone or by workers."""
    with tempfile.TemporaryDirectory() as folder:
        script = Path(folder) / "memory.py"
        script.write_text(MEMORY.format(width=SIZE[0], height=SIZE[1], cluster=workers or None))
        done = subprocess.run([sys.executable, str(script), str(path)], check=True, capture_output=True, text=True)
    return int(done.stdout) / 2**20

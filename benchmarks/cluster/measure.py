"""Two workers of one thread each against one process of two threads, in turns, and the bytes that travel."""

from __future__ import annotations

import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import drjit as dr
import numpy as np

from benchmarks.cluster.scaling_model import Constants
from benchmarks.harness import Announce
from tracer.cluster.remote_drawer import open_workers
from tracer.result import Result
from tracer.scene.fingerprint import fingerprint
from tracer.scene.view import open_scene
from tracer.session.render import begun, complete, render_request
from tracer.session.request import Request
from tracer.settings import make_settings

SIZE = (512, 512)
"""Width and height of the pictures in pixels."""
SPP = 256
"""Mean samples per pixel."""
WORKERS = 2
"""Number of workers, and of threads of the single process."""
SEEDS = (0, 1, 2)
"""Seeds of the renders."""

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
    """Seconds of one process, for each seed."""
    workers: list[float] = field(default_factory=list)
    """Seconds of the workers, for each seed."""
    rounds: list[int] = field(default_factory=list)
    """Number of rounds, for each seed."""
    traffic: list[dict[str, Any]] = field(default_factory=list)
    """Units and bytes that travelled, for each seed."""
    constants: list[Constants] = field(default_factory=list)
    """Constants of the model that each seed gives."""
    differing: int = 0
    """Number of values of picture, counts and standard errors that differ, over all seeds."""
    difference: float = 0.0
    """Largest difference of such values, relative to the larger value."""
    programs: dict[str, float] = field(default_factory=dict)
    """Seconds of the whole program, start-up included, by number of workers; 0 stands for one process."""
    memory: dict[str, float] = field(default_factory=dict)
    """Largest memory of the client in GiB, by number of workers; 0 stands for one process."""

    @property
    def throughput(self) -> list[float]:
        """Throughput of the workers over that of one process, for each seed."""
        return [
            alone_seconds / worker_seconds
            for alone_seconds, worker_seconds in zip(self.alone, self.workers, strict=True)
        ]


def step_count() -> int:
    """Return the number of steps of a scene: one for warming up, one for each seed, and two programs."""
    return 1 + len(SEEDS) + 2


def pair(name: str, path: Path, announce: Announce) -> Pair:
    """Return the results of a scene, rendered in both ways in turn; a first render in each way is not measured."""
    with open_workers(WORKERS) as workers, open_scene(path, size=SIZE) as view:
        drawer_for = workers(Request(path, size=SIZE), fingerprint(path))
        measured = Pair(name, view.pixel_count)
        for seed in (None, *SEEDS):
            announce(f"{name}: {'warming up' if seed is None else f'seed {seed}'}")
            settings = make_settings(spp=64 if seed is None else SPP, seed=seed or 0)
            start = time.perf_counter()
            alone = render_request(Request(view, settings))
            alone_end, processor = time.perf_counter(), time.process_time()
            request = Request(view, settings)
            with begun(request, view, drawer_for=drawer_for) as rendering:
                shared = complete(rendering, request)
            end, processor = time.perf_counter(), time.process_time() - processor
            if seed is None:
                continue
            measured.alone.append(alone_end - start)
            measured.workers.append(end - alone_end)
            measured.rounds.append(len(shared.report.rounds))
            measured.traffic.append(shared.report.elsewhere)
            measured.constants.append(constants_of(measured, alone, shared, processor))
            compare(measured, alone, shared)
    for count in (0, WORKERS):
        announce(f"{name}: whole program")
        measured.programs[str(count)] = program_seconds(path, count)
        measured.memory[str(count)] = client_memory(path, count)
    return measured


def compare(measured: Pair, alone: Result, shared: Result) -> None:
    """Add to ``measured`` the differences between the results of workers and of one process."""
    for layer in ("image", "samples", "stderr"):
        first, second = (np.asarray(getattr(result, layer), np.float64) for result in (alone, shared))
        difference = np.abs(first - second) / np.maximum(np.maximum(np.abs(first), np.abs(second)), 1e-30)
        measured.differing += int(np.count_nonzero(difference))
        measured.difference = max(measured.difference, float(difference.max()))


def constants_of(measured: Pair, alone: Result, shared: Result, processor: float) -> Constants:
    """Return the constants of the model that a pair of renders gives.

    ``processor``: seconds of processor time of the client with workers.
    """
    report, elsewhere = alone.report, shared.report.elsewhere
    samples = sum(entry.samples for entry in report.rounds)
    rounds = len(report.rounds)
    drawn = sum(entry.seconds for entry in report.rounds)
    deciding = report.seconds_deciding + report.seconds_pilot
    developing = max(shared.seconds - sum(entry.seconds for entry in shared.report.rounds) - deciding, 0.0)
    return Constants(
        sample=drawn * dr.thread_count() / samples,
        unit=max(processor - deciding - developing, 0.0) / elsewhere["units"],
        deciding=deciding / (max(rounds - 1, 1) * measured.pixels),
        developing=developing / measured.pixels,
        round_bytes=(elsewhere["bytes_received"] - elsewhere["bytes_of_sums"]) / (rounds * measured.pixels),
        sums_bytes=elsewhere["bytes_of_sums"] / measured.pixels,
    )


def program_seconds(path: Path, workers: int) -> float:
    """Return the seconds of a render by the command line; with 0 ``workers``, by one process."""
    worker_options = ["--workers", str(workers)] if workers else []
    with tempfile.TemporaryDirectory() as folder:
        output = Path(folder) / "out.exr"
        command = [sys.executable, "-m", "tracer", "render", str(path), "-o", str(output), "--spp", str(SPP), "-q"]
        start = time.perf_counter()
        subprocess.run([*command, "--size", str(SIZE[0]), *worker_options], check=True)
        return time.perf_counter() - start


def client_memory(path: Path, workers: int) -> float:
    """Return the largest memory (GiB) of a process that renders alone, with 0 ``workers``, or with workers."""
    with tempfile.TemporaryDirectory() as folder:
        script = Path(folder) / "memory.py"
        script.write_text(MEMORY.format(width=SIZE[0], height=SIZE[1], cluster=workers or None))
        program = subprocess.run([sys.executable, str(script), str(path)], check=True, capture_output=True, text=True)
    return int(program.stdout) / 2**20

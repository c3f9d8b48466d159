"""What the first picture of a program takes beyond the next ones: opening, tracing, compiling.

Run as a program of its own, ``python -m benchmarks.time.first_call SCENE WIDTH SPP WAY VARIANT``, with a home folder
without compiled kernels; it writes its numbers as JSON.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import drjit as dr
import mitsuba as mi

from tracer.core import backend

WAYS = ("owen_sobol", "uniform", "fused")
"""Ways that are timed, each in a program of its own."""


def first_call(path: Path, width: int, spp: int, way: str) -> dict[str, float]:
    """Return the seconds of the first picture in a new program. Raises CalledProcessError if it fails."""
    arguments = [str(path.resolve()), str(width), str(spp), way, mi.variant()]
    command = [sys.executable, "-m", "benchmarks.time.first_call", *arguments]
    with tempfile.TemporaryDirectory() as home:  # where Dr.Jit keeps compiled kernels
        ran = subprocess.run(
            command, env={**os.environ, "HOME": home}, check=True, capture_output=True, text=True, cwd=os.getcwd()
        )
    found: dict[str, float] = json.loads(ran.stdout.splitlines()[-1])
    return found


def main(path: Path, width: int, spp: int, name: str) -> dict[str, float]:
    """Render twice and return the seconds of each step."""
    from benchmarks.time.ways import open_ways

    start = time.perf_counter()
    with open_ways(path, width, (name,)) as (_, ways):
        opening = time.perf_counter() - start
        way = ways[name]
        with dr.scoped_set_flag(dr.JitFlag.KernelHistory, True):
            start = time.perf_counter()
            way(spp, 0)
            first = time.perf_counter() - start
            kernels: list[dict[str, Any]] = dr.kernel_history()
        start = time.perf_counter()
        way(spp, 1)
        second = time.perf_counter() - start
    compiling = sum(kernel.get("codegen_time", 0.0) + kernel.get("backend_time", 0.0) for kernel in kernels) / 1000
    numbers = {"opening": opening, "first": first, "compiling": compiling, "second": second}
    return {**numbers, "kernels": sum(not kernel.get("cache_hit", True) for kernel in kernels)}


if __name__ == "__main__":
    scene, width, spp, way_name, variant = sys.argv[1:]
    backend.activate(variant)
    sys.stdout.write(json.dumps(main(Path(scene), int(width), int(spp), way_name)) + "\n")

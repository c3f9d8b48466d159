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
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from tracer.core import backend
from tracer.scene.load import load
from tracer.scene.view import open_scene

Way = Callable[[int, int], Any]
"""Function of (spp, seed) that renders a picture."""
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


@contextmanager
def opened(path: Path, width: int, name: str) -> Iterator[Way]:
    """Open a scene for one way only, as a script would, and yield the way."""
    from benchmarks.time.ways import SAMPLERS, own_way

    stock = name in SAMPLERS
    with open_scene(load(path, sampler=name) if stock else path, size=width) as view:
        yield partial(render_stock, view) if stock else own_way(view, name)


def render_stock(view: Any, spp: int, seed: int) -> None:
    """Render by ``mi.render``."""
    np.array(view.integrator.render(view.scene, sensor=view.sensor, seed=seed, spp=spp))


def main(path: Path, width: int, spp: int, name: str) -> dict[str, float]:
    """Render twice and return the seconds of each step."""
    start = time.perf_counter()
    with opened(path, width, name) as way:
        opening = time.perf_counter() - start
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

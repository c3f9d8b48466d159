"""What showing and keeping a picture costs while it renders, and how well a limit of time is kept."""

from __future__ import annotations

import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.harness import Announce
from tracer import live
from tracer.io.exr import read_exr
from tracer.scene.view import View, open_scene
from tracer.session.render import begun, complete, render_request
from tracer.session.request import CheckpointFile, Request
from tracer.settings import make_settings

WAYS = ("plain", "live", "checkpoint")
WIDTH = 512
WANTED_SECONDS = 15.0
REPEATS = 3
KEEP_SECONDS = 5.0
LIMITS = (5.0, 15.0, 30.0)


def step_count() -> int:
    """Return how many steps a scene has."""
    return len(WAYS) * REPEATS + len(LIMITS)


@dataclass(frozen=True)
class Overhead:
    """One way to render, against plain rendering."""

    scene: str
    way: str
    seconds: float
    """Median."""
    share: float
    """Median over repeats of the seconds beyond those of the plain render next to it, as a part of these."""
    times: int
    """How often it showed, or wrote, in one render."""


def overheads(name: str, path: Path, announce: Announce) -> list[Overhead]:
    """Render a picture of some seconds in every way, one after the other, REPEATS times."""
    with open_scene(path, size=WIDTH) as view, tempfile.TemporaryDirectory() as folder:
        spp = spp_for(view, WANTED_SECONDS)
        seconds: dict[str, list[float]] = {}
        counts: dict[str, int] = {}
        for repeat in range(REPEATS):
            for way in WAYS:
                announce(f"{name}: {way}, {repeat + 1} of {REPEATS}")
                shown = live.png(Path(folder) / "now.png") if way == "live" else None
                file = CheckpointFile(Path(folder) / f"{repeat}.ckpt", KEEP_SECONDS) if way == "checkpoint" else None
                settings = make_settings(spp=spp, criterion="uniform", seed=repeat)
                request = Request(view, settings, progress=shown, checkpoint=file)
                start = time.perf_counter()
                with begun(request, view) as rendering:
                    complete(rendering, request)
                seconds.setdefault(way, []).append(time.perf_counter() - start)
                writes = rendering.keeper.writes.count if rendering.keeper is not None else 0
                counts[way] = writes if shown is None else shown.shown
    plain = np.array(seconds["plain"])
    return [
        Overhead(name, way, float(np.median(taken)), float(np.median(np.array(taken) / plain - 1)), counts[way])
        for way, taken in seconds.items()
    ]


def spp_for(view: View, seconds: float) -> int:
    """Return the samples per pixel that take about so long."""
    for spp in (4, 16):  # the first compiles
        start = time.perf_counter()
        render_request(Request(view, make_settings(spp=spp, criterion="uniform")))
        taken = time.perf_counter() - start
    return max(round(16 * seconds / taken), 1)


@dataclass(frozen=True)
class Limited:
    """A render by the command line with a limit of time."""

    scene: str
    limit: float
    seconds: float
    """Of the whole program."""
    spp: float


def limited(name: str, path: Path, announce: Announce) -> list[Limited]:
    """Render with every limit, as a program of its own."""
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for limit in LIMITS:
            announce(f"{name}: in {limit:g} s")
            output = Path(folder) / f"{limit:g}.exr"
            command = [sys.executable, "-m", "tracer", "render", str(path), "-o", str(output), "--time", str(limit)]
            start = time.perf_counter()
            subprocess.run([*command, "-q", "--size", str(WIDTH)], check=True)
            seconds = time.perf_counter() - start
            rows.append(Limited(name, limit, seconds, mean_samples(output)))
    return rows


def mean_samples(path: Path) -> float:
    """Return the mean samples per pixel of a picture."""
    names, values, _ = read_exr(path)
    return float(values[..., names.index("samples.Y")].mean())

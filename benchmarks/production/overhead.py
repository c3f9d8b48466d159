"""The cost of live pictures and checkpoints while a picture renders, and how well a limit of time is kept."""

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
"""Ways to render: without extras, with a live picture, with a checkpoint."""
WIDTH = 512
"""Width of the pictures in pixels."""
WANTED_SECONDS = 15.0
"""Approximate duration of a render, by which its samples are chosen."""
REPEATS = 3
"""Number of renders in every way."""
KEEP_SECONDS = 5.0
"""Seconds between two writes of the checkpoint."""
LIMITS = (5.0, 15.0, 30.0)
"""Limits of time in seconds."""


def step_count() -> int:
    """Return the number of steps of a scene."""
    return len(WAYS) * REPEATS + len(LIMITS)


@dataclass(frozen=True)
class Overhead:
    """Results of a way to render, against plain rendering."""

    scene: str
    way: str
    seconds: float
    """Median duration of a render."""
    share: float
    """Median over repeats of the extra time over the plain render next to it, as a share of the plain render's time."""
    times: int
    """Number of times that the last render showed the picture, or wrote the checkpoint."""


def overheads(name: str, path: Path, announce: Announce) -> list[Overhead]:
    """Return the overheads of a picture that takes ``WANTED_SECONDS``, rendered in all ways in turn, REPEATS times."""
    with open_scene(path, size=WIDTH) as view, tempfile.TemporaryDirectory() as folder:
        spp = spp_for(view, WANTED_SECONDS)
        seconds: dict[str, list[float]] = {}
        counts: dict[str, int] = {}
        for repeat in range(REPEATS):
            for way in WAYS:
                announce(f"{name}: {way}, {repeat + 1} of {REPEATS}")
                live_picture = live.png(Path(folder) / "now.png") if way == "live" else None
                checkpoint = (
                    CheckpointFile(Path(folder) / f"{repeat}.ckpt", KEEP_SECONDS) if way == "checkpoint" else None
                )
                settings = make_settings(spp=spp, criterion="uniform", seed=repeat)
                request = Request(view, settings, progress=live_picture, checkpoint=checkpoint)
                start = time.perf_counter()
                with begun(request, view) as rendering:
                    complete(rendering, request)
                seconds.setdefault(way, []).append(time.perf_counter() - start)
                writes = rendering.keeper.writes.count if rendering.keeper is not None else 0
                counts[way] = live_picture.shown if isinstance(live_picture, live.Occasional) else writes
    plain_seconds = np.array(seconds["plain"])
    return [
        Overhead(
            name,
            way,
            float(np.median(durations)),
            float(np.median(np.array(durations) / plain_seconds - 1)),
            counts[way],
        )
        for way, durations in seconds.items()
    ]


def spp_for(view: View, seconds: float) -> int:
    """Return the samples per pixel that take about so many seconds."""
    for spp in (4, 16):  # the first render compiles
        start = time.perf_counter()
        render_request(Request(view, make_settings(spp=spp, criterion="uniform")))
        duration = time.perf_counter() - start
    return max(round(16 * seconds / duration), 1)


@dataclass(frozen=True)
class Limited:
    """Result of a render by the command line with a limit of time."""

    scene: str
    limit: float
    seconds: float
    """Duration of the whole program."""
    spp: float
    """Mean samples per pixel."""


def limited(name: str, path: Path, announce: Announce) -> list[Limited]:
    """Return the results of a scene with every limit, each rendered by a program of its own."""
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

"""What is timed: scenes, sizes of pictures, and numbers of samples."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import mitsuba as mi

from benchmarks import harness
from benchmarks.time.many_shapes import write_scene
from benchmarks.time.measure import Case
from benchmarks.time.ways import CRITERIA
from tracer.core import backend

LONGEST = 60.0
"""Most seconds of a picture that is rendered in all ways, as those with SPPS[0] foretell."""
SHAPES = 1000
"""Number of shapes of the scene that is made for this benchmark."""
MADE = f"{SHAPES} shapes"
"""Name of that scene."""
WIDTH = 256
"""Width of the pictures of all scenes, in pixels."""
SPPS, MORE_SPPS = (16, 64), (4, 256)
"""Samples per pixel of the pictures of all scenes, and further ones for SIZED."""
SIZED = ("spheres_and_rods", "window_interior", MADE)
"""Scenes that are rendered with more numbers of samples, in several sizes, and with one thread."""
DEAREST = ("volume-smoke",)
"""Scenes whose samples take so long that their work is not compared with their time."""
SIZES = ((128, 72), (512, 288), (1280, 720), (1920, 1080), (3840, 2160))
"""Sizes of their pictures, (width, height)."""
MOST_SIZES_MADE = 3
"""Number of sizes in which MADE is rendered, from the smallest on: many shapes cost small pictures most."""
SCALED_SIZE, SCALED_SPPS = SIZES[3], (16, 64)
"""Size and samples per pixel of the pictures that tell what more cores would bring."""
SIZED_SPP, LARGE_SPP = 16, 64
"""Samples per pixel of these pictures, and of the largest ones once more."""


def all_scenes(public: Path, made: Path) -> dict[str, Path]:
    """Return the files of the bundled scenes, of those in a folder, and of one that is written to ``made``."""
    write_scene(made, SHAPES)
    paths = {path.stem: path for path in harness.bundled_scenes()}
    paths |= {path.parent.name: path for path in sorted(public.glob("*/scene.xml"))}
    return {**paths, MADE: made}


def all_cases(paths: dict[str, Path]) -> Iterable[Case]:
    """Yield what is rendered of the scenes with these names."""
    threads = backend.thread_count()
    for name, path in paths.items():
        for spp in (*SPPS, *(MORE_SPPS if name in SIZED else ())):
            yield Case(name, path, WIDTH, spp, threads)
    one_thread = mi.variant().startswith("llvm_")
    for name in SIZED:
        for size in SIZES[:MOST_SIZES_MADE] if name == MADE else SIZES:
            yield Case(name, paths[name], size, SIZED_SPP, threads)
        if one_thread:
            yield Case(name, paths[name], WIDTH, LARGE_SPP, 1, ("owen_sobol", *CRITERIA))
    yield Case(SIZED[0], paths[SIZED[0]], SIZES[-1], LARGE_SPP, threads)

"""Seconds and memory of the commands on files of millions of faces, each in a process of its own."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.harness import Announce
from tracer.core.arrays import Integers, Singles
from tracer.errors import TracerError
from tracer.scene.stl_mesh import HEADER, TRIANGLE

FACES, ATOMS = 5_000_000, 100_000
"""Number of faces of the meshes, about, and of atoms of the molecule."""
COMMANDS = {
    "view best --level 2": ("view", "best", "{file}", "-o", "{output}", "--level", "2", "--overwrite", "--quiet"),
    "render --spp 16": ("render", "{file}", "-o", "{output}.exr", "--spp", "16", "--overwrite", "--quiet"),
}
"""Words of each command."""
STARTER = """
import resource, subprocess, sys
code = subprocess.run(sys.argv[1:], stdout=subprocess.DEVNULL).returncode
usage = resource.getrusage(resource.RUSAGE_CHILDREN)
print(usage.ru_utime + usage.ru_stime, usage.ru_maxrss)
raise SystemExit(code)
"""
"""Program that runs the words after it as a process, and prints its seconds of all processors and its peak memory."""
KIBI = 1 if sys.platform == "darwin" else 1024
"""Bytes of the unit in which the system tells the peak memory of a process."""
SPACING, JITTER = 1.6, 0.2
"""Distance of neighbouring atoms, and how far each is moved at random along each axis, in Angstrom."""


def step_count() -> int:
    """Return the number of steps."""
    return sum(len(commands) for _, commands in FILES.values())


def large_files(announce: Announce) -> list[dict[str, Any]]:
    """Return what each command on each file costs, see ``cost_of``. Raises TracerError if one fails."""
    rows = []
    with TemporaryDirectory() as folder:
        for name, (write, commands) in FILES.items():
            file = Path(folder) / name
            size = write(file)
            for command in commands:
                announce(f"large files: {name}, {command}")
                words = [word.format(file=file, output=Path(folder) / "output") for word in COMMANDS[command]]
                seconds, memory = cost_of([sys.executable, "-m", "tracer", *words])
                megabytes = file.stat().st_size / 1e6
                row = {"file": name, "size": size, "megabytes": megabytes, "command": command}
                rows.append({**row, "seconds": seconds, "gigabytes": memory / 1e9})
            file.unlink()
    return rows


def cost_of(words: list[str]) -> tuple[float, float]:
    """Return the seconds of all processors and the peak memory in bytes of a process. Raises TracerError if it fails.

    Linux counts the memory of the process that starts another one as the other one's, so a small one starts it.
    """
    starter = [sys.executable, "-c", STARTER, *words]
    finished = subprocess.run(starter, stdout=subprocess.PIPE, text=True, check=False)
    if finished.returncode:
        raise TracerError(f"'{' '.join(words)}' failed; its message is above.")
    seconds, memory = finished.stdout.split()
    return float(seconds), int(memory) * KIBI


def landscape(count: int) -> tuple[Singles, Integers]:
    """Return the vertices (N, 3) and the triangles (F, 3), about ``count``, of hills and valleys."""
    side = round(np.sqrt(count / 2)) + 1
    x, y = np.meshgrid(np.linspace(0, 1, side), np.linspace(0, 1, side))
    vertices = np.stack([x, y, 0.1 * np.sin(9 * x) * np.cos(7 * y)], axis=-1).reshape(-1, 3).astype(np.float32)
    number = np.arange(side * side).reshape(side, side)
    a, b, c, d = (part.ravel() for part in (number[:-1, :-1], number[:-1, 1:], number[1:, :-1], number[1:, 1:]))
    return vertices, np.concatenate([np.stack([a, b, d], axis=1), np.stack([a, d, c], axis=1)])


def write_ply(path: Path) -> str:
    """Write the landscape as PLY, and return what it has."""
    vertices, faces = landscape(FACES)
    header = f"ply\nformat binary_little_endian 1.0\nelement vertex {len(vertices)}\n"
    header += "".join(f"property float {axis}\n" for axis in "xyz")
    header += f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    table: NDArray[Any] = np.zeros(len(faces), [("count", "u1"), ("corners", "<i4", 3)])
    table["count"], table["corners"] = 3, faces
    path.write_bytes(header.encode() + vertices.tobytes() + table.tobytes())
    return f"{len(faces)} faces"


def write_stl(path: Path) -> str:
    """Write the landscape as binary STL, and return what it has."""
    vertices, faces = landscape(FACES)
    table = np.zeros(len(faces), TRIANGLE)
    table["corners"] = vertices[faces]
    path.write_bytes(bytes(HEADER - 4) + np.uint32(len(faces)).tobytes() + table.tobytes())
    return f"{len(faces)} faces"


def write_xyz(path: Path) -> str:
    """Write a cube of atoms that are slightly out of order, and return what it has."""
    side = int(np.ceil(np.cbrt(ATOMS)))
    places = np.stack(np.meshgrid(*3 * [np.arange(side)]), axis=-1).reshape(-1, 3)[:ATOMS] * SPACING
    places += np.random.default_rng(0).uniform(-JITTER, JITTER, places.shape)
    lines = (f"{symbol} {x:.3f} {y:.3f} {z:.3f}" for symbol, (x, y, z) in zip("CCNO" * ATOMS, places, strict=False))
    path.write_text(f"{len(places)}\nmade up\n" + "\n".join(lines) + "\n")
    return f"{len(places)} atoms"


FILES: dict[str, tuple[Callable[[Path], str], tuple[str, ...]]] = {
    "landscape.ply": (write_ply, ("view best --level 2", "render --spp 16")),
    "landscape.stl": (write_stl, ("view best --level 2", "render --spp 16")),
    "atoms.xyz": (write_xyz, ("view best --level 2",)),
}
"""For each file, the function that writes it, and the commands that are run on it."""

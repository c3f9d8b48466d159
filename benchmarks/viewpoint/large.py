"""Seconds and memory of the commands on files of millions of faces, each in a process of its own."""

from __future__ import annotations

import json
import struct
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
from tracer.viewpoint.atom_files import read_atoms

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
PROTEIN, GAP = "1hpv.pdb", 3.0
"""File of the protein of which the molecule has copies, and the gaps between them, in Angstrom."""
NAMES = ("group_PDB", "id", "type_symbol", "label_atom_id", "label_alt_id", "label_comp_id", "label_asym_id")
PLACES = ("label_seq_id", "Cartn_x", "Cartn_y", "Cartn_z")
"""NAMES and PLACES: the columns of the table of atoms in an mmCIF file."""
GLB_MAGIC, GLB_JSON, GLB_BINARY, GLB_SINGLE, GLB_UNSIGNED = 0x46546C67, 0x4E4F534A, 0x004E4942, 5126, 5125
"""Numbers of glTF, in a single file: its own, of its two parts, of numbers in single precision and of 32 bits."""


def step_count() -> int:
    """Return the number of steps."""
    return sum(len(commands) for _, commands in FILES.values())


def large_files(public: Path, announce: Announce) -> list[dict[str, Any]]:
    """Return what each command on each file costs, see ``cost_of``; ``public`` has the protein.

    Raises TracerError if one fails.
    """
    rows = []
    with TemporaryDirectory() as folder:
        for name, (write, commands) in FILES.items():
            file = Path(folder) / name
            size = write(file, public)
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


def write_ply(path: Path, public: Path) -> str:
    """Write the landscape as PLY, and return what it has."""
    vertices, faces = landscape(FACES)
    header = f"ply\nformat binary_little_endian 1.0\nelement vertex {len(vertices)}\n"
    header += "".join(f"property float {axis}\n" for axis in "xyz")
    header += f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    table: NDArray[Any] = np.zeros(len(faces), [("count", "u1"), ("corners", "<i4", 3)])
    table["count"], table["corners"] = 3, faces
    path.write_bytes(header.encode() + vertices.tobytes() + table.tobytes())
    return f"{len(faces)} faces"


def write_stl(path: Path, public: Path) -> str:
    """Write the landscape as binary STL, and return what it has."""
    vertices, faces = landscape(FACES)
    table = np.zeros(len(faces), TRIANGLE)
    table["corners"] = vertices[faces]
    path.write_bytes(bytes(HEADER - 4) + np.uint32(len(faces)).tobytes() + table.tobytes())
    return f"{len(faces)} faces"


def write_glb(path: Path, public: Path) -> str:
    """Write the landscape as glTF in a single file, and return what it has."""
    vertices, faces = landscape(FACES)
    corners = faces.astype("<u4")
    places = {"bufferView": 0, "componentType": GLB_SINGLE, "count": len(vertices), "type": "VEC3"}
    places |= {"min": vertices.min(axis=0).tolist(), "max": vertices.max(axis=0).tolist()}
    head = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [
            places,
            {"bufferView": 1, "componentType": GLB_UNSIGNED, "count": corners.size, "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteLength": vertices.nbytes},
            {"buffer": 0, "byteOffset": vertices.nbytes, "byteLength": corners.nbytes},
        ],
        "buffers": [{"byteLength": vertices.nbytes + corners.nbytes}],
    }
    text = json.dumps(head).encode()
    text += b" " * (-len(text) % 4)
    binary = vertices.tobytes() + corners.tobytes()
    length = 12 + 8 + len(text) + 8 + len(binary)
    parts = (struct.pack("<3I2I", GLB_MAGIC, 2, length, len(text), GLB_JSON), text)
    path.write_bytes(b"".join([*parts, struct.pack("<2I", len(binary), GLB_BINARY), binary]))
    return f"{len(faces)} faces"


def write_obj(path: Path, public: Path) -> str:
    """Write the landscape as OBJ, and return what it has."""
    vertices, faces = landscape(FACES)
    with path.open("w") as file:
        np.savetxt(file, vertices, "v %.6f %.6f %.6f")
        np.savetxt(file, faces + 1, "f %d %d %d")
    return f"{len(faces)} faces"


def write_mmcif(path: Path, public: Path) -> str:
    """Write copies of a protein side by side as mmCIF, and return what it has."""
    import gemmi

    protein = read_atoms(public / PROTEIN)
    copy_count = -(-ATOMS // len(protein))
    side = int(np.ceil(np.cbrt(copy_count)))
    cells = np.stack(np.meshgrid(*3 * [np.arange(side)]), axis=-1).reshape(-1, 3)[:copy_count]
    step = np.ptp(protein.positions, axis=0) + GAP
    places = (cells[:, None] * step + protein.positions).reshape(-1, 3)[:ATOMS]
    symbols = (protein.symbols * copy_count)[:ATOMS]
    numbers = [str(number) for number in range(1, ATOMS + 1)]
    chains = [f"A{number // len(protein)}" for number in range(ATOMS)]
    table = [["ATOM"] * ATOMS, numbers, symbols, symbols, ["."] * ATOMS, ["UNK"] * ATOMS, chains]
    table.append([str(1 + number % len(protein)) for number in range(ATOMS)])
    table += [[f"{value:.3f}" for value in column] for column in places.T]
    document = gemmi.cif.Document()
    document.add_new_block("copies").init_loop("_atom_site.", [*NAMES, *PLACES]).set_all_values(table)
    document.write_file(str(path))
    return f"{ATOMS} atoms"


FILES: dict[str, tuple[Callable[[Path, Path], str], tuple[str, ...]]] = {
    "landscape.ply": (write_ply, ("view best --level 2", "render --spp 16")),
    "landscape.stl": (write_stl, ("view best --level 2", "render --spp 16")),
    "landscape.glb": (write_glb, ("view best --level 2",)),
    "landscape.obj": (write_obj, ("view best --level 2",)),
    "proteins.cif": (write_mmcif, ("view best --level 2",)),
}
"""For each file, the function that writes it, and the commands that are run on it."""

"""Meshes in PLY, OBJ and Mitsuba's own format that are cut short, lie about their size or hold no numbers."""

import struct
import zlib

from .scene_inputs import render
from .scenery import MESH, xml

POINTS = [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)]
FACES = [(0, 1, 2), (0, 2, 3)]
INDICES = [-1, -2147483648, 4, 100, 65536, 2147483647, 4294967295]
COUNTS = [0, 1, 3, 5, -1, 100, 10**6, 10**8, 2**31 - 1, 2**31, 2**32, 2**32 + 4, 2**63, 10**30, "", "x", "1e3"]
NUMBERS = ["nan", "inf", "-inf", "1e30", "-1e38", "1e39", "1e-45", "", "x", "0x1", "1,5"]


def ply_header(form, points, faces, extra=""):
    return (
        f"ply\nformat {form} 1.0\nelement vertex {points}\nproperty float x\nproperty float y\nproperty float z\n"
        f"{extra}element face {faces}\nproperty list uchar int vertex_indices\nend_header\n"
    )


def ply_text(points=POINTS, faces=FACES, counts=(4, 2)):
    lines = [*(" ".join(map(str, one)) for one in points), *(f"{len(one)} " + " ".join(map(str, one)) for one in faces)]
    return (ply_header("ascii", *counts) + "\n".join(lines) + "\n").encode()


def ply_bytes(points=POINTS, faces=FACES, counts=(4, 2), order="<"):
    data = b"".join(struct.pack(f"{order}3f", *one) for one in points)
    data += b"".join(struct.pack(f"{order}B3I", 3, *(k & 0xFFFFFFFF for k in one)) for one in faces)
    form = "binary_little_endian" if order == "<" else "binary_big_endian"
    return ply_header(form, *counts).encode() + data


def obj_text(points=POINTS, faces=FACES):
    lines = [*("v " + " ".join(map(str, one)) for one in points)]
    lines += ["f " + " ".join(str(k + 1) for k in one) for one in faces]
    return ("\n".join(lines) + "\n").encode()


def serialized(points=POINTS, faces=FACES, counts=(4, 2), shapes=1):
    data = struct.pack("<I", 0x1000) + b"mesh\0" + struct.pack("<QQ", *(count & (2**64 - 1) for count in counts))
    data += b"".join(struct.pack("<3f", *one) for one in points)
    data += b"".join(struct.pack("<3I", *(k & 0xFFFFFFFF for k in one)) for one in faces)
    return struct.pack("<HH", 0x041C, 4) + zlib.compress(data) + struct.pack("<QI", 0, shapes)


WRITERS = {"ply": (ply_text, ply_bytes), "obj": (obj_text,), "serialized": (serialized,)}


def show(random, folder, kind, data, name=None):
    """Write a mesh and a scene around it; return how that is rendered."""
    name = name or f"mesh.{kind}"
    (folder / name).write_bytes(data)
    return render(folder, xml(MESH.format(kind=kind, file=name)), "--size", "6")


def damaged_meshes(random, folder):
    """Cut a mesh short or flip bytes of it."""
    kind = random.choice(list(WRITERS))
    data = bytearray(random.choice(WRITERS[kind])())
    if random.random() < 0.4:
        data = data[: random.randrange(len(data))]
    for _ in range(random.choice([0, 1, 1, 2, 10])):
        if data:
            data[random.randrange(len(data))] = random.choice([0, 10, 32, 48, 255, random.randrange(256)])
    return show(random, folder, kind, bytes(data))


def lying_meshes(random, folder):
    """Headers with other counts, faces with vertices that do not exist, vertices that are no numbers."""
    what = random.choice(["counts", "counts", "indices", "indices", "numbers", "faces", "shapes"])
    kind = random.choice(["ply", "ply", "obj", "serialized"])
    points, faces = [list(one) for one in POINTS], [list(one) for one in FACES]
    keywords = {}
    if what == "counts" and kind != "obj":
        counts = [4, 2]
        counts[random.randrange(2)] = random.choice(
            COUNTS if kind == "ply" else [one for one in COUNTS if isinstance(one, int)]
        )
        keywords["counts"] = counts
    elif what == "indices":
        faces[random.randrange(2)][random.randrange(3)] = random.choice(INDICES)
    elif what == "faces":
        faces = random.choice([[], [(0, 0, 0)], [(0, 1, 2)] * 3])
    elif what == "shapes" and kind == "serialized":
        keywords["shapes"] = random.choice([0, 2, 2**31, 2**32 - 1])
    number = random.choice(NUMBERS) if what == "numbers" else None
    writer = random.choice(WRITERS[kind])
    if number is not None:
        if writer in (ply_bytes, serialized):
            number = float(number) if number in ("nan", "inf", "-inf", "1e30", "-1e38") else 1e-40
        points[random.randrange(4)][random.randrange(3)] = number
    return show(random, folder, kind, writer(points, faces, **keywords))


HEADERS = (
    b"ply\n",
    b"ply\nend_header\n",
    b"ply\r\nformat ascii 1.0\r\nend_header\r\n",
    b"ply\nformat ascii 2.0\nend_header\n",
    b"ply\nformat nothing 1.0\nelement vertex 1\nend_header\n",
    ply_header("ascii", 0, 0).encode(),
    ply_header("binary_little_endian", 0, 0).encode(),
    ply_header("ascii", 4, 2, extra="property list uchar float s\n").encode() + b"0 0 0 1 1\n" * 4,
    ply_header("binary_little_endian", 4, 2, extra="property double x\n").encode() + bytes(100),
    ply_header("binary_little_endian", 4, 2).replace("uchar int", "int uchar").encode() + bytes(100),
    ply_header("binary_little_endian", 4, 2).replace("list uchar int", "float").encode() + bytes(100),
    ply_header("binary_little_endian", 4, 2).encode() + b"".join(bytes(12) for _ in range(4)) + b"\xff" * 26,
    ply_header("ascii", 4, 2).encode() + b"0 0 0\n" * 4 + b"200 0 1 2\n" * 2,
    b"",
    b"\0" * 64,
    b"\x1c\x04\x04\x00",
    b"\x1c\x04\x04\x00" + bytes(12),
    b"f 1 2 3\n",
    b"v 0 0 0\nf 1/1/1 1/1/1 1/1/1\n",
    b"v 0 0\nv 1\nv\nf\nf 1\nf 1 2\n",
    b"f -1 -2 -3\nv 0 0 0\n",
    b"v 0 0 0\n" * 4 + b"f 1 2 3 4 1 2 3 4\n",
    b"v 0 0 0\n" * 4 + b"f 1// 2// 3//\nf 0 0 0\n",
    b"mtllib nothing.mtl\nusemtl x\nv " + b"9" * 400 + b" 0 0\n",
)


def odd_meshes(random, folder):
    """Files of another format than the scene says, without content, folders, or nothing at all."""
    kind = random.choice(list(WRITERS))
    case = random.random()
    if case < 0.1:
        return render(folder, xml(MESH.format(kind=kind, file=random.choice(["no.ply", "", ".", "a/b.obj"]))))
    if case < 0.2:
        (folder / "mesh").mkdir()
        return render(folder, xml(MESH.format(kind=kind, file="mesh")))
    if case < 0.4:
        other = random.choice(list(WRITERS))
        return show(random, folder, kind, random.choice(WRITERS[other])())
    return show(random, folder, kind, random.choice(HEADERS))

"""Checkpoints that are damaged, of another render, or whose parts do not fit together."""

import functools
import io
import json
import threading
import zipfile
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

import tracer

from .scene_inputs import render
from .scenery import SCENES, xml

SCENE = xml(SCENES["plain"])
HEADER = "header"
SPP = 9
lock = threading.Lock()


def whole(seed):
    """Return the bytes of a checkpoint of the scene."""
    with lock:
        return made(seed)


@functools.cache
def made(seed):
    with TemporaryDirectory() as name:
        (Path(name) / "scene.xml").write_text(SCENE)
        kept = Path(name) / "kept.ckpt"
        tracer.render(Path(name) / "scene.xml", spp=SPP, seed=seed, size=6, checkpoint=kept)
        return kept.read_bytes()


def opened(data):
    """Return header and arrays."""
    with np.load(io.BytesIO(data)) as archive:
        arrays = {name: archive[name] for name in archive.files}
    return json.loads(arrays.pop(HEADER).tobytes()), arrays


def closed(header, arrays):
    file = io.BytesIO()
    text = header if isinstance(header, bytes) else json.dumps(header).encode()
    np.savez(file, **{HEADER: np.frombuffer(text, np.uint8), **arrays})
    return file.getvalue()


def damaged(random, data):
    data = bytearray(data)
    if random.random() < 0.4:
        return bytes(data[: random.randrange(len(data))])
    for _ in range(random.choice([1, 1, 5])):
        data[random.choice([random.randrange(len(data)), -random.randrange(1, 600)])] = random.randrange(256)
    return bytes(data)


PLAIN = (None, True, -1, 0, 1, 2.5, 1e308, 2**63, 10**30, "", "x", [], {}, [1, 2], [[]], [-1, -1], float("nan"))


def changed_header(random, data):
    """Change, remove or add an entry of the header, at any depth."""
    header, arrays = opened(data)
    place, steps = header, random.choice([1, 2, 2, 3])
    for _ in range(steps):
        keys = list(place) if isinstance(place, dict) else list(range(len(place)))
        if not keys:
            break
        key = random.choice(keys)
        if isinstance(place[key], dict | list) and place[key] and random.random() < 0.8:
            place = place[key]
            continue
        if random.random() < 0.2:
            del place[key]
        else:
            place[key] = random.choice(PLAIN)
        break
    if random.random() < 0.1:
        header["more"] = 1
    return closed(header, arrays)


def changed_arrays(random, data):
    """Change shape, kind or values of an array, remove it or give it another name."""
    header, arrays = opened(data)
    name = random.choice(list(arrays))
    array = arrays[name]
    what = random.choice(["remove", "rename", "shape", "kind", "values", "empty", "swap", "strings"])
    if what == "remove":
        del arrays[name]
    elif what == "rename":
        arrays[random.choice(["other", "estimate.99", "held_out.0", "before.mean", "allocation", name + "x"])] = array
    elif what == "shape":
        arrays[name] = random.choice([array.ravel(), array[..., None], array[:1], array[None], array.T])
    elif what == "kind":
        arrays[name] = array.astype(random.choice(["float16", "float64", "int8", "uint32", "bool", "complex64", "U4"]))
    elif what == "values":
        arrays[name] = array.copy()
        with np.errstate(all="ignore"):
            arrays[name].flat[: random.choice([1, None])] = np.asarray(
                random.choice([np.nan, np.inf, -1.0, 1e30, 0.0, 2.0**40])
            ).astype(array.dtype)
    elif what == "empty":
        arrays[name] = np.zeros(random.choice([0, (0, 3), ()]), array.dtype)
    elif what == "swap":
        other = random.choice(list(arrays))
        arrays[name], arrays[other] = arrays[other], arrays[name]
    elif what == "strings":
        arrays[name] = np.array(["a", "b"])
    return closed(header, arrays)


def odd(random, data):
    """Return archives that are no checkpoints, and files that are no archives."""
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr(random.choice(["header.npy", "../header.npy", "x"]), random.choice([b"", b"\x93NUMPY", b"x"]))
    header, arrays = opened(data)
    pickled = io.BytesIO()
    np.savez(pickled, **{HEADER: np.array([{"format": 1}], dtype=object)}, allow_pickle=True)
    single = io.BytesIO()
    np.save(single, np.zeros(3))
    texts = (b"[]", b"{}", b"null", b"{" * 2000, b'"x"', b"\xff", json.dumps({**header, "format": 2}).encode())
    choices = (b"", b"PK\x05\x06" + bytes(18), file.getvalue(), pickled.getvalue(), single.getvalue(), data * 2)
    return random.choice([*choices, *(closed(text, arrays) for text in texts)])


BREAK = (damaged, changed_header, changed_header, changed_arrays, changed_arrays, odd)


def resumed(random, folder):
    """Go on from a broken checkpoint."""
    data = random.choice(BREAK)(random, whole(0))
    (folder.parent / "out" / "state.ckpt").write_bytes(data)
    options = ["--checkpoint", str(folder.parent / "out" / "state.ckpt"), "--resume", "--size", "6"]
    return render(folder, SCENE, *options, "--spp", str(random.choice([SPP, SPP + 3, 1])))


def merged(random, folder):
    """Merge checkpoints of which one is broken."""
    parts = [whole(0), whole(1)]
    parts[random.randrange(2)] = random.choice(BREAK)(random, random.choice(parts))
    paths = [folder / f"{number}.ckpt" for number in range(2)]
    for path, data in zip(paths, parts, strict=True):
        path.write_bytes(data)
    return ["merge", *map(str, paths), "-o", str(folder.parent / "out" / "out.exr"), "-q"]

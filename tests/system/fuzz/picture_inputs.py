"""Pictures that are cut short, damaged, empty or hold no numbers: textures, skies, importance, and what is scored."""

import struct
import zlib

import numpy as np
import OpenImageIO as oiio

from .scene_inputs import render
from .scenery import SCENES, SKY, TEXTURED, pixels, xml

SUFFIXES = ("exr", "png", "hdr", "pfm", "jpg", "tif", "bmp", "tga", "ppm")
FLOATING = ("exr", "hdr", "pfm", "tif")
NUMBERS = (np.nan, np.inf, -np.inf, -1.0, 0.0, 3e38, 1e-45)
SIZES = ((8, 8), (1, 1), (1, 9), (7, 7), (16, 3), (33, 33))


def encoded(folder, suffix, values, names=None, **attributes):
    """Return the bytes of a picture file."""
    path = folder / f"made.{suffix}"
    height, width, count = values.shape
    form = "float" if suffix in FLOATING else "uint8"
    specification = oiio.ImageSpec(width, height, count, attributes.pop("form", form))
    if names is not None:
        specification.channelnames = names
    for name, value in attributes.items():
        specification.attribute(name, value)
    output = oiio.ImageOutput.create(str(path))
    if not output.open(str(path), specification):
        return b""
    output.write_image(np.ascontiguousarray(values if form == "float" else np.clip(np.nan_to_num(values), 0, 1)))
    output.close()
    data = path.read_bytes()
    path.unlink()
    return data


def valid(random, folder, suffix, size=None):
    height, width = size or random.choice(SIZES)
    channels = 3 if suffix in ("hdr", "pfm", "jpg", "bmp", "ppm") else random.choice([1, 3, 3, 4])
    return encoded(folder, suffix, pixels(random, height, width, channels))


def damaged(random, folder, suffix):
    """Return a picture that was cut short, or with other bytes in it, mostly in its header."""
    data = bytearray(valid(random, folder, suffix))
    if random.random() < 0.4:
        data = data[: random.randrange(len(data))]
    for _ in range(random.choice([0, 1, 2, 2, 8])):
        if data:
            place = random.randrange(min(len(data), random.choice([32, 400, len(data)])))
            data[place] = random.choice([0, 1, 127, 128, 255, random.randrange(256)])
    return mend(bytes(data)) if suffix == "png" and random.random() < 0.5 else bytes(data)


def mend(data):
    """Return a damaged PNG with checksums that agree, so that readers look further."""
    result, place = data[:8], 8
    while place + 12 <= len(data):
        length = int.from_bytes(data[place : place + 4], "big")
        body = data[place + 4 : place + 8 + length]
        result += data[place : place + 4] + body + struct.pack(">I", zlib.crc32(body))
        place += 12 + length
    return result


def strange(random, folder, suffix):
    """Return a picture whose pixels are no numbers, or infinite, or negative; all of them or some."""
    values = pixels(random, *random.choice(SIZES))
    for _ in range(random.choice([1, 1, 3])):
        place = tuple(random.randrange(length) for length in values.shape)
        values[place if random.random() < 0.7 else ...] = random.choice(NUMBERS)
    return encoded(folder, suffix, values)


PAM = b"P7\nWIDTH 2\nHEIGHT 2\nDEPTH 3\nMAXVAL 255\nTUPLTYPE RGB\nENDHDR\n"
HEADERS = (
    b"",
    b"\0",
    b"\x76\x2f\x31\x01",
    b"\x76\x2f\x31\x01\x02\0\0\0\0",
    b"\x89PNG\r\n\x1a\n",
    mend(b"\x89PNG\r\n\x1a\n" + struct.pack(">I4sIIBBBBBI", 13, b"IHDR", 2**30, 2**30, 8, 2, 0, 0, 0, 0)),
    mend(b"\x89PNG\r\n\x1a\n" + struct.pack(">I4sIIBBBBBI", 13, b"IHDR", 0, 0, 8, 2, 0, 0, 0, 0)),
    b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X 4\n",
    b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2000000000 +X 2000000000\n",
    b"#?RADIANCE\n\n-Y 0 +X 0\n",
    b"PF\n2 2\n-1.0\n" + bytes(7),
    b"PF\n100000 100000\n-1.0\n",
    b"PF\n-2 2\n-1.0\n" + bytes(48),
    b"P6\n2 2\n255\n",
    b"P6\n90000 90000\n255\n",
    b"\xff\xd8\xff\xe0",
    b"BM" + bytes(60),
    b"II*\0\x08\0\0\0\xff\xff",
    PAM,
    b"GIF89a\xff\xff\xff\xff",
    b"<scene/>",
)


def some_picture(random, folder):
    """Return suffix and bytes of a picture; one in ten is whole."""
    suffix = random.choice((*SUFFIXES, "exr", "exr", "png"))
    make = random.choice([valid, damaged, damaged, damaged, damaged, strange, strange, strange, odd])
    return suffix, make(random, folder, suffix)


def odd(random, folder, suffix):
    return random.choice(HEADERS)


def put(random, folder, name="picture"):
    """Write a picture, or leave a folder or nothing in its place; return its name."""
    suffix, data = some_picture(random, folder)
    path = folder / f"{name}.{suffix}"
    case = random.random()
    if case < 0.03:
        path.mkdir()
    elif case > 0.06:
        path.write_bytes(data)
    return path.name


def textures(random, folder):
    body = random.choice([TEXTURED, TEXTURED, SKY]).format(file=put(random, folder))
    if random.random() < 0.2:
        body = body.replace('"bilinear"', '"nearest"').replace('"repeat"', random.choice(['"clamp"', '"none"']))
    return render(folder, xml(body), "--size", "6")


def importance(random, folder):
    name = put(random, folder)
    return render(folder, xml(SCENES["plain"]), "--size", "6", "--importance", str(folder / name), "--spp", "9")


NAMES = (("R", "G", "B"), ("B", "G", "R"), ("Y",), ("X", "Y", "Z"), ("a.R", "a.G", "a.B"), ("R", "G"), ("", "", ""))
NAMES += (("R", "R", "R"), ("ViewLayer.Combined.R", "ViewLayer.Combined.G", "ViewLayer.Combined.B"), ("Y", "A"))
NAMES += (("R", "G", "B", "A", "samples.Y", "stderr.R", "stderr.G", "stderr.B"), ("u", "v", "w"))


def scores(random, folder):
    """Pictures of which one at least is odd, of other layers or of another size."""
    paths = []
    for number in range(random.choice([1, 2, 2, 3])):
        path = folder / f"{number}.exr"
        size = random.choice([(8, 8)] * 16 + list(SIZES))
        case = random.random()
        if case < 0.5:
            names = random.choice((NAMES[0],) * 16 + NAMES)
            form = random.choice(["float", "float", "half", "uint32"])
            data = encoded(folder, "exr", pixels(random, *size, len(names)), names, form=form)
            path.write_bytes(data)
        elif case < 0.75:
            path.write_bytes(encoded(folder, "exr", scaled(random, pixels(random, *size))))
        else:
            path = folder / put(random, folder, str(number))
        paths.append(str(path))
    if random.random() < 0.2:
        paths.append(paths[0])
    layer = ["--layer", random.choice(["a", "", "b", "ViewLayer.Combined", "é"])] if random.random() < 0.2 else []
    return ["score", *paths, *layer, *random.choice([["--json"], ["--json"], []])]


def scaled(random, values):
    return values * np.float32(random.choice([0.0, -1.0, 1e-40, 1e30, 3e38, 1.0]))

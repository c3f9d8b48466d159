"""Volumes and spectra that are cut short, lie about their size or hold no numbers."""

import struct

from .scene_inputs import render, small
from .scenery import FOG, PLAIN, xml

VOLUME = (
    '<medium name="interior" type="heterogeneous"><volume name="albedo" type="constvolume"><rgb name="value" '
    'value="0.8"/></volume><volume name="sigma_t" type="gridvolume"><string name="filename" value="{file}"/></volume>'
)
FOGGY = FOG.replace(FOG[FOG.index("<medium") : FOG.index("<phase")], VOLUME)
NUMBERS = ("nan", "inf", "-inf", "-1", "0", "1e30", "1e39", "0.5", "2")
DENSITIES = (float("nan"), -1.0, 0.0, 0.5, 3.0)
"""Not infinite: Mitsuba walks through such a medium in steps of no length, and does not come to an end."""
SIZES = (0, 1, 2, 3, -1, 1000, 2**31 - 1, -(2**31))


def grid(size=(2, 2, 2), form=1, channels=1, version=3, values=None, box=(0, 0, 0, 1, 1, 1)):
    """Return a volume in Mitsuba's own format."""
    values = [0.5] * (8 * max(channels, 1)) if values is None else values
    header = b"VOL" + struct.pack("<B5i6f", version, form, *size, channels, *box)
    return header + struct.pack(f"<{len(values)}f", *values)


def volumes(random, folder):
    size, values = [2, 2, 2], [random.random() for _ in range(8)]
    keywords = {}
    what = random.choice(["none", "size", "size", "form", "channels", "version", "values", "values", "box", "bytes"])
    if what == "size":
        size[random.randrange(3)] = random.choice(SIZES)
    elif what in ("form", "channels", "version"):
        keywords[what] = random.choice([0, 1, 2, 3, 4, 6, 255])
    elif what == "values":
        values[random.randrange(8)] = random.choice(DENSITIES)
    elif what == "box":
        keywords["box"] = [float(random.choice(NUMBERS[:6])) for _ in range(6)]
    data = bytearray(grid(size, values=values, **keywords))
    if what == "bytes":
        data = data[: random.randrange(len(data))]
        for _ in range(random.choice([0, 1, 3])):
            if data:
                data[random.randrange(len(data))] = random.randrange(256)
    (folder / "fog.vol").write_bytes(data)
    return render(folder, xml(FOGGY.format(file=random.choice(["fog.vol"] * 12 + ["no.vol", "."]))), *small(random))


SPECTRUM = '"><spectrum name="radiance" filename="light.spd"/></emitter>'


def spectra(random, folder):
    """Emitters whose spectrum is a text file of wavelengths and values."""
    start = random.choice([300, 400, 400, 0, -5])
    lines = [[str(start + 40 * k), f"{random.random():.3f}"] for k in range(random.choice([0, 1, 2, 8, 8, 8]))]
    for _ in range(random.choice([0, 1, 1, 2])):
        if lines:
            random.choice(lines)[random.randrange(2)] = random.choice([*NUMBERS, "", "x", "400", "1 2", "#", "1,2"])
    text = "\n".join(" ".join(line) for line in lines).encode()
    if random.random() < 0.15:
        text = bytes(random.randrange(256) for _ in range(100))
    (folder / "light.spd").write_bytes(text)
    body = PLAIN[: PLAIN.index('constant">')] + "constant" + SPECTRUM
    return render(folder, xml(body), *small(random))

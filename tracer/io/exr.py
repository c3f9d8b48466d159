"""Files: always whole or not at all. One EXR with named layers, PNG for looking at."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from tracer.errors import OutputError, WriteError
from tracer.io.atomic import whole

Window = tuple[int, int, int, int]
"""x and y of the pixels within a picture, and width and height of the picture."""
Chosen = Literal["all", "rgb"]
"""Layers that are written."""


def layers_of(channels: Iterable[str]) -> set[str]:
    """Return the layers that we write with these channels: what is before the first dot, and "stderr"."""
    return {"stderr", *(name.partition(".")[0] for name in channels)}


LONGEST_NAME = 240
"""Bytes of the name of a channel, with room for what we put before it: an EXR has at most 255."""


def check_channels(channels: list[str]) -> None:
    """Raise OutputError if an EXR could not hold channels of these names. Call it before the work, not after."""
    long = next((name for name in channels if len(name.encode()) > LONGEST_NAME), None)
    if long is not None:
        raise OutputError(
            f"The AOV '{long[:40]}...' has a name of more than {LONGEST_NAME} bytes; give it a shorter one."
        )


def own_names(channels: list[str], taken: set[str]) -> list[str]:
    """Return names of channels under which they are in no layer that is ``taken``, and no two are the same.

    Those in such a layer, as an AOV "albedo" where features are written, come into "aov.albedo"; of names that are
    there twice the second has "2." before it.
    """
    renamed: list[str] = []
    for name in channels:
        own = f"aov.{name}" if name.partition(".")[0] in taken else name
        count = 2
        while own in renamed or (own in channels and own != name):
            own, count = f"{count}.{name}", count + 1
        renamed.append(own)
    return renamed


def write_exr(
    path: Path, names: list[str], values: NDArray[np.float32], metadata: dict[str, Any], window: Window | None = None
) -> None:
    """Write channels (H, W, N) as one float32 EXR; entries of ``metadata`` become attributes ``tracer:NAME``.

    ``window``: where the pixels lie in a larger picture, so that a part is shown in its place.
    """
    import OpenImageIO as oiio

    height, width, count = values.shape
    specification = oiio.ImageSpec(width, height, count, "float")
    specification.channelnames = tuple(names)
    if window is not None:
        specification.x, specification.y, specification.full_width, specification.full_height = window
    specification.attribute("compression", "zip")
    for name, value in metadata.items():
        fits = isinstance(value, str | float) or (isinstance(value, int) and abs(value) < 2**31)
        plain = value if fits else json.dumps(value)
        specification.attribute(f"tracer:{name}", plain)
    write_with_openimageio(path, specification, np.asarray(values, np.float32))


def write_png(path: Path, picture: NDArray) -> None:
    """Write a picture (H, W, 3) in [0, 1], already encoded for the screen, as 8-bit PNG."""
    import OpenImageIO as oiio

    height, width, count = picture.shape
    values = np.rint(np.clip(picture, 0, 1) * 255).astype(np.uint8)
    write_with_openimageio(path, oiio.ImageSpec(width, height, count, "uint8"), values)


def write_with_openimageio(path: Path, specification: Any, values: NDArray) -> None:
    """Write an array as the format that the suffix of ``path`` names."""
    import OpenImageIO as oiio

    with whole(path) as temporary:
        output = oiio.ImageOutput.create(str(temporary))
        if output is None:
            raise WriteError(f"Cannot write '{path}': {said(oiio)}.")
        done = output.open(str(temporary), specification) and output.write_image(np.ascontiguousarray(values))
        if not (output.close() and done):
            raise WriteError(f"Cannot write '{path}': {said(output).replace(str(temporary), path.name)}.")
        if not ends_with(temporary, list(specification.channelnames), values[-ROWS:]):
            raise WriteError(f"Cannot write '{path}': its end is missing, most likely as the disk is full.")


ROWS = 16
"""Of a picture, that are compressed together in an EXR."""
PNG_END = b"IEND\xaeB`\x82"


def ends_with(path: Path, names: list[str], rows: NDArray) -> bool:
    """Return whether the last rows (H, W, N) of an image file are these, of channels with these names.

    OpenImageIO does not notice when a disk is full while the last bytes are written, and of a PNG never.
    """
    import OpenImageIO as oiio

    if path.suffix.lower() == ".png" and not path.read_bytes().endswith(PNG_END):
        return False  # unread, as libpng would complain on standard error
    source = oiio.ImageInput.open(str(path))
    if source is None:
        oiio.geterror()  # or it is printed when the program ends
        return False
    try:
        specification, kind = source.spec(), "float" if rows.dtype == np.float32 else "uint8"
        if sorted(specification.channelnames) != sorted(names):
            return False
        end = specification.y + specification.height
        read = source.read_scanlines(end - len(rows), end, 0, 0, len(names), kind)
        expected = rows[..., [names.index(name) for name in specification.channelnames]]
        whole = read is not None and np.array_equal(np.reshape(read, rows.shape), expected, equal_nan=True)
        source.geterror()
        return whole
    finally:
        source.close()


def read_exr(path: Path) -> tuple[list[str], NDArray[np.float32], dict[str, Any]]:
    """Return channel names, values (H, W, N) and our metadata of an image file. Raises OutputError if unreadable."""
    with opened(path) as source:
        specification = source.spec()
        values = source.read_image("float")
        if values is None:
            raise OutputError(f"Cannot read '{path}': {said(source)}.")
        own = own_attributes(specification)
    values = np.asarray(values).reshape(specification.height, specification.width, -1)
    return list(specification.channelnames), values, own


def read_metadata(path: Path) -> dict[str, Any]:
    """Return our metadata of an image file, without reading its pixels. Raises OutputError if unreadable."""
    with opened(path) as source:
        return own_attributes(source.spec())


@contextmanager
def opened(path: Path) -> Iterator[Any]:
    """Yield an image file opened by OpenImageIO. Raises OutputError."""
    import OpenImageIO as oiio

    source = oiio.ImageInput.open(str(path))
    if source is None:
        raise OutputError(f"Cannot read '{path}': {said(oiio)}.")
    try:
        yield source
    finally:
        source.close()


def said(speaker: Any) -> str:
    """Return the last error of OpenImageIO, or of a file it has open, as one line without a full stop.

    It quotes what a damaged file holds, which may be no text.
    """
    try:
        text = speaker.geterror()
    except UnicodeDecodeError as error:
        text = error.object.decode(errors="replace")
    lines = "".join(each if each.isprintable() else "\n" for each in text).split("\n")
    return "; ".join(line.strip().rstrip(".:;") for line in lines if line.strip()) or "it is damaged"


def own_attributes(specification: Any) -> dict[str, Any]:
    """Return the attributes that we wrote, without their prefix."""
    attributes = {item.name: item.value for item in specification.extra_attribs}
    return {name.removeprefix("tracer:"): value for name, value in attributes.items() if name.startswith("tracer:")}

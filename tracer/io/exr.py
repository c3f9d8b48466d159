"""Write and read image files: EXR with named layers, and PNG to look at; written as a whole or not at all."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from tracer.errors import OutputError, WriteError
from tracer.io.atomic import whole

Window = tuple[int, int, int, int]
"""x and y of the pixels within a picture, and width and height of the picture."""
Chosen = Literal["all", "rgb"]
"""Which layers are written: all of them, or the picture's colours alone."""


def chosen_layers(name: str | None) -> Chosen:
    """Return the choice of a person, "all" where there is none. Raises OutputError."""
    if name is not None and name not in get_args(Chosen):
        raise OutputError(f"layers: write all or rgb (was {name!r}).")
    return "rgb" if name == "rgb" else "all"


def layers_of(channels: Iterable[str]) -> set[str]:
    """Return the names of the layers that channels belong to, which are before their first dots, and "stderr"."""
    return {"stderr", *(name.partition(".")[0] for name in channels)}


LONGEST_NAME = 240
"""Most bytes of the name of a channel. EXR allows 255; the rest is room for what we put before the name."""


def check_channels(channels: list[str]) -> None:
    """Raise OutputError if an EXR could not hold channels of these names. Call this before the work, not after."""
    long = next((name for name in channels if len(name.encode()) > LONGEST_NAME), None)
    if long is not None:
        raise OutputError(
            f"The AOV '{long[:40]}...' has a name of more than {LONGEST_NAME} bytes; give it a shorter one."
        )


def own_names(channels: list[str], taken: set[str]) -> list[str]:
    """Return new names for channels, all different, of which none is in a layer that is ``taken``.

    A channel in such a layer, such as an AOV "albedo" where features are written, moves to "aov.albedo". Where a name
    occurs twice, the second channel has "2." before it.
    """
    renamed: list[str] = []
    for name in channels:
        new_name = f"aov.{name}" if name.partition(".")[0] in taken else name
        count = 2
        while new_name in renamed or (new_name in channels and new_name != name):
            new_name, count = f"{count}.{name}", count + 1
        renamed.append(new_name)
    return renamed


def write_exr(
    path: Path, names: list[str], values: NDArray[np.float32], metadata: dict[str, Any], window: Window | None = None
) -> None:
    """Write channels (H, W, N) as one float32 EXR; entries of ``metadata`` become attributes ``tracer:NAME``.

    ``window``: where the pixels lie in a larger picture, so that viewers show a part in its place. Raises WriteError.
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
    """Write a picture (H, W, 3) in [0, 1], already encoded for the screen, as 8-bit PNG. Raises WriteError."""
    import OpenImageIO as oiio

    height, width, count = picture.shape
    values = np.rint(np.clip(picture, 0, 1) * 255).astype(np.uint8)
    write_with_openimageio(path, oiio.ImageSpec(width, height, count, "uint8"), values)


def write_with_openimageio(path: Path, specification: Any, values: NDArray) -> None:
    """Write an array (H, W, N) in the format that the suffix of ``path`` names. Raises WriteError."""
    import OpenImageIO as oiio

    with whole(path) as temporary:
        output = oiio.ImageOutput.create(str(temporary))
        if output is None:
            raise WriteError(f"Cannot write '{path}': {said(oiio)}.")
        is_written = output.open(str(temporary), specification) and output.write_image(np.ascontiguousarray(values))
        if not (output.close() and is_written):
            raise WriteError(f"Cannot write '{path}': {said(output).replace(str(temporary), path.name)}.")
        if not ends_with(temporary, list(specification.channelnames), values[-ROWS:]):
            raise WriteError(f"Cannot write '{path}': its end is missing, most likely as the disk is full.")


ROWS = 16
"""Number of rows of a picture that an EXR compresses together: damage at the end of the file is in the last of them."""
PNG_END = b"IEND\xaeB`\x82"
"""The last bytes of every whole PNG file."""


def ends_with(path: Path, names: list[str], rows: NDArray) -> bool:
    """Return whether an image file ends with ``rows`` (H, W, N), in channels with these ``names``.

    OpenImageIO does not notice that a disk is full while it writes the last bytes of a file, nor, for a PNG, any bytes.
    """
    import OpenImageIO as oiio

    if path.suffix.lower() == ".png" and not path.read_bytes().endswith(PNG_END):
        return False  # not read, as libpng would complain on standard error
    source = oiio.ImageInput.open(str(path))
    if source is None:
        oiio.geterror()  # an error that is not fetched is printed when the program ends
        return False
    try:
        specification, kind = source.spec(), "float" if rows.dtype == np.float32 else "uint8"
        if sorted(specification.channelnames) != sorted(names):
            return False
        end = specification.y + specification.height
        last_rows = source.read_scanlines(end - len(rows), end, 0, 0, len(names), kind)
        expected = rows[..., [names.index(name) for name in specification.channelnames]]
        is_same = last_rows is not None and np.array_equal(np.reshape(last_rows, rows.shape), expected, equal_nan=True)
        source.geterror()
        return is_same
    finally:
        source.close()


def read_exr(path: Path) -> tuple[list[str], NDArray[np.float32], dict[str, Any]]:
    """Return channel names, values (H, W, N) and our metadata of an image file. Raises OutputError if unreadable."""
    with opened(path) as source:
        specification = source.spec()
        values = source.read_image("float")
        if values is None:
            raise OutputError(f"Cannot read '{path}': {said(source)}.")
        metadata = own_attributes(specification)
    values = np.asarray(values).reshape(specification.height, specification.width, -1)
    return list(specification.channelnames), values, metadata


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
    """Return the last error of OpenImageIO, or of a file that it has open, as one line without a full stop.

    The error may quote the content of a damaged file, which need not be text.
    """
    try:
        text = speaker.geterror()
    except UnicodeDecodeError as error:
        text = error.object.decode(errors="replace")
    lines = "".join(character if character.isprintable() else "\n" for character in text).split("\n")
    return "; ".join(line.strip().rstrip(".:;") for line in lines if line.strip()) or "it is damaged"


def own_attributes(specification: Any) -> dict[str, Any]:
    """Return the attributes of an image file that we wrote, without their prefix."""
    attributes = {attribute.name: attribute.value for attribute in specification.extra_attribs}
    return {name.removeprefix("tracer:"): value for name, value in attributes.items() if name.startswith("tracer:")}

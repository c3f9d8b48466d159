"""Files: always whole or not at all. One EXR with named layers, PNG for looking at."""

from __future__ import annotations

import glob
import json
import os
import tempfile
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from tracer.core.wording import option
from tracer.errors import OutputError, WriteError
from tracer.io.rescue import write_or_rescue
from tracer.result import Result, display

Window = tuple[int, int, int, int]
"""x and y of the pixels within a picture, and width and height of the picture."""
Chosen = Literal["all", "rgb"]
"""Layers that are written."""
IMAGE_SUFFIXES = (".exr", ".png")


def check_output(path: Path, overwrite: bool = False, suffixes: tuple[str, ...] = IMAGE_SUFFIXES) -> Path:
    """Return ``path`` if a file can be written there, else raise OutputError. Call it before the work, not after."""
    if suffixes and path.suffix.lower() not in suffixes:
        raise OutputError(f"'{path}' must end in {' or '.join(suffixes)}.")
    check_folder(path.parent)
    if path.is_dir():
        raise OutputError(f"'{path}' is a folder; name a file in it.")
    if path.exists() and not overwrite:
        raise OutputError(f"'{path}' exists; choose another name, or {option('overwrite')} to replace it.")
    return path


def check_folder(folder: Path) -> Path:
    """Return ``folder`` if files can be written in it, else raise OutputError."""
    if not folder.is_dir():
        raise OutputError(f"There is no folder '{folder}'; create it first.")
    try:
        with tempfile.TemporaryFile(dir=folder):
            return folder
    except OSError as error:
        raise OutputError(f"Cannot write in folder '{folder}': {error.strerror}.") from None


def prepare_folder(folder: Path, overwrite: bool, results: tuple[str, ...]) -> None:
    """Make ``folder`` ready for results, creating it in a folder that exists. Raises OutputError.

    It is refused if any of the files ``results`` is there already, unless they may be overwritten.
    """
    if not folder.exists():
        check_folder(folder.parent)
        folder.mkdir()
    check_folder(folder)
    existing = next((name for name in results if (folder / name).exists()), None)
    if existing is not None and not overwrite:
        raise OutputError(
            f"'{folder / existing}' exists; choose another folder, or {option('overwrite')} to replace it."
        )


@contextmanager
def whole(path: Path, durable: bool = False) -> Iterator[Path]:
    """Yield a temporary name beside ``path``, which replaces it when the block ends well and vanishes when not.

    ``durable``: wait until it is on the disk before what was there is given up. Temporary files that a process has left
    which was killed are removed. Raises WriteError.
    """
    remove_abandoned(path)
    temporary = path.with_name(f".{path.stem}.{os.getpid()}{path.suffix}")
    try:
        yield temporary
        if durable:
            with open(temporary, "rb") as file:
                os.fsync(file.fileno())
        os.replace(temporary, path)
    except OSError as error:
        raise WriteError(f"Cannot write '{path}': {error.strerror or error}.") from None
    finally:
        temporary.unlink(missing_ok=True)


def remove_abandoned(path: Path) -> None:
    """Remove temporary files of ``path`` whose process is gone."""
    for left in path.parent.glob(f".{glob.escape(path.stem)}.*{glob.escape(path.suffix)}"):
        process = left.name.removeprefix(f".{path.stem}.").removesuffix(path.suffix)
        if process.isdecimal() and not is_running(int(process)):
            left.unlink(missing_ok=True)


def is_running(process: int) -> bool:
    """Return whether there is a process of that number on this machine; one that only waits to be buried is not."""
    try:
        os.kill(process, 0)
        status = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2]
    except ProcessLookupError:
        return False
    except (OSError, OverflowError):  # another person's, a system without /proc, or no number of a process
        return True
    return not status.startswith(" Z")


def write_text(path: Path, text: str) -> None:
    """Write a text file."""
    with whole(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


def write_arrays(path: Path, arrays: dict[str, Any], durable: bool = False) -> None:
    """Write arrays by name, for ``np.load``."""
    with whole(path, durable) as temporary, open(temporary, "wb") as file:
        np.savez(file, **arrays)


def write_result(path: Path, result: Result, metadata: dict[str, Any], chosen: Chosen = "all") -> None:
    """Write a result as EXR with ``metadata``, or the picture alone, as a screen shows it, as PNG.

    ``chosen``: "all" layers, or "rgb", which is the picture in linear sRGB and nothing else, for programs that read no
    layers. Raises WriteError, which says where the picture is if it could be written in another place.
    """

    def write(place: Path) -> None:
        if path.suffix.lower() == ".png":
            write_png(place, display(result.rgb))
        elif chosen == "rgb":
            write_exr(place, ["R", "G", "B"], result.rgb, metadata, result.window)
        else:
            write_exr(place, *layers(result), metadata, result.window)

    write_or_rescue(path, write)


def chosen_layers(name: str | None) -> Chosen:
    """Return the choice of a person, "all" where there is none. Raises OutputError."""
    if name is not None and name not in get_args(Chosen):
        raise OutputError(f"layers: write all or rgb (was {name!r}).")
    return "rgb" if name == "rgb" else "all"


def layers(result: Result) -> tuple[list[str], NDArray[np.float32]]:
    """Return channel names and values (H, W, N) of the EXR of a result; every name is there once.

    The image under its own names, then ``stderr.`` with the names of the image, ``samples.Y``, ``complexity.Y``,
    ``importance.Y``, ``cost.Y``. Counts are exact up to 2^24, as float32 holds them. If it was denoised, ``noisy.``
    with the names of its colours; if features were asked for, ``albedo.R/G/B``, ``normal.X/Y/Z``, ``depth.Z`` and
    ``shape.Y``. AOVs that would come into these layers are named by ``own_names``.
    """
    after = single_channels(result)
    channels = own_names(result.channels, layers_of(after))
    names = [*channels, *(f"stderr.{name}" for name in channels), *after]
    values = [result.image, result.stderr, *(array[..., None] for array in after.values())]
    return names, np.concatenate([array.astype(np.float32) for array in values], axis=-1)


def single_channels(result: Result) -> dict[str, NDArray]:
    """Return the channels (H, W) of a result beside image and standard error, by name."""
    found = {f"{name}.Y": getattr(result, name) for name in ("samples", "complexity", "importance", "cost")}
    if result.noisy is not None:
        colours = result.channels[: result.noisy.shape[-1]]
        found |= {f"noisy.{name}": result.noisy[..., k] for k, name in enumerate(colours)}
    if result.seen is not None:
        features = result.seen.features
        found |= {f"albedo.{name}": features.albedo[..., k] for k, name in enumerate("RGB")}
        found |= {f"normal.{name}": features.normal[..., k] for k, name in enumerate("XYZ")}
        found |= {"depth.Z": features.depth, "shape.Y": result.seen.shapes}
    return found


def layers_of(channels: Iterable[str]) -> set[str]:
    """Return the layers that we write with these channels: what is before the first dot, and "stderr"."""
    return {"stderr", *(name.partition(".")[0] for name in channels)}


def renamed_layers(result: Result) -> list[str]:
    """Return the layers of AOVs that have another name in the EXR of a result than in the scene."""
    own = own_names(result.channels, layers_of(single_channels(result)))
    changed = (new for new, old in zip(own, result.channels, strict=True) if new != old)
    return list(dict.fromkeys(name.rpartition(".")[0] or name for name in changed))


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

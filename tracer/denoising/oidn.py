"""Take the noise out of a picture with Open Image Denoise, on the CPU, with the threads of Dr.Jit."""

from __future__ import annotations

import threading
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tracer.core.arrays import Singles
from tracer.core.version import install_command
from tracer.errors import DenoiseError

MARGIN = 8
"""Pixels by which the picture is continued on each side, as its reflection; twice as many for a SMALL picture. Open
Image Denoise takes what lies outside for black: without the margin a constant picture comes back up to 37 % too bright
or dark at its edge, and a single pixel ten times too dark; with it, by 1 % at most."""
SMALL = 32
"""Pixels along a side that a picture has at least if it is not small."""
LEAST_MEMORY, MOST_MEMORY, PIXEL_MEMORY = 256, 1024, 0.0006
"""Megabytes that Open Image Denoise may take, about: PIXEL_MEMORY per pixel, from LEAST_MEMORY to MOST_MEMORY in all.
For larger pictures it works in tiles, which leave the result the same to the bit and take hardly more time."""
MOST_KEPT = 3 << 17
"""Most pixels for which a filter is kept for the next picture. To make one takes a tenth of the time of denoising
512 x 512 pixels, and it holds 600 bytes for each."""

Shape = tuple[tuple[int, ...], tuple[str, ...]]
"""Shape and names of the images of a filter."""
lock = threading.Lock()
"""Held while a filter runs: it takes all threads, and memory."""
last_filter: dict[Shape, Any] = {}
"""The filter that ran last, by the shape of its images."""


def denoise(image: NDArray, albedo: NDArray | None = None, normal: NDArray | None = None) -> Singles:
    """Return ``image`` without its noise, (H, W, 3) float32.

    ``image`` (H, W, 3): linear sRGB, without an upper bound; each pixel is the mean of its own samples, as in
    ``Statistics.mean``. Under a filter that shares samples between pixels, noise looks like detail, and much of it
    would stay (``tracer.denoising.refilter`` gives the returned picture the look of the filter). ``albedo`` (H, W, 3),
    0 to 1, and ``normal`` (H, W, 3), -1 to 1: as ``draw_features`` returns them with ``filtered=False``, noise and all;
    a normal is of use only together with an albedo.

    Values that are not finite are taken as 0, and so are negative values of image and albedo. The same arrays give the
    same picture, up to rounding where the number of threads differs. Raises DenoiseError.
    """
    oidn = load()
    inputs = {"color": image, "albedo": albedo, "normal": normal}
    images = {name: check(name, values, np.shape(image)) for name, values in inputs.items() if values is not None}
    if "normal" in images and "albedo" not in images:
        raise DenoiseError("A normal image is of no use without an albedo image; give both or neither.")
    try:
        with lock:
            denoised = run(oidn, {name: continued(values) for name, values in images.items()})
    except oidn.Error as error:
        last_filter.clear()
        raise DenoiseError(f"Open Image Denoise failed: {error}.") from None
    margin = margin_of(np.shape(image))
    return np.ascontiguousarray(denoised[margin:-margin, margin:-margin])


def load() -> Any:
    """Return the module ``mitsuba_oidn``. Raises DenoiseError where it is not installed or does not load."""
    try:
        import mitsuba_oidn
    except ImportError as error:
        raise DenoiseError(
            "Denoising needs the package mitsuba-oidn, which is not installed or does not load "
            f"({error}); install it, {install_command('denoise')}."
        ) from None
    return mitsuba_oidn


def check(name: str, values: NDArray, shape: tuple[int, ...]) -> Singles:
    """Return an image as Open Image Denoise takes it.

    ``name``: "color", "albedo" or "normal". Raises DenoiseError if it is not of ``shape`` or holds no real numbers.
    """
    name = {"color": "picture"}.get(name, name)
    array = np.asarray(values)
    if array.ndim != 3 or array.shape[-1] != 3 or array.size == 0:
        raise DenoiseError(f"The {name} to denoise must be of shape (height, width, 3), not {array.shape}.")
    if array.shape != shape:
        raise DenoiseError(f"The {name} is of shape {array.shape}, but the picture to denoise of {shape}.")
    if array.dtype.kind not in "fiu":
        raise DenoiseError(f"The {name} to denoise must hold real numbers, not {array.dtype}.")
    array = array.astype(np.float32, order="C")
    array[~np.isfinite(array)] = 0.0
    return array


def margin_of(shape: tuple[int, ...]) -> int:
    """Return the pixels by which a picture of this shape (H, W, ...) is continued on each side."""
    return MARGIN if min(shape[:2]) >= SMALL else 2 * MARGIN


def continued(image: Singles) -> Singles:
    """Return an image (H, W, 3) with its margin. It is reflected as often as needed: it may be smaller than that."""
    margin = margin_of(image.shape)
    return np.pad(image, ((margin, margin), (margin, margin), (0, 0)), mode="symmetric")


def run(oidn: Any, images: dict[str, Singles]) -> Singles:
    """Return the output of the filter for ray-traced pictures for ``images``, by their names in Open Image Denoise."""
    output = np.empty_like(images["color"])
    shape = output.shape, tuple(images)
    ray_traced = last_filter.pop(shape, None)
    last_filter.clear()
    if ray_traced is None:
        ray_traced = oidn.Device(oidn.DeviceType.CPU).new_filter("RT")
        ray_traced.hdr = True
        megabytes = round(PIXEL_MEMORY * output.shape[0] * output.shape[1])
        ray_traced.max_memory_mb = min(max(megabytes, LEAST_MEMORY), MOST_MEMORY)
    for name, values in {**images, "output": output}.items():
        ray_traced.set_image(name, values)
    ray_traced.execute()
    if output.shape[0] * output.shape[1] <= MOST_KEPT:
        last_filter[shape] = ray_traced
    return output

"""Films: an animation that loops by itself (WebP), or a video that every browser and phone plays (MP4 with H.264)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tracer.core.extras import require_package
from tracer.errors import SettingsError
from tracer.io import atomic

FRAMES_PER_SECOND = 25
"""The film shows this many frames per second."""
Picture = NDArray[np.uint8]
"""(H, W, 3), encoded as sRGB."""
BT709 = 1
"""Number of the colours of high-definition television in FFmpeg, for matrix and primaries."""
SRGB = 13
"""Number of the transfer curve of sRGB in FFmpeg."""


def require_film_maker(name: str) -> None:
    """Raise SettingsError unless a film can have this name, and MissingPackageError without what writes it."""
    suffix = Path(name).suffix.lower()
    if suffix not in WRITERS or Path(name).name != name:
        raise SettingsError(
            f"A film is named without a folder, and ends with {' or '.join(WRITERS)}; '{name}' does not."
        )
    if suffix == ".mp4":
        require_package("av", "av", f"The film '{name}'", "view")
    else:
        require_package("PIL.Image", "Pillow", f"The film '{name}'", "view")


def write_film(path: Path, pictures: Sequence[Picture]) -> None:
    """Write pictures, all of the same size, as a film; see ``require_film_maker`` for the names that it can have."""
    with atomic.whole(path) as temporary:
        WRITERS[path.suffix.lower()](temporary, pictures)


def there_and_back(pictures: Sequence[Picture]) -> list[Picture]:
    """Return pictures and then those between them backwards, so that a film that plays again has no jump."""
    return [*pictures, *pictures[-2:0:-1]]


def write_webp(path: Path, pictures: Sequence[Picture]) -> None:
    """Write pictures as an animation that plays without end."""
    from PIL import Image

    first, *others = [Image.fromarray(picture) for picture in pictures]
    first.save(
        path,
        format="WEBP",
        save_all=True,
        append_images=others,
        duration=1000 // FRAMES_PER_SECOND,
        loop=0,
        quality=80,
    )


def write_mp4(path: Path, pictures: Sequence[Picture]) -> None:
    """Write pictures as H.264 in 4:2:0, the only form that all browsers play.

    It has half as many places for colour along each side, so an odd last row or column is written twice.
    """
    import av

    height, width = pictures[0].shape[:2]
    with av.open(str(path), "w", format="mp4", options={"movflags": "+faststart"}) as film:
        stream = film.add_stream("libx264", rate=FRAMES_PER_SECOND, options={"crf": "18"})
        stream.width, stream.height, stream.pix_fmt = width + width % 2, height + height % 2, "yuv420p"
        context = stream.codec_context
        context.colorspace = context.color_primaries = BT709
        context.color_trc = SRGB
        for picture in pictures:
            even = np.pad(picture, ((0, height % 2), (0, width % 2), (0, 0)), mode="edge")
            frame = av.VideoFrame.from_ndarray(np.ascontiguousarray(even), format="rgb24")
            film.mux(stream.encode(frame.reformat(format="yuv420p", dst_colorspace="ITU709")))
        film.mux(stream.encode(None))


WRITERS: dict[str, Callable[[Path, Sequence[Picture]], None]] = {".webp": write_webp, ".mp4": write_mp4}
"""Films are written by these functions, by the end of their names."""

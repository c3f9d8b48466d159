"""Films, read again by FFmpeg and Pillow."""

import av
import numpy as np
import pytest
from PIL import Image

from tracer.errors import SettingsError
from tracer.viewpoint.films import require_film_maker, there_and_back, write_film


def pictures(count, height, width):
    """Return pictures of which the left half is of one colour, and the right half grows lighter."""
    found = np.zeros((count, height, width, 3), np.uint8)
    found[..., : width // 2, :] = (200, 90, 40)
    found[..., width // 2 :, :] = np.linspace(20, 220, count).astype(np.uint8)[:, None, None, None]
    return list(found)


@pytest.mark.parametrize(("height", "width"), [(48, 64), (33, 47)])
def test_a_video_is_what_browsers_play(height, width, tmp_path):
    write_film(tmp_path / "film.mp4", there_and_back(pictures(5, height, width)))
    content = (tmp_path / "film.mp4").read_bytes()
    assert content.index(b"moov") < content.index(b"mdat")  # it plays before all of it is there
    with av.open(tmp_path / "film.mp4") as film:
        stream = film.streams.video[0]
        assert (stream.codec_context.name, stream.codec_context.pix_fmt) == ("h264", "yuv420p")
        assert (stream.width, stream.height) == (width + width % 2, height + height % 2)
        assert stream.average_rate == 25
        decoded = list(film.decode(stream))
        assert {frame.colorspace for frame in decoded} == {1}  # BT.709, which players then decode with
        as_rgb = [frame.reformat(format="rgb24", src_colorspace="ITU709") for frame in decoded]
        frames = [frame.to_ndarray().astype(int) for frame in as_rgb]
    assert len(frames) == 8  # there and back
    for frame, lightness in zip(frames, [20, 70, 120, 170, 220, 170, 120, 70], strict=True):
        assert frame[10, 5] == pytest.approx([200, 90, 40], abs=4)
        assert frame[10, -3] == pytest.approx([lightness] * 3, abs=4)


def test_a_single_picture_is_a_film(tmp_path):
    for name in ("one.webp", "one.mp4"):
        write_film(tmp_path / name, there_and_back(pictures(1, 16, 16)))
        assert (tmp_path / name).stat().st_size > 0


def test_an_animation_plays_without_end(tmp_path):
    write_film(tmp_path / "film.webp", there_and_back(pictures(3, 16, 17)))
    with Image.open(tmp_path / "film.webp") as film:
        assert (film.n_frames, film.size, film.info["loop"]) == (4, (17, 16), 0)


@pytest.mark.parametrize("name", ["film.gif", "film", "folder/film.mp4", ".mp4", ""])
def test_a_name_that_is_none_of_a_film(name):
    with pytest.raises(SettingsError, match=r"ends with \.webp or \.mp4"):
        require_film_maker(name)

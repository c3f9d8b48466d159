"""The width that a file names is that of the film that Mitsuba makes of it."""

import mitsuba as mi
import pytest

from tracer.errors import SceneError
from tracer.scene.film_width import film_width

FILM = '<film type="hdrfilm"><integer name="width" value="{}"/><integer name="height" value="8"/>{}</film>'
CROP = '<integer name="crop_width" value="5"/><integer name="crop_offset_x" value="2"/>'
CROP += '<integer name="crop_height" value="8"/><integer name="crop_offset_y" value="0"/>'
SENSORS = [
    f'<sensor type="perspective">{FILM.format("$w", "")}<sampler type="independent"/></sensor>',
    '<sensor type="perspective"/>',
    f'<sensor type="thinlens"><float name="aperture_radius" value="1"/>{FILM.format(40, CROP)}</sensor>',
]


def test_the_width_is_that_of_the_film(tmp_path):
    path = tmp_path / "scene.xml"
    path.write_text(f'<scene version="3.0.0"><default name="w" value="31"/>{"".join(SENSORS)}</scene>')
    sensors = mi.load_file(str(path)).sensors()
    widths = [film_width(path, number) for number in range(len(sensors))]
    assert widths == [sensor.film().crop_size()[0] for sensor in sensors] == [31, 768, 5]
    assert film_width(path, 3) is None


def test_a_file_that_cannot_be_read(tmp_path):
    path = tmp_path / "scene.xml"
    path.write_text("<scene")
    with pytest.raises(SceneError):
        film_width(path)

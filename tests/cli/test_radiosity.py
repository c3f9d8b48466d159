"""Command ``radiosity``: what it writes, and one sentence for a mistake."""

import numpy as np
import pytest
from typer.testing import CliRunner

from tracer.cli.app import app
from tracer.errors import TracerError
from tracer.io import exr

SCENE = """<scene version="3.0.0">
    <sensor type="perspective">
        <transform name="to_world"><lookat origin="0,0,5" target="0,0,0" up="0,1,0"/></transform>
        <film type="hdrfilm"><integer name="width" value="24"/><integer name="height" value="16"/></film>
    </sensor>
    <shape type="rectangle" id="floor">MATERIAL</shape>
    <shape type="rectangle" id="lamp">
        <transform name="to_world"><rotate y="1" angle="180"/><translate z="6"/></transform>
        <emitter type="area"><rgb name="radiance" value="9"/></emitter>
    </shape>
    EXTRA
</scene>"""


def scene(folder, material='<bsdf type="diffuse"/>', extra=""):
    path = folder / "scene.xml"
    path.write_text(SCENE.replace("MATERIAL", material).replace("EXTRA", extra))
    return path


def call(*arguments):
    result = CliRunner().invoke(app, ["radiosity", *map(str, arguments)])
    if result.exception is not None and not isinstance(result.exception, SystemExit):
        raise result.exception
    assert result.exit_code == 0, result.output
    return result.output


@pytest.mark.parametrize(
    "shown", [[], ["--show", "patches"], ["--show", "smooth"], ["--method", "shooting"], ["--spread", "paper_right"]]
)
def test_a_picture_and_what_it_took(tmp_path, shown):
    said = call(scene(tmp_path), "-o", tmp_path / "out.exr", "--spp", 16, "--rays", 64, "--patch", 0.5, *shown)
    assert "patches" in said
    assert "residual" in said
    names, values, _ = exr.read_exr(tmp_path / "out.exr")
    middle = values[8, 12, [names.index(name) for name in "RGB"]]
    # A square of side 2 at distance 6 above its like: its form factor from the middle (Howell B-4) times 9 times 0.5.
    a = 1 / 6
    factor = 4 * a / np.sqrt(1 + a * a) * np.arctan(a / np.sqrt(1 + a * a)) / np.pi
    assert middle == pytest.approx(np.full(3, 9 * 0.5 * factor), rel=0.03)


def test_what_is_not_diffuse_is_named_or_refused(tmp_path):
    rough = scene(tmp_path, '<bsdf type="roughplastic"/>')
    few = ["--spp", 1, "--rays", 4, "--patch", 1]
    assert "floor" in call(rough, "-o", tmp_path / "out.png", *few)
    with pytest.raises(TracerError, match="not diffuse: 'floor'; leave out --strict"):
        call(rough, "-o", tmp_path / "strict.png", "--strict", *few)
    assert not (tmp_path / "strict.png").exists()


def test_media_are_named_or_refused(tmp_path):
    medium = '<medium type="homogeneous" name="interior"/>'
    cloudy = scene(tmp_path, extra=f'<shape type="cube" id="cloud">{medium}<bsdf type="diffuse"/></shape>')
    few = ["--spp", 1, "--rays", 4, "--patch", 1]
    assert "Media are left out, as radiosity knows only surfaces: 'cloud'.\n" in call(
        cloudy, "-o", tmp_path / "out.png", *few
    )
    with pytest.raises(TracerError, match=r"leaves out the media of '.*scene.xml': 'cloud'; leave out --strict"):
        call(cloudy, "-o", tmp_path / "strict.png", "--strict", *few)
    assert not (tmp_path / "strict.png").exists()


@pytest.mark.parametrize(
    ("arguments", "extra", "sentence"),
    [
        (["--patch", "0"], "", "is a length above 0"),
        (["--residual", "2"], "", "share between 0 and 1"),
        (["--sensor", "3"], "", "sensor"),
        (["--patch", "0.01", "--rays", "1048576"], "", "allow longer edges of patches, or fewer rays"),
        ([], '<shape type="linearcurve" id="hair"><string name="filename" value="hair.txt"/></shape>', "none: 'hair'"),
        ([], '<emitter type="point" id="spark"/>', "and the light 'spark' does not"),
    ],
)
def test_a_mistake_is_one_sentence_and_writes_nothing(arguments, extra, sentence, tmp_path):
    (tmp_path / "hair.txt").write_text("0 0 0 0.1\n0 0 1 0.1\n0 1 1 0.1\n")
    with pytest.raises(TracerError, match=sentence) as caught:
        call(scene(tmp_path, extra=extra), "-o", tmp_path / "out.png", *arguments)
    assert "\n" not in str(caught.value)
    assert not (tmp_path / "out.png").exists()

"""A scene that the exporter of Blender wrote: mitsuba-blender at 862d44f, in Blender 4.5 with Mitsuba 3.5.

It has a cube, a floor with a texture, sun, world and camera, and was exported by the lines in docs/how_to/blender.md.
"""

import runpy
import shutil
import sys
from pathlib import Path
from types import SimpleNamespace

import mitsuba as mi
import numpy as np
import pytest

import tracer
from tracer.io.images import read_picture
from tracer.scene.view import open_scene

ROOT = Path(__file__).parents[2]
SCRIPTS = ROOT / "examples" / "blender"
SCENE = Path(__file__).parent / "blender" / "scene.xml"
SMALL = {"resx": "48", "resy": "36"}
"""The exporter writes the size of the picture as parameters."""


def test_what_the_exporter_writes_is_rendered_as_mitsuba_renders_it():
    result = tracer.render(SCENE, spp=64, define=SMALL)
    scene = mi.load_file(str(SCENE), **SMALL)
    reference = np.array(mi.render(scene, spp=1024))
    assert result.image.shape == reference.shape == (36, 48, 3)
    errors = (result.image - reference) / np.maximum(result.stderr, 0.02 * reference + 1e-3)
    assert np.abs(errors.mean()) < 0.2
    assert np.percentile(np.abs(errors), 95) < 4
    tile = result.image[30, 24]  # the texture was found: its tiles are not grey
    assert tile.max() > 1.2 * tile.min()


def test_samples_and_names_are_those_of_blender():
    with open_scene(SCENE, define=SMALL | {"spp": "32"}) as view:
        assert view.asked_spp == 32
    weighted = tracer.render(SCENE, spp=8, define=SMALL, shape_weights={"mesh-Cube": 4})
    assert weighted.samples.max() > 8
    with pytest.raises(tracer.errors.SettingsError, match="mesh-Cube"):
        tracer.render(SCENE, spp=8, define=SMALL, shape_weights={"Cube": 4})


@pytest.fixture
def render_frames(monkeypatch):
    """Run the script of the examples with these arguments."""

    def run(*arguments):
        monkeypatch.setattr(sys, "argv", ["render_frames.py", *map(str, arguments)])
        runpy.run_path(str(SCRIPTS / "render_frames.py"), run_name="__main__")

    return run


def test_the_script_renders_every_frame_and_goes_on(render_frames, tmp_path, capsys):
    exported, frames = tmp_path / "exported", tmp_path / "frames"
    for name in ("0001", "0002"):
        shutil.copytree(SCENE.parent, exported / name)
    render_frames(exported, frames, "--size", 48, "--spp", 4)
    assert sorted(path.name for path in frames.iterdir()) == ["0001.exr", "0001.png", "0002.exr", "0002.png"]
    assert read_picture(frames / "0001.exr").shape[:2] == (36, 48)
    assert capsys.readouterr().out.count("4 samples per pixel in 1 round") == 2
    (frames / "0002.exr").unlink()
    render_frames(exported, frames, "--size", 48, "--spp", 4)
    assert capsys.readouterr().out.startswith(str(frames / "0002.exr"))


def test_a_mistake_with_the_script_is_one_sentence(render_frames, tmp_path):
    with pytest.raises(SystemExit, match=r"There is no scene\.xml in"):
        render_frames(tmp_path, tmp_path / "frames")
    with pytest.raises(SystemExit, match="spp"):
        render_frames(SCENE.parent, tmp_path / "frames", "--spp", -1)


def test_frames_are_exported_into_folders_of_their_own(monkeypatch):
    """Blender is not there: this checks what it would be asked to do."""
    shown, written = [], []
    scene = SimpleNamespace(frame_start=3, frame_end=5, frame_set=shown.append)
    blender = SimpleNamespace(
        context=SimpleNamespace(scene=scene),
        path=SimpleNamespace(abspath=lambda path: path.replace("//", "/shot/")),
        ops=SimpleNamespace(export_scene=SimpleNamespace(mitsuba=lambda **given: written.append((shown[-1], given)))),
    )
    monkeypatch.setitem(sys.modules, "bpy", blender)
    runpy.run_path(str(SCRIPTS / "export_frames.py"))
    assert written == [
        (frame, {"filepath": f"/shot/exported/000{frame}/scene.xml", "export_ids": True}) for frame in (3, 4, 5)
    ]
    code = (SCRIPTS / "export_frames.py").read_text().partition("import bpy")[2]
    assert f"```python\nimport bpy{code}```" in (ROOT / "docs/how_to/blender.md").read_text()

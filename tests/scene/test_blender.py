"""A scene that the exporter of Blender wrote: mitsuba-blender at 862d44f, in Blender 4.5 with Mitsuba 3.5.

It has a cube, a floor with a texture, sun, world and camera, and was exported by the lines in docs/how_to/blender.md.
"""

from pathlib import Path

import mitsuba as mi
import numpy as np
import pytest

import tracer
from tracer.scene.view import open_scene

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

"""A mesh file alone is a picture: the mesh fills it, it is lit, and colours are those of the file."""

import numpy as np
import pytest
import trimesh
from trimesh.visual.material import PBRMaterial

import tracer
from tracer.errors import SettingsError
from tracer.viewpoint.showcase import SKY


@pytest.fixture
def red_box(tmp_path):
    box = trimesh.creation.box([1, 2, 3])
    material = PBRMaterial(baseColorFactor=[204, 10, 10, 255], metallicFactor=0.0, roughnessFactor=1.0)
    box.visual = trimesh.visual.TextureVisuals(material=material)
    box.export(tmp_path / "box.glb")
    return tmp_path / "box.glb"


def test_it_is_seen_whole_and_lit(red_box):
    image = tracer.render(red_box, size=64, spp=32).rgb
    is_box = image[..., 0] > 3 * image[..., 1]
    assert 0.1 < is_box.mean() < 0.7
    assert not is_box[[0, -1]].any()
    assert not is_box[:, [0, -1]].any()
    assert image[0, 0] == pytest.approx([SKY] * 3, rel=0.01)
    assert 0.1 < image[is_box][:, 0].mean() < 1.0


def test_it_is_the_same_every_time(red_box):
    first, second = (tracer.render(red_box, size=32, spp=16, features=True) for _ in range(2))
    assert np.array_equal(first.image, second.image)


def test_a_checkpoint_knows_the_file(red_box, tmp_path):
    state = tmp_path / "state.ckpt"
    tracer.render(red_box, size=32, spp=16, checkpoint=state)
    trimesh.creation.box([1, 1, 3]).export(red_box)
    with pytest.raises(tracer.errors.CheckpointError):
        tracer.render(red_box, size=32, spp=16, checkpoint=state, resume=True)


def test_workers_refuse_it(red_box):
    with pytest.raises(SettingsError, match=r"Workers open scene files, and '.*box.glb' is a mesh"):
        tracer.render(red_box, cluster=1)

"""Masks, weight images and weights of shapes: they steer every criterion, and wrong ones say so."""

from types import SimpleNamespace

import mitsuba as mi
import numpy as np
import OpenImageIO as oiio
import pytest

import tracer
from conftest import LIT
from tracer import criteria
from tracer.adaptive import importance_map
from tracer.errors import SettingsError
from tracer.settings import make_settings

T = mi.ScalarTransform4f


def mask(height=16, width=24):
    image = np.zeros((height, width))
    image[:, width // 2 :] = 1
    return image


def write(path, values):
    values = values if values.ndim == 3 else values[..., None]
    output = oiio.ImageOutput.create(str(path))
    kind = "uint8" if path.suffix == ".png" else "float"
    output.open(str(path), oiio.ImageSpec(values.shape[1], values.shape[0], values.shape[2], kind))
    output.write_image(values.astype(np.float32))
    output.close()
    return path


@pytest.mark.parametrize("criterion", ["uniform", "fused", "variance", "shape_entropy"])
def test_a_mask_steers_every_criterion(cornell, criterion):
    result = tracer.render(cornell(), spp=32, pilot_spp=4, criterion=criterion, importance=mask())
    assert result.samples.sum() == 32 * result.samples.size
    assert result.samples[:, :11].max() <= 8
    assert result.samples[:, 13:].min() >= 4
    assert result.samples[:, 13:].mean() > 50


def test_uniform_follows_a_weight_in_proportion(cornell):
    weight = 1 + mask()
    samples = tracer.render(cornell(), spp=30, criterion="uniform", importance=weight).samples
    assert np.all(samples[:, :12] == 20)
    assert np.all(samples[:, 12:] == 40)


@pytest.mark.parametrize("suffix", [".exr", ".png"])
def test_files_are_read_as_they_are_and_scaled(cornell, tmp_path, suffix):
    # a byte of 128 is a weight of one half, not what the sRGB curve makes of it
    values = np.where(mask(32, 48) > 0, 128 / 255, 1.0)
    path = write(tmp_path / f"weight{suffix}", values[..., None].repeat(3, axis=-1))
    samples = tracer.render(cornell(), spp=96, criterion="uniform", importance=path).samples
    ratio = samples[:, 14:].mean() / samples[:, :10].mean()
    assert ratio == pytest.approx(128 / 255, abs=0.02)


def test_shapes_are_weighed_by_what_covers_a_pixel():
    left = {"type": "rectangle", "to_world": T().translate([-1, 0, 0])}
    right = {"type": "rectangle", "to_world": T().translate([1, 0, 0])}
    film = {"type": "hdrfilm", "width": 16, "height": 16, "filter": {"type": "box"}}
    sensor = {"type": "orthographic", "to_world": T().look_at([0, 0, 5], [0, 0, 0], [0, 1, 0]), "film": film}
    scene = {"type": "scene", "left": left, "right": right, "sky": {"type": "constant"}, "sensor": sensor}
    several = {}
    for name in ("left", "right"):
        samples = tracer.render(scene, spp=30, criterion="uniform", shape_weights={name: 2}).samples
        several[name] = [samples[:, :8].mean(), samples[:, 8:].mean()]
        assert sorted(several[name]) == pytest.approx([20, 40], abs=0.5)
    assert several["left"] == pytest.approx(several["right"][::-1], abs=0.5)
    samples = tracer.render(scene, spp=30, criterion="uniform", shape_weights={"left": 2}).samples
    text = tracer.render(scene, spp=30, criterion="uniform", shape_weights=" left = 2,right=1").samples
    assert np.array_equal(text, samples)


def test_the_plugin_takes_them_too(cornell, tmp_path):
    path = write(tmp_path / "mask.exr", mask())
    scene = mi.load_dict(cornell())
    nested = {"type": "path"}
    settings = {"importance": str(path), "shape_weights": "light=2"}
    integrator = mi.load_dict({"type": "adaptive", "nested": nested, "criterion": "uniform", **settings})
    mi.render(scene, integrator=integrator, spp=16)
    assert integrator.result.samples[:, :11].max() <= 2


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ({"importance": np.zeros((16, 24))}, "nothing is wanted"),
        ({"importance": np.full((16, 24), np.nan)}, "finite"),
        ({"importance": -np.ones((16, 24))}, "not negative"),
        ({"importance": mask() - 0.1}, "not negative"),
        ({"importance": np.ones(5)}, "shape"),
        ({"importance": "nowhere.png"}, "importance: There is no picture 'nowhere.png'"),
        ({"shape_weights": {"flor": 2}}, "no shape 'flor', did you mean 'floor'"),
        ({"shape_weights": {"floor": -1}}, "'floor' must be 0 to 1e\\+06"),
        ({"shape_weights": {"floor": 1e39}}, "'floor' must be 0 to 1e\\+06"),
        ({"shape_weights": "floor"}, "write"),
        ({"shape_weights": "floor=much"}, "shape_weights.floor"),
    ],
)
def test_what_is_no_importance_is_refused(cornell, settings, said):
    with pytest.raises(SettingsError, match=said):
        tracer.render(cornell(), spp=16, **settings)


def test_every_criterion_gives_the_least_where_nothing_is_wanted(cornell):
    for name in criteria.names():
        samples = tracer.render(cornell(), spp=16, pilot_spp=4, criterion=name, importance=mask()).samples
        assert samples.sum() == 16 * samples.size
        assert samples[:, :11].max() <= 5, name


def test_a_mask_counts_where_the_budget_leaves_nothing_to_decide(cornell):
    samples = tracer.render(cornell(), spp=6, importance=mask()).samples
    assert samples[:, :11].max() == 1
    assert samples[:, 13:].mean() > 9


def test_a_file_that_a_scene_names_is_beside_it(scene_file, tmp_path, monkeypatch):
    write(tmp_path / "mask.exr", mask(8, 12))
    named = '<string name="importance" value="mask.exr"/><string name="criterion" value="uniform"/></integrator>'
    scene = scene_file(LIT.replace('type="path"/>', f'type="adaptive">{named}'))
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    samples = tracer.render(scene, spp=16).samples
    assert samples[:, :5].max() <= 2
    assert samples[:, 7:].mean() > 28


def test_an_image_of_several_channels_counts_as_their_mean():
    image = np.random.default_rng(0).random((4, 5, 3))
    assert importance_map.check_image(image) == pytest.approx((image[..., 0] + image[..., 1] + image[..., 2]) / 3)


def test_a_larger_image_is_averaged_and_its_edge_repeated_over_the_border():
    """Of a checkerboard of 0 and 1 at twice the resolution every pixel is one half, wherever it is sampled."""
    view = SimpleNamespace(size=(6, 8), border=2)
    board = np.indices((12, 16)).sum(axis=0) % 2
    assert importance_map.on_grid(view, board.astype(float)) == pytest.approx(0.5, abs=0.05)
    own = np.random.default_rng(1).random((6, 8))
    rows, columns = np.clip(np.arange(-2, 8), 0, 5), np.clip(np.arange(-2, 10), 0, 7)
    assert np.array_equal(importance_map.on_grid(view, own), own[np.ix_(rows, columns)])


def test_an_array_is_taken_in_place_of_the_file_that_settings_name():
    view = SimpleNamespace(size=(16, 24), border=0, grid=(16, 24))
    found = importance_map.importance_weights(view, make_settings(importance="nowhere.png"), None, mask())
    assert np.array_equal(found, mask())


def test_images_and_weights_of_shapes_are_multiplied(cornell):
    """What an image leaves out stays out, whatever is seen there."""
    weights = dict.fromkeys(("back", "floor", "ceiling", "green-wall", "red-wall", "small-box", "large-box"), 3)
    samples = tracer.render(cornell(), spp=16, criterion="uniform", importance=mask(), shape_weights=weights).samples
    assert samples[:, :11].max() <= 2

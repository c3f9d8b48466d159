"""What radiosity cannot show is named."""

import mitsuba as mi
import pytest

import tracer
from tracer.radiosity.remarks import remarks
from tracer.scene.load import load

FOG = {"type": "homogeneous", "albedo": 0.8, "sigma_t": 1.0}
MEDIA = "Media are left out, as radiosity knows only surfaces: "
FILM = {"type": "hdrfilm", "width": 4, "height": 4}


def scene(**parts):
    return {"type": "scene", "sky": {"type": "constant"}, "floor": {"type": "rectangle"}, **parts}


@pytest.mark.parametrize(
    ("parts", "expected"),
    [
        ({}, []),
        ({"cloud": {"type": "cube", "interior": FOG}}, [MEDIA + "'cloud'."]),
        ({"bubble": {"type": "sphere", "exterior": FOG}}, [MEDIA + "'bubble'."]),
        ({"sensor": {"type": "perspective", "medium": FOG}}, [MEDIA + "sensor 0."]),
        ({"tin": {"type": "cube", "bsdf": {"type": "conductor"}}}, ["Not diffuse, and shown as if they were: 'tin'."]),
        (
            {
                "smoke": {"type": "cube", "bsdf": {"type": "null"}, "interior": FOG},
                "mist": {"type": "cube", "interior": FOG},
                "sensor": {"type": "perspective", "medium": FOG},
            },
            ["Not diffuse, and shown as if they were: 'smoke'.", MEDIA + "'mist', 'smoke', sensor 0."],
        ),
    ],
)
def test_what_is_shown_otherwise_is_named(parts, expected):
    assert remarks(mi.load_dict(scene(**parts))) == expected


def test_materials_are_named_with_their_shapes():
    tin = {"type": "ref", "id": "tin"}
    parts = {"tin": {"type": "conductor"}, "pan": {"type": "cube", "bsdf": tin}, "lid": {"type": "disk", "bsdf": tin}}
    parts |= {"glass": {"type": "dielectric"}, "pane": {"type": "cube", "bsdf": {"type": "ref", "id": "glass"}}}
    parts |= {"fork": {"type": "cube", "bsdf": {"type": "roughconductor"}}}
    named = "material 'glass' of 'pane', material 'tin' of 2 shapes, 'fork'"
    assert remarks(load(scene(**parts))) == [f"Not diffuse, and shown as if they were: {named}."]


def test_shapes_of_one_name_are_counted():
    loaded = mi.load_dict(scene(a={"type": "cube", "interior": FOG}, b={"type": "cube", "interior": FOG}))
    for shape in loaded.shapes():
        shape.set_id("puff" if shape.interior_medium() else "floor")
    assert remarks(loaded) == [MEDIA + "2 times 'puff'."]


@pytest.mark.parametrize("way", ["mi.render", "tracer.render"])
def test_media_are_named_from_python_once(way, capfd):
    cloud = {"type": "cube", "to_world": mi.ScalarTransform4f().translate([0, 0, 3]), "interior": FOG}
    loaded = mi.load_dict(scene(cloud=cloud, sensor={"type": "perspective", "film": FILM}))
    integrator = mi.load_dict({"type": "radiosity", "size": 1.0, "rays": 4})
    for _ in range(2):
        if way == "mi.render":
            mi.render(loaded, integrator=integrator, spp=1)
        else:
            tracer.render(loaded, integrator=integrator, spp=1)
    written = capfd.readouterr()
    assert (written.out + written.err).count(f"radiosity: {MEDIA}'cloud'.") == 1

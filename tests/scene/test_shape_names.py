"""Shapes are found by what a person can call them, and a message lists what there is."""

import mitsuba as mi
import pytest

import tracer
from conftest import LIT
from tracer.errors import SettingsError
from tracer.scene.load import load
from tracer.scene.shape_names import find_shapes, named_shapes
from tracer.viewpoint.source import Counted, open_source

T = mi.ScalarTransform4f
FILM = {"type": "hdrfilm", "width": 16, "height": 16, "filter": {"type": "box"}}
FRONT = {"type": "orthographic", "to_world": T().look_at([0, 0, 5], [0, 0, 0], [0, 1, 0]), "film": FILM}


def quarter(x, y):
    return {"type": "rectangle", "to_world": T().translate([x, y, 0]).scale([0.5, 0.5, 1])}


def quarters(scene, weights):
    """Return the mean samples of the quarters of a picture, as read."""
    samples = tracer.render(scene, spp=30, criterion="uniform", shape_weights=weights).samples
    return [
        samples[rows, columns].mean() for rows in (slice(0, 8), slice(8, 16)) for columns in (slice(0, 8), slice(8, 16))
    ]


def unnamed(scene_file):
    """Return a scene of two halves, the right one mirrored, in whose file no shape has an id."""
    place = '<transform name="to_world"><scale x="{}" y="1"/><translate x="{}"/></transform>'
    half = f'<shape type="rectangle">{place}</shape>'
    sensor = """<sensor type="orthographic"><transform name="to_world">
    <lookat origin="0,0,5" target="0,0,0" up="0,1,0"/></transform>
    <film type="hdrfilm"><integer name="width" value="16"/><integer name="height" value="16"/>
    <rfilter type="box"/></film></sensor>"""
    halves = half.format(0.5, -0.5) + half.format(-0.5, 0.5)
    return scene_file(f'<integrator type="path"/>{sensor}{halves}<emitter type="constant"/>')


@pytest.mark.parametrize(("number", "expected"), [("1", [40, 20, 40, 20]), ("2", [20, 40, 20, 40])])
def test_shapes_without_an_id_are_found_by_number(scene_file, number, expected):
    path = unnamed(scene_file)
    assert quarters(path, {number: 2}) == pytest.approx(expected, abs=0.5)
    assert quarters(path, {int(number): 2}) == pytest.approx(expected, abs=0.5)


def test_numbers_are_those_of_the_layer_of_shapes(scene_file):
    path = unnamed(scene_file)
    seen = tracer.render(path, spp=4, features=True).seen.shapes
    samples = tracer.render(path, spp=30, criterion="uniform", shape_weights={"2": 2}).samples
    assert samples[seen == 2].mean() > 1.9 * samples[seen == 1].mean()


@pytest.mark.parametrize(
    ("weights", "expected"),
    [
        ({"near": 2}, [40, 20, 40, 20]),
        ({"mirrored": 2}, [20, 40, 20, 40]),
        ({"2": 2}, [20, 40, 20, 40]),
        ({"both.high": 2}, [40, 40, 20, 20]),
        ({"low": 2}, [20, 20, 40, 40]),
        ({"both": 2}, [30, 30, 30, 30]),
        ({"mirrored": 2, "high": 3}, [30, 60, 10, 20]),
    ],
)
def test_instances_and_what_is_in_them_have_names(weights, expected):
    both = {"type": "shapegroup", "low": quarter(0, -0.5), "high": quarter(0, 0.5)}
    member = {"type": "ref", "id": "both"}
    near = {"type": "instance", "group": member, "to_world": T().translate([-0.5, 0, 0])}
    mirrored = {"type": "instance", "group": member, "to_world": T().translate([0.5, 0, 0]).scale([-1, 1, 1])}
    sky = {"type": "constant"}
    scene = {"type": "scene", "both": both, "near": near, "mirrored": mirrored, "sky": sky, "sensor": FRONT}
    assert quarters(scene, weights) == pytest.approx(expected, abs=0.5)


def test_members_of_a_merge_have_their_own_names():
    merged = {
        "type": "merge",
        "left": {"type": "cube"},
        "right": {"type": "cube", "to_world": T().translate([3, 0, 0])},
    }
    scene = load({"type": "scene", "all": merged})
    assert find_shapes(scene, ["right"])["right"][0].bbox().center().x == pytest.approx(3)


def test_names_are_those_of_mitsuba(scene_file):
    scene = load(unnamed(scene_file))
    keys = {name.removesuffix(".to_world") for name in mi.traverse(scene).keys() if name.endswith(".to_world")}  # noqa: SIM118
    own = set().union(*(entry.names for entry in named_shapes(scene)))
    assert len(own) == 2
    assert own < keys  # of the sensor, too


def test_an_id_goes_before_a_number(scene_file):
    shapes = '<shape type="sphere"/><shape type="sphere" id="1"><point name="center" x="7" y="0" z="0"/></shape>'
    scene = load(scene_file(LIT + shapes))
    assert [shape.bbox().center().x for shape in find_shapes(scene, ["1"])["1"]] == pytest.approx([7])


def test_the_message_lists_what_there_is(scene_file):
    named = '<shape type="cube" id="box"/><shape type="sphere"><point name="center" x="1" y="2" z="3.5"/></shape>'
    with pytest.raises(SettingsError, match=r"no shape 'lamp'; it has box; 2 \(Sphere around 1, 2, 3\.5\)\.$"):
        tracer.render(scene_file(LIT + named), spp=1, shape_weights={"lamp": 2})
    with pytest.raises(SettingsError, match=r"no shape 'bx', did you mean 'box'\?$"):
        tracer.render(scene_file(LIT + named), spp=1, shape_weights={"bx": 2})
    with pytest.raises(SettingsError, match=r"no shape '3', nor any other\.$"):
        tracer.render(scene_file(LIT), spp=1, shape_weights={3: 2})
    many = "".join('<shape type="sphere"/>' for _ in range(40))
    with pytest.raises(SettingsError, match=r"; 24 \(Sphere around 0, 0, 0\) and 16 more\.$"):
        tracer.render(scene_file(LIT + many), spp=1, shape_weights={"lamp": 2})


def test_meshes_that_mitsuba_has_merged_are_explained(cornell):
    scene = mi.load_dict(cornell())
    assert [entry.number for entry in named_shapes(scene)] == list(range(1, len(scene.shapes()) + 1))
    with pytest.raises(SettingsError, match=r"red-wall.*merged.*optimize=False\.$"):
        tracer.render(scene, spp=1, shape_weights={"lamp": 2})


def test_meshes_without_an_id_are_called_after_their_files(scene_file, tmp_path):
    (tmp_path / "models").mkdir()
    mi.load_dict({"type": "cube"}).write_ply(str(tmp_path / "models" / "chair.v2.ply"))
    chair = '<shape type="ply"{}><string name="filename" value="models/chair.v2.ply"/>{}</shape>'
    beside = '<transform name="to_world"><translate x="3"/></transform>'
    lamp = '<shape type="sphere" id="chair_v2 2"><emitter type="area"/></shape>'
    path = scene_file(chair.format("", "") + lamp + chair.format("", beside) + chair.format(' id="stool"', beside))
    scene = load(path)
    assert sorted(shape.id() for shape in scene.shapes()) == ["chair_v2", "chair_v2 2", "chair_v2 3", "stool"]
    (third,) = find_shapes(scene, ["chair_v2 3"])["chair_v2 3"]
    assert float(third.bbox().min.x) == pytest.approx(2)
    grouped = open_source(path, Counted(groups=("chair_v2*",))).subject
    assert grouped.names == ["chair_v2*", "stool"]
    weighted = open_source(path, Counted("shape", weights={"chair_v2": 5.0})).subject
    assert weighted.weights[weighted.names.index("chair_v2")] == 5

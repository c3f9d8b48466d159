"""Projected areas against formulas, and against one ray at a time."""

import subprocess
import sys

import mitsuba as mi
import numpy as np
import pytest
from scipy import stats

from tracer.complexity import measures
from tracer.core import sphere
from tracer.errors import SceneError, SettingsError
from tracer.viewpoint import item_buffer
from tracer.viewpoint.fast import estimate_entropy
from tracer.viewpoint.item_buffer import Rays, around, at, projected_areas
from tracer.viewpoint.lens import Orthographic, Perspective, WholeSphere
from tracer.viewpoint.regions import look_through_blocks
from tracer.viewpoint.surfaces import NOT_COUNTED, open_subject
from tracer.viewpoint.survey import survey

from .conftest import mesh_scene

CORNER = sphere.normalised([1.0, 1.0, 1.0])
GRID = Rays(side=512)


def seen(subject, viewpoints, lens, rays=GRID):
    """Return the projected areas of all viewpoints (V, Z) in float64."""
    return np.concatenate([batch.areas for batch in projected_areas(subject, viewpoints, lens, rays)]).astype(float)


def directions(*vectors):
    return sphere.normalised(np.array(vectors, float))


@pytest.mark.parametrize(
    ("direction", "entropy", "visible"),
    [((0, 0, 1), 0.0, 1), ((1, 0, 1), 1.0, 2), ((1, 1, 1), np.log2(3), 3)],
)
def test_a_cube_of_six_faces_from_far(quads, direction, entropy, visible):
    subject = open_subject(quads, "shape")
    areas = seen(subject, around(subject.centre, 3, directions(direction)), Orthographic(1))[0]
    assert subject.count == 6
    assert np.count_nonzero(areas) == visible
    assert measures.entropy(areas) == pytest.approx(entropy, abs=2e-3)
    assert areas.sum() == pytest.approx(np.abs(directions(direction)).sum(), rel=4e-3)  # edge 1: sum of cosines


def test_the_same_cube_in_triangles_has_a_bit_more(triangles):
    subject = open_subject(triangles)
    views = around(subject.centre, 3, directions((0, 0, 1), (1, 0, 1), (1, 1, 1)))
    assert subject.count == 12
    assert subject.areas == pytest.approx(np.full(12, 0.5))
    found = measures.entropy(seen(subject, views, Orthographic(1)))
    assert found == pytest.approx([1, 2, 1 + np.log2(3)], abs=3e-3)
    shape = open_subject(triangles, "shape")
    assert shape.count == 1
    assert shape.areas == pytest.approx([6])
    assert shape.names == ["cube"]


def test_a_cube_from_its_middle(quads, triangles):
    for scene, kind, count in ((quads, "shape", 6), (triangles, "face", 12)):
        areas = seen(open_subject(scene, kind), at(np.zeros((1, 3))), WholeSphere())[0]
        assert areas.sum() == pytest.approx(4 * np.pi)
        assert measures.entropy(areas) == pytest.approx(np.log2(count), abs=1e-4)


@pytest.mark.parametrize(
    ("distance", "omega", "six", "twelve"), [(2, 0.400670, 0.203755, 0.235639), (3, 0.153884, 0.095338, 0.107584)]
)
def test_a_cube_on_the_whole_sphere_with_background(quads, triangles, distance, omega, six, twelve):
    for scene, kind, entropy in ((quads, "shape", six), (triangles, "face", twelve)):
        subject = open_subject(scene, kind)
        areas = seen(subject, at(np.array([[0.0, 0.0, distance]])), WholeSphere())[0]
        assert areas.sum() == pytest.approx(omega, rel=5e-3)
        assert measures.entropy([*areas, 4 * np.pi - areas.sum()]) == pytest.approx(entropy, rel=5e-3)


def test_a_pinhole_measures_solid_angles(quads):
    subject = open_subject(quads, "shape")
    lens = Perspective(90.0)
    eye = np.array([[0.0, 0.0, 2.0]])
    narrow = seen(subject, around(np.zeros(3), 2, directions((0, 0, 1))), lens, Rays(side=1024))[0]
    assert narrow.sum() == pytest.approx(0.400670, rel=4e-3)
    assert narrow == pytest.approx(seen(subject, at(eye), WholeSphere())[0], rel=5e-3)
    assert lens.image_area == pytest.approx(4 * np.pi / 6)  # six such images see everything


def test_a_sphere_covers_its_cap():
    subject = open_subject(mi.load_dict({"type": "scene", "ball": {"type": "sphere", "radius": 0.5}}))
    assert subject.areas == pytest.approx([np.pi])
    for distance in (0.7, 1.5, 4.0):
        covered = seen(subject, at(np.array([[0, 0, distance]])), WholeSphere())[0, 0] / (4 * np.pi)
        assert covered == pytest.approx((1 - np.sqrt(1 - (0.5 / distance) ** 2)) / 2, rel=3e-3)


def test_mean_projected_area_of_a_convex_body_is_a_quarter_of_its_area(quads):
    subject = open_subject(quads, "shape")
    views = around(subject.centre, 3, sphere.evenly(400))
    areas = seen(subject, views, Orthographic(1), Rays(side=128))
    assert areas.sum(axis=1).mean() == pytest.approx(6 / 4, rel=2e-3)
    assert areas.mean(axis=0) == pytest.approx(np.full(6, 0.25), rel=1e-2)


def test_splitting_into_batches_changes_nothing(quads, monkeypatch):
    subject = open_subject(quads, "shape")
    views = around(subject.centre, 3, sphere.evenly(17))
    for rays in (Rays(side=64), Rays(random=5000, seed=3)):
        whole = seen(subject, views, Perspective(40), rays)
        with monkeypatch.context() as patch:
            patch.setattr(item_buffer, "MOST_RAYS", 1000)
            assert np.array_equal(seen(subject, views, Perspective(40), rays), whole)
        with monkeypatch.context() as patch:
            patch.setattr(item_buffer, "MOST_AREAS", 13)
            assert np.array_equal(seen(subject, views, Perspective(40), rays), whole)


@pytest.mark.parametrize("fov", [1.0, 19.0, 90.0, 150.0])
def test_random_rays_through_a_pinhole_are_uniform_in_solid_angle(fov):
    lens = Perspective(fov)
    generator = np.random.default_rng(2)
    u, v = (mi.Float(generator.random(20000).astype(np.float32)) for _ in range(2))
    _, direction, weight = lens.random_ray(u, v)
    assert np.unique(weight.numpy()) == pytest.approx(lens.image_area)
    x, y, z = np.array(direction).astype(float)
    column, row = (np.clip((each / -z / lens.reach + 1) * 2, 0, 3.999).astype(int) for each in (x, y))
    fine = (np.arange(400) + 0.5) / 200 - 1
    density = (1 + (lens.reach * fine) ** 2 + (lens.reach * fine[:, None]) ** 2) ** -1.5
    expected = density.reshape(4, 100, 4, 100).sum(axis=(1, 3)).ravel()
    counts = np.bincount(4 * row + column, minlength=16)
    assert stats.chisquare(counts, 20000 * expected / expected.sum()).pvalue > 0.001 / 4  # all four: 1 in 1000


@pytest.mark.parametrize("rays", [Rays(side=20), Rays(random=400)])
@pytest.mark.parametrize("lens", [Perspective(120), Perspective(20), Orthographic(0.1), WholeSphere()])
def test_where_everything_hits_there_is_no_background(quads, lens, rays):
    subject = open_subject(quads, "shape")
    total = seen(subject, at(np.zeros((1, 3))), lens, rays).sum()
    assert total == pytest.approx(lens.image_area, rel=1e-6)


def test_random_rays_of_two_seeds_and_viewpoints_differ(quads):
    subject = open_subject(quads, "shape")
    same = at(np.zeros((2, 3)))
    first = seen(subject, same, WholeSphere(), Rays(random=1000, seed=1))
    assert not np.array_equal(first[0], first[1])
    assert not np.array_equal(first, seen(subject, same, WholeSphere(), Rays(random=1000, seed=2)))
    assert np.array_equal(first, seen(subject, same, WholeSphere(), Rays(random=1000, seed=1)))


def test_surfaces_are_faces_shapes_or_materials():
    grey = {"type": "diffuse", "id": "grey"}
    scene = mi.load_dict(
        {
            "type": "scene",
            "grey": grey,
            "left": {
                "type": "cube",
                "to_world": mi.ScalarTransform4f().translate([-3, 0, 0]),
                "b": {"type": "ref", "id": "grey"},
            },
            "right": {"type": "sphere", "center": [3, 0, 0], "b": {"type": "ref", "id": "grey"}},
            "red": {
                "type": "disk",
                "to_world": mi.ScalarTransform4f().scale(2),
                "b": {"type": "conductor", "id": "shiny"},
            },
        }
    )
    views = around(np.zeros(3), 20, directions((0, 0, 1)))
    by = {kind: open_subject(scene, kind) for kind in ("face", "shape", "bsdf")}
    assert [by[kind].count for kind in by] == [14, 3, 2]
    found = {kind: seen(one, views, Orthographic(8))[0] for kind, one in by.items()}
    shapes = dict(zip(by["shape"].names, found["shape"], strict=True))
    assert shapes == pytest.approx({"left": 4.0, "right": np.pi, "red": 4 * np.pi}, rel=2e-2)
    materials = dict(zip(by["bsdf"].names, found["bsdf"], strict=True))
    assert materials == pytest.approx({"grey": 4.0 + np.pi, "shiny": 4 * np.pi}, rel=2e-2)
    assert found["face"].sum() == pytest.approx(found["shape"].sum())
    grouped = open_subject(scene, groups=np.arange(14) // 7)
    assert seen(grouped, views, Orthographic(8))[0].sum() == pytest.approx(found["shape"].sum())
    assert by["face"].radius == pytest.approx(np.linalg.norm([4, 2, 1]), rel=0.1)


def test_an_instance_is_one_surface():
    scene = mi.load_dict(
        {
            "type": "scene",
            "group": {
                "type": "shapegroup",
                "id": "pair",
                "a": {"type": "cube"},
                "b": {"type": "sphere", "center": [3, 0, 0]},
            },
            "near": {"type": "instance", "group": {"type": "ref", "id": "pair"}},
            "far": {
                "type": "instance",
                "to_world": mi.ScalarTransform4f().translate([0, 5, 0]),
                "group": {"type": "ref", "id": "pair"},
            },
        }
    )
    subject = open_subject(scene)
    assert subject.count == 2
    areas = seen(subject, around(subject.centre, 20, directions((0, 0, 1))), Orthographic(8))[0]
    assert areas == pytest.approx([4 + np.pi] * 2, rel=1e-2)


@pytest.mark.slow
def test_rays_agree_with_one_ray_at_a_time(triangles):
    subject = open_subject(triangles)
    views = around(subject.centre, 2.5, directions((1, 2, 3)))
    right, up, forward, eye = views.right[0], views.up[0], views.forward[0], views.eyes[0]
    expected = np.zeros(12)
    for v in (np.arange(16) + 0.5) / 16:
        for u in (np.arange(16) + 0.5) / 16:
            origin = eye + (2 * u - 1) * right + (1 - 2 * v) * up
            found = triangles.ray_intersect(mi.Ray3f(mi.Point3f(origin.tolist()), mi.Vector3f(forward.tolist())))
            if found.is_valid()[0]:
                expected[found.prim_index[0]] += 4 / 256
    assert seen(subject, views, Orthographic(1), Rays(side=16))[0] == pytest.approx(expected)


def test_what_cannot_be_looked_at():
    with pytest.raises(SceneError, match="no shape"):
        open_subject(mi.load_dict({"type": "scene", "sky": {"type": "constant"}}))
    with pytest.raises(SceneError, match="no face"):
        open_subject(mesh_scene(np.zeros((3, 3)), np.zeros((0, 3))))
    with pytest.raises(SettingsError, match="Unknown kind of surface 'patch'"):
        open_subject(mi.load_dict({"type": "scene", "ball": {"type": "sphere"}}), "patch")


CUBE = np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])
SIDES = [(0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1)]
SIDES += [(2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3)]


@pytest.mark.parametrize(("scale", "offset"), [(1e-6, 0.0), (1e6, 0.0), (1e9, 0.0), (1.0, 1e4)])
def test_units_of_length_do_not_matter(scale, offset):
    found = []
    for one in (open_subject(mesh_scene(CUBE, SIDES)), open_subject(mesh_scene(CUBE * scale + offset, SIDES))):
        views = around(one.centre, 6 * one.radius, sphere.normalised([[1.0, 2.0, 3.0]]))
        areas = seen(one, views, Orthographic(one.radius), Rays(side=256))[0]
        found.append(areas / areas.sum())
    assert found[1] == pytest.approx(found[0], abs=2e-3)


@pytest.mark.parametrize(("scale", "offset"), [(1e12, 0.0), (1.0, 1e7)])
def test_what_single_precision_cannot_see_is_refused(scale, offset):
    with pytest.raises(SceneError, match="radius"):
        open_subject(mesh_scene(CUBE * scale + offset, SIDES))


@pytest.mark.slow
def test_memory_is_flat_in_the_number_of_viewpoints(tmp_path):
    """Only stability keeps more of more views: a belt of them, as many as their square root."""
    program = """
import resource, sys, tracer
tracer.activate()
import mitsuba as mi
from tracer.core import sphere
from tracer.viewpoint import measures
from tracer.viewpoint.direction_measure import stand
from tracer.viewpoint.item_buffer import Rays
from tracer.viewpoint.surfaces import open_subject
from tracer.viewpoint.survey import survey
ball = mi.load_dict({"type": "scene", "ball": {"type": "sphere"}, "cube": {"type": "cube"}})
subject = open_subject(ball)
place = stand(subject)
directions, triangles = sphere.icosphere(int(sys.argv[1]))
names = [name for name in measures.names() if "neighbours" not in measures.get(name).needs]
survey(subject, place.viewpoints(directions), place.lens, Rays(side=256), names)
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
"""
    peak = {}
    for level in (2, 3):  # 162 and 642 views: 3 and 10 wavefronts
        done = subprocess.run([sys.executable, "-c", program, str(level)], capture_output=True, text=True, check=True)
        peak[level] = int(done.stdout)
    assert peak[3] < 1.1 * peak[2]


def plates():
    """Return a square of side 2, and half of it hidden by a nearer rectangle."""
    turn = mi.ScalarTransform4f
    near = turn().translate([0.5, 0, 1]).scale([0.5, 1, 1])
    return mi.load_dict(
        {"type": "scene", "far": {"type": "rectangle"}, "near": {"type": "rectangle", "to_world": near}}
    )


def test_what_is_of_no_surface_hides_and_counts_as_background():
    scene = plates()
    far = [0 if shape.id() == "far" else NOT_COUNTED for shape in scene.shapes()]
    subject = open_subject(scene, groups=np.repeat(far, 2), names=["far"])
    view, lens = around(np.zeros(3), 5.0, np.array([[0.0, 0, 1]])), Orthographic(1.0)
    batch = next(projected_areas(subject, view, lens, Rays(side=64), pictures=True))
    assert batch.areas.tolist() == [[pytest.approx(2.0)]]
    assert np.isfinite(batch.depth).mean() == 0.5
    assert survey(subject, view, lens, Rays(side=64), ["entropy"])["entropy"] == pytest.approx([1.0])
    assert estimate_entropy(subject, view, lens, 4000).covered == pytest.approx([0.5], abs=0.03)
    found = look_through_blocks(subject, view, lens, 1, 1, 64)
    assert found.entropy.tolist() == [[pytest.approx(1.0)]]
    assert subject.areas.tolist() == [pytest.approx(4.0)]


def test_triangles_of_no_surface_are_no_part_of_the_mesh(triangles):
    subject = open_subject(triangles, groups=[0] * 6 + [NOT_COUNTED] * 6)
    assert subject.areas == pytest.approx([3.0])
    assert len(subject.mesh.triangles) == 6

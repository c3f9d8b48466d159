"""Measures of many views: identities of information theory, brute force, and what is asked of them."""

import mitsuba as mi
import numpy as np
import pytest

from tracer.core import sphere
from tracer.errors import SettingsError
from tracer.viewpoint import item_buffer, measures
from tracer.viewpoint.channel import adjacent, new_channel
from tracer.viewpoint.direction_measure import stand
from tracer.viewpoint.item_buffer import Rays, Viewpoints, around, at, projected_areas
from tracer.viewpoint.lens import Orthographic, Perspective, WholeSphere
from tracer.viewpoint.surfaces import open_subject
from tracer.viewpoint.survey import survey

from .conftest import mesh_scene

DIRECTIONS, TRIANGLES = sphere.icosphere(2)
BESIDE = sphere.neighbours(TRIANGLES)
RAYS = Rays(side=96)
FRAME = ("eyes", "forward", "right", "up")


@pytest.fixture(scope="module")
def subject():
    """Return a cube and a rod beside it, in triangles: nothing about it is symmetric."""
    turn = mi.ScalarTransform4f
    parts = {
        "cube": {"type": "cube", "to_world": turn().rotate([1, 2, 3], 20).scale(0.5)},
        "rod": {"type": "cube", "to_world": turn().translate([0.9, 0.2, 0.4]).scale([0.1, 0.2, 0.9])},
    }
    return open_subject(mi.load_dict({"type": "scene", **parts}))


@pytest.fixture(scope="module")
def areas(subject):
    """Return all projected areas (V, Z)."""
    views = around(subject.centre, 6 * subject.radius, DIRECTIONS)
    return np.concatenate([one.areas for one in projected_areas(subject, views, Perspective(19), RAYS)]).astype(float)


@pytest.fixture(scope="module")
def values(subject):
    """Return all measures of all views."""
    views = around(subject.centre, 6 * subject.radius, DIRECTIONS)
    return survey(subject, views, Perspective(19), RAYS, measures.names(), background=False, beside=BESIDE)


def entropy(p):
    p = p[p > 0] / p.sum()
    return -np.sum(p * np.log2(p))


def test_there_are_the_22_of_the_survey(values):
    assert len(measures.names()) == 22
    assert all(np.all(np.isfinite(found)) for found in values.values())
    assert all(found.shape == (162,) for found in values.values())


def test_three_informations_have_one_mean(areas, values):
    weights = areas.sum(axis=1) / areas.sum()
    joint = areas / areas.sum()
    expected = entropy(joint.sum(axis=0)) + entropy(joint.sum(axis=1)) - entropy(joint.ravel())
    for name in ("mutual_information", "information_2", "information_3"):
        assert np.sum(weights * values[name]) == pytest.approx(expected, rel=1e-6)
    assert values["mutual_information"].min() >= 0


def test_measures_of_areas_by_brute_force(subject, areas, values):
    shares = areas / areas.sum(axis=1, keepdims=True)
    true = subject.areas / subject.areas.sum()
    for k in (0, 7, 100):
        p = shares[k]
        assert values["visible"][k] == np.count_nonzero(p)
        assert values["entropy"][k] == pytest.approx(entropy(p))
        seen = p > 0
        assert values["kullback_leibler"][k] == pytest.approx(np.sum(p[seen] * np.log2(p[seen] / true[seen])))
        assert values["visibility_ratio"][k] == pytest.approx(true[seen].sum())
        covered = areas[k].sum() / Perspective(19).image_area
        assert values["projected_area"][k] == pytest.approx(covered)
        assert values["viewpoint_complexity"][k] == pytest.approx(seen.mean() + covered)


def test_saliency_by_brute_force(subject, areas, values):
    by_surface = areas.T  # rows: p(v|z) up to a factor
    salient, count = np.zeros(subject.count), np.zeros(subject.count)
    for y, z in adjacent(subject.mesh):
        both = by_surface[y] + by_surface[z]
        own = sum(by_surface[k].sum() * entropy(by_surface[k]) for k in (y, z)) / both.sum()
        for k in (y, z):
            salient[k] += entropy(both) - own
            count[k] += 1
    assert np.all(count == 3)  # every triangle of a box has three neighbours
    salient /= count
    seen = areas > 0
    assert values["visible_saliency"] == pytest.approx(seen @ salient, rel=1e-6)
    assert values["projected_saliency"] == pytest.approx((areas / areas.sum(axis=0)) @ salient, rel=1e-6)


def test_instability_by_brute_force(areas, values):
    for k in (0, 13, 161):
        found = []
        for other in BESIDE[k]:
            pair = areas[[k, other]]
            own = sum(row.sum() * entropy(row) for row in pair) / pair.sum()
            found.append(entropy(pair.sum(axis=0)) - own)
        assert values["instability"][k] == pytest.approx(np.mean(found), rel=1e-6)


def test_batches_change_nothing(subject, values, monkeypatch):
    monkeypatch.setattr(item_buffer, "MOST_RAYS", 5 * RAYS.count(Perspective(19)))
    views = around(subject.centre, 6 * subject.radius, DIRECTIONS)
    again = survey(subject, views, Perspective(19), RAYS, measures.names(), background=False, beside=BESIDE)
    assert all(np.array_equal(again[name], values[name]) for name in values)


def halves(scene_of):
    """Return a subject of the octahedron, its faces whole or split in two of the same area."""
    points = np.vstack([np.eye(3), -np.eye(3)])
    corners = [(a, b, c) for a in (0, 3) for b in (1, 4) for c in (2, 5)]
    if scene_of == "whole":
        return open_subject(mesh_scene(points, corners))
    middles = [(points[a] + points[b]) / 2 for a, b, _ in corners]
    faces = [part for k, (a, b, c) in enumerate(corners) for part in ((a, 6 + k, c), (6 + k, b, c))]
    return open_subject(mesh_scene(np.vstack([points, middles]), faces))


def test_splitting_every_face_adds_a_bit_of_entropy_and_nothing_else():
    names = ["entropy", "kullback_leibler", "mutual_information"]
    found = {}
    for kind in ("whole", "split"):
        subject = halves(kind)
        views = around(subject.centre, 3, sphere.icosphere(1)[0])
        found[kind] = survey(subject, views, Orthographic(1.2), Rays(side=700), names, background=False)
    assert found["split"]["entropy"] == pytest.approx(found["whole"]["entropy"] + 1, abs=1e-3)
    assert found["split"]["kullback_leibler"] == pytest.approx(found["whole"]["kullback_leibler"], abs=1e-3)
    assert found["split"]["mutual_information"] == pytest.approx(found["whole"]["mutual_information"], abs=1e-3)


def test_a_fine_sphere_has_the_known_values():
    points, faces = sphere.icosphere(3)
    subject = open_subject(mesh_scene(points, faces))
    names = ["entropy", "kullback_leibler", "visibility_ratio", "visible"]
    views = around(np.zeros(3), 3, sphere.evenly(5))
    found = survey(subject, views, Orthographic(1.01), Rays(side=1500), names, background=False)
    assert found["entropy"] == pytest.approx(np.full(5, np.log2(1280) - 1.27865), abs=0.01)
    assert found["kullback_leibler"] == pytest.approx(np.full(5, 1.27865), abs=0.01)
    assert found["visibility_ratio"] == pytest.approx(np.full(5, 0.5), abs=0.03)
    inside = survey(subject, at(np.zeros((1, 3))), WholeSphere(), Rays(side=800), ["entropy"], background=False)
    assert inside["entropy"] == pytest.approx(np.log2(1280), abs=0.01)


def test_convex_bodies_make_mutual_information_the_divergence_from_true_area():
    subject = halves("whole")
    views = around(np.zeros(3), 3, sphere.evenly(500))
    names = ["kullback_leibler", "mutual_information"]
    found = survey(subject, views, Orthographic(1.2), Rays(side=128), names)
    assert found["kullback_leibler"] == pytest.approx(found["mutual_information"], abs=5e-3)


def test_a_view_that_sees_nothing_is_the_worst_and_no_number_is_missing(subject):
    views = at(np.array([[0.0, 0.0, 50.0]]))
    away = item_buffer.Viewpoints(views.eyes, -views.forward, views.right, views.up)
    beside = [np.array([], np.int64)]
    found = survey(subject, away, Perspective(10), RAYS, measures.names(), beside=beside)
    assert not any(np.isnan(values).any() for values in found.values())
    assert found["entropy"] == 0
    assert found["viewpoint_complexity"] == 0
    assert found["kullback_leibler"] == np.inf


def test_what_a_measure_needs_and_is_not_there(subject):
    views = around(subject.centre, 5, DIRECTIONS[:2])
    with pytest.raises(SettingsError, match="Unknown measure 'beauty'; choose one of curvature_entropy, "):
        survey(subject, views, Perspective(19), RAYS, ["beauty"])
    with pytest.raises(SettingsError, match="as an image"):
        survey(subject, views, WholeSphere(), RAYS, ["maximum_depth"])
    with pytest.raises(SettingsError, match="as an image"):
        survey(subject, views, Perspective(19), Rays(random=10), ["silhouette_length"])
    with pytest.raises(SettingsError, match="those beside it"):
        survey(subject, views, Perspective(19), RAYS, ["instability"])
    ball = open_subject(mi.load_dict({"type": "scene", "ball": {"type": "sphere"}}))
    with pytest.raises(SettingsError, match="need a mesh"):
        survey(ball, views, Perspective(19), RAYS, ["curvature_entropy"])


def test_progress_counts_both_passes(subject):
    told = []
    views = around(subject.centre, 5, DIRECTIONS[:8])
    names = ["entropy", "mutual_information"]
    survey(subject, views, Perspective(19), RAYS, names, progress=lambda done, total: told.append((done, total)))
    assert told[-1] == (16, 16)
    assert told == sorted(told)


def test_vertices_that_no_face_has_change_nothing():
    corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 2, 0], [0, 0, 0.5], [50, 0, 0]])
    faces = [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]
    alone, stray = (open_subject(mesh_scene(one, faces)) for one in (corners[:4], corners))
    assert stray.radius == alone.radius
    views = around(alone.centre, 9, sphere.icosphere(0)[0])
    found = [survey(one, views, Perspective(19), RAYS, ["curvature_entropy"]) for one in (alone, stray)]
    assert np.array_equal(*(one["curvature_entropy"] for one in found))


def test_what_sees_nothing_is_no_good_view(subject):
    views = around(np.array([500.0, 0, 0]), 2, sphere.icosphere(0)[0])
    beside = sphere.neighbours(sphere.icosphere(0)[1])
    found = survey(subject, views, Perspective(19), RAYS, ["instability", "depth_stability"], beside=beside)
    assert np.all(found["instability"] == 1)
    assert np.all(found["depth_stability"] == 0)


def test_true_areas_that_no_shape_tells_are_not_made_up():
    group = {"type": "shapegroup", "cube": {"type": "cube"}}
    one = {"type": "instance", "group": {"type": "ref", "id": "group"}}
    scene = mi.load_dict({"type": "scene", "group": group, "one": one})
    subject = open_subject(scene)
    assert not subject.areas_known
    views = around(subject.centre, 9, sphere.icosphere(0)[0])
    assert survey(subject, views, Perspective(40), RAYS, ["entropy"])["entropy"].max() > 0
    with pytest.raises(SettingsError, match="True areas are not known"):
        survey(subject, views, Perspective(40), RAYS, ["kullback_leibler"])


def saliency(areas, faces):
    """Return S(z) of triangles (Z, 3) by the formula, one pair of neighbours after the other."""
    by_surface = areas.T  # rows: p(v|z) up to a factor
    found = []
    for z, face in enumerate(faces):
        beside = [y for y, other in enumerate(faces) if len(set(face) & set(other)) == 2]
        divergences = []
        for y in beside:
            both = by_surface[y] + by_surface[z]
            own = sum(by_surface[k].sum() * entropy(by_surface[k]) for k in (y, z)) / both.sum()
            divergences.append(entropy(both) - own)
        found.append(np.mean(divergences) if beside else 0.0)
    return np.array(found)


def salient_divergence(areas, salient):
    """Return the sum of p log2(p / q), q ~ p(z) S(z), over the surfaces of which S > 0, for each row of areas."""
    wanted = areas.sum(axis=0) * salient
    rows = [(row / row.sum(), (row > 0) & (salient > 0)) for row in areas]
    return [np.sum(p[seen] * np.log2(p[seen] * wanted.sum() / wanted[seen])) for p, seen in rows]


def test_salient_mutual_information_by_its_formula(subject, areas, values):
    """VMI with p(z) S(z) / sum p S instead of p(z) (Feixas and others, equation 24)."""
    expected = salient_divergence(areas, saliency(areas, subject.mesh.joined))
    assert values["salient_mutual_information"] == pytest.approx(expected, rel=1e-3)


def test_surfaces_without_saliency_are_left_out():
    """A triangle by itself has no neighbour that it could differ from: it hides, and is not missed."""
    points, faces = sphere.icosphere(1)
    apart = [[1.5, 0, 0], [1.5, 0.5, 0], [1.5, 0, 0.5]]
    faces = np.vstack([faces, len(points) + np.arange(3)])
    subject = open_subject(mesh_scene(np.vstack([points, apart]), faces))
    directions = sphere.icosphere(1)[0]
    place = stand(subject)
    views = place.viewpoints(directions)
    areas = np.concatenate([one.areas for one in projected_areas(subject, views, place.lens, RAYS)]).astype(float)
    found = survey(subject, views, place.lens, RAYS, ["salient_mutual_information"])["salient_mutual_information"]
    assert found == pytest.approx(salient_divergence(areas, saliency(areas, faces)), rel=1e-5)
    assert 1 < found.min() < found.max() < 2
    assert directions[found.argmin()] == pytest.approx([1, 0, 0])


def test_what_sees_nothing_salient_is_no_good_view():
    points, faces = sphere.icosphere(0)
    far = np.array([[40.0, 0, 0], [40, 0.5, 0], [40, 0, 0.5]])
    subject = open_subject(mesh_scene(np.vstack([points, far]), np.vstack([faces, len(points) + np.arange(3)])))
    views = [around(np.zeros(3), 8, -np.eye(3)), around(far.mean(axis=0), 8, -np.eye(3)[:1])]
    views = Viewpoints(*(np.concatenate([getattr(one, name) for one in views]) for name in FRAME))
    found = survey(subject, views, Perspective(19), RAYS, ["salient_mutual_information", "visible"])
    assert found["visible"][3] == 1
    assert np.isfinite(found["salient_mutual_information"]).tolist() == [True, True, True, False]


def test_rounding_is_not_saliency():
    """Two surfaces of which every view sees the same part of each have a divergence of 0, whatever their size."""
    generator = np.random.default_rng(5)
    areas = generator.uniform(0, 1e-5, (162, 1)) * generator.uniform(0.1, 10, 400)
    channel = new_channel(400, np.arange(400).reshape(-1, 2))
    channel.add(areas)
    assert np.all(channel.saliency == 0)

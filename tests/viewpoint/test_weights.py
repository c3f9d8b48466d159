"""Weights count in every measure, search and view set; a surface of weight 0 hides and does not count."""

from dataclasses import replace

import mitsuba as mi
import numpy as np
import pytest

from tracer.core import sphere
from tracer.errors import SettingsError
from tracer.viewpoint import measures
from tracer.viewpoint.atom_files import Atoms
from tracer.viewpoint.channel import new_channel
from tracer.viewpoint.cover import cover, divergence_of
from tracer.viewpoint.fast import estimate_entropy
from tracer.viewpoint.item_buffer import Rays, around, projected_areas
from tracer.viewpoint.lens import Perspective
from tracer.viewpoint.molecules import open_molecule
from tracer.viewpoint.observation import sight_of
from tracer.viewpoint.surfaces import open_subject
from tracer.viewpoint.survey import survey
from tracer.viewpoint.weights import weighted, weights_from_text, with_weights

DIRECTIONS, TRIANGLES = sphere.icosphere(1)
LENS, RAYS = Perspective(19), Rays(side=64)


@pytest.fixture(scope="module")
def subject():
    """Return three boxes, each one surface."""
    turn = mi.ScalarTransform4f
    parts = {
        "cube": {"type": "cube", "to_world": turn().rotate([1, 2, 3], 20).scale(0.5)},
        "rod_1": {"type": "cube", "to_world": turn().translate([0.9, 0.2, 0.4]).scale([0.1, 0.2, 0.9])},
        "rod_2": {"type": "cube", "to_world": turn().translate([-0.9, 0.3, -0.4]).scale([0.3, 0.1, 0.2])},
    }
    return open_subject(mi.load_dict({"type": "scene", **parts}), "shape")


def views_of(subject):
    return around(subject.centre, 6 * subject.radius, DIRECTIONS)


def areas_of(subject):
    return np.concatenate([batch.areas for batch in projected_areas(subject, views_of(subject), LENS, RAYS)]).astype(
        float
    )


@pytest.mark.parametrize("of_cube", [1.0, 0.0])
def test_measures_with_weights_by_brute_force(subject, of_cube):
    heavy = weighted(subject, {"cube": of_cube, "rod_*": 3.0, "rod_2": 0.5})
    assert dict(zip(heavy.names, heavy.weights, strict=True)) == {"cube": of_cube, "rod_1": 3, "rod_2": 0.5}
    areas, w = areas_of(subject), heavy.weights
    names = ["visible", "projected_area", "viewpoint_complexity", "visibility_ratio", "entropy", "kullback_leibler"]
    names += ["mutual_information", "information_2", "information_3"]
    found = survey(heavy, views_of(subject), LENS, RAYS, names, background=False)

    def counted(view_areas):
        """Return the shares of the view's surfaces that count."""
        return np.where(w > 0, view_areas, 0) / view_areas[w > 0].sum()

    sums = areas.sum(axis=0)
    channel = new_channel(3)
    channel.add(areas.astype(np.float32))
    for k, view_areas in enumerate(areas):
        seen = view_areas > 0
        assert seen[w > 0].any()
        p = view_areas[seen] / view_areas.sum()
        assert found["visible"][k] == pytest.approx(w[seen].sum())
        covered = (w * view_areas).sum() / LENS.image_area
        assert found["projected_area"][k] == pytest.approx(covered)
        assert found["viewpoint_complexity"][k] == pytest.approx(w[seen].sum() / w.sum() + covered)
        true = subject.areas * w
        assert found["visibility_ratio"][k] == pytest.approx(true[seen].sum() / true.sum())
        assert found["entropy"][k] == pytest.approx(-np.sum(w[seen] * p * np.log2(p)))
        for name, expected in (("kullback_leibler", true), ("mutual_information", sums * w)):
            shares, q = counted(view_areas), expected / expected.sum()
            terms = [s * np.log2(s / q[z]) for z, s in enumerate(shares) if s > 0]
            assert sum(terms) >= 0
            assert found[name][k] == pytest.approx(sum(terms), abs=1e-9)
        of_all = sums / sums.sum()
        difference = -np.sum(w * of_all * np.log2(of_all)) - found["entropy"][k]
        assert found["information_2"][k] == pytest.approx(difference)
        told = channel.view_entropy - channel.entropy_of_views[seen]
        assert found["information_3"][k] == pytest.approx(np.sum(w[seen] * p * told), rel=1e-5, abs=1e-7)


DIVERGENCES = ("kullback_leibler", "mutual_information", "salient_mutual_information")
LEAST_IS_GOOD = (*DIVERGENCES, "information_2", "instability")


def sight_with(subject, areas):
    """Return a view of surfaces with these areas, beside a channel in which all are seen alike."""
    channel = new_channel(len(areas), np.array([[0, 1], [1, 2]]))
    channel.add(np.array([[1.0, 2, 3], [3.0, 2, 1]]))
    return replace(sight_of(subject, np.array(areas), 1.0), channel=channel)


def test_a_view_full_of_what_does_not_count_is_no_good_view(subject):
    """It is as good as it would be if what does not count were not there."""
    subject = replace(subject, areas=np.ones(3), weights=np.array([0.0, 1, 1]))
    full, free = sight_with(subject, [0.9, 0.05, 0.05]), sight_with(subject, [0.0, 0.6, 0.4])
    alone, nothing = sight_with(subject, [0.0, 0.05, 0.05]), sight_with(subject, [0.9, 0.0, 0.0])
    for name in DIVERGENCES:
        value = measures.get(name).value
        assert value(full) == pytest.approx(value(alone), abs=1e-12)
    assert measures.get("kullback_leibler").value(free) == pytest.approx(1 + 0.6 * np.log2(0.6) + 0.4 * np.log2(0.4))
    for name in LEAST_IS_GOOD:
        value = measures.get(name).value
        assert value(nothing) >= max(value(full), value(free))
        assert value(nothing) == (1 if name == "instability" else np.inf)


def test_the_areas_of_a_set_diverge_as_if_what_does_not_count_were_not_there():
    expected = np.array([0.0, 3, 1])
    assert divergence_of(np.array([9.0, 3, 1]), expected) == pytest.approx(0, abs=1e-12)
    assert divergence_of(np.array([9.0, 1, 1]), expected) == pytest.approx(0.5 * np.log2(2 / 3) + 0.5 * np.log2(2))
    assert divergence_of(np.array([0.0, 0, 1]), expected) == pytest.approx(2)
    assert divergence_of(np.array([9.0, 0, 0]), expected) == np.inf


def test_all_weights_1_change_nothing_and_all_2_double_entropy(subject):
    names = [name for name in measures.names() if not {"picture", "vertices"} & set(measures.get(name).needs)]
    beside = sphere.neighbours(TRIANGLES)
    plain, double = (
        survey(with_weights(subject, weight * subject.weights), views_of(subject), LENS, RAYS, names, beside=beside)
        for weight in (1.0, 2.0)
    )
    same = survey(subject, views_of(subject), LENS, RAYS, names, beside=beside)
    for name in names:
        assert np.array_equal(plain[name], same[name])
    for name in ("kullback_leibler", "mutual_information", "visibility_ratio", "instability"):
        assert double[name] == pytest.approx(same[name])
    assert double["visible"] == pytest.approx(2 * same["visible"])


def test_a_surface_of_weight_0_hides_and_does_not_count():
    plate = {"type": "rectangle", "to_world": mi.ScalarTransform4f().translate([0, 0, 1]).scale(2)}
    scene = mi.load_dict({"type": "scene", "ball": {"type": "sphere"}, "plate": plate})
    subject = weighted(open_subject(scene, "shape"), {"plate": 0})
    views = around(subject.centre, 20.0, np.array([[0.0, 0, 1], [0, 0, -1]]))
    found = survey(subject, views, LENS, RAYS, ["visible", "entropy", "projected_area"])
    assert found["visible"].tolist() == [0, 1]
    assert found["projected_area"][0] == 0
    assert found["projected_area"][1] > 0


def test_a_view_set_need_not_show_what_does_not_count(subject):
    only = weighted(subject, {"*": 0, "rod_1": 1})
    chosen = cover(only, views_of(subject), LENS, RAYS, quality=0.9)
    assert len(chosen.chosen) == 1
    assert chosen.covered[-1] == pytest.approx(1)
    areas = areas_of(subject)[:, only.names.index("rod_1")]
    assert areas[chosen.chosen[0]] >= 0.9 * areas.max()


def test_faces_have_the_names_of_their_shapes():
    parts = {"one": {"type": "cube"}, "two": {"type": "sphere", "center": [3, 0, 0]}}
    subject = weighted(open_subject(mi.load_dict({"type": "scene", **parts})), {"two": 7})
    assert sorted(subject.weights.tolist()) == [1] * 12 + [7]


def furniture():
    """Return a scene of a lamp and two chairs, one of which is of the material of the lamp."""
    turn = mi.ScalarTransform4f().translate
    white = {"type": "diffuse", "id": "white"}
    parts = {
        "lamp_1": {"type": "sphere", "bsdf": {"type": "ref", "id": "white"}},
        "lamp_2": {"type": "cube", "to_world": turn([9, 0, 0]), "bsdf": {"type": "diffuse", "id": "brass"}},
        "chair_1": {"type": "cube", "to_world": turn([3, 0, 0]), "bsdf": {"type": "ref", "id": "white"}},
        "chair_2": {"type": "cube", "to_world": turn([6, 0, 0]), "bsdf": {"type": "diffuse", "id": "oak"}},
    }
    return mi.load_dict({"type": "scene", "white": white, **parts}, optimize=False)


def weights_by(subject, pattern):
    """Return the weights of the surfaces, sorted, after those that a pattern names have the weight 5."""
    return sorted(weighted(subject, {pattern: 5}).weights.tolist())


def test_shapes_are_weighed_by_name_whatever_the_surfaces_are():
    scene = furniture()
    assert weights_by(open_subject(scene, "face"), "lamp*") == [1] * 24 + [5] * 13
    assert weights_by(open_subject(scene, "face", patterns=["chair*"]), "lamp*") == [1] + [5] * 13
    assert weights_by(open_subject(scene, "face", patterns=["chair*"]), "chair_?") == [1] * 13 + [5]
    assert weights_by(open_subject(scene, "shape", patterns=["lamp*"]), "chair_1") == [1, 1, 5]
    assert weights_by(open_subject(scene, "bsdf"), "chair_2") == [1, 1, 5]
    assert weights_by(open_subject(scene, "bsdf"), "oak") == [1, 1, 5]
    assert weights_by(open_subject(scene, "bsdf"), "*") == [5, 5, 5]
    assert weights_by(open_subject(scene, "bsdf").with_sides(), "chair_2") == [1, 1, 1, 1, 5, 5]


def test_faces_of_an_attribute_are_weighed_by_their_shape():
    mesh = mi.Mesh("plate", 3, 1)
    parameters = mi.traverse(mesh)
    parameters["vertex_positions"] = np.array([0, 0, 0, 1, 0, 0, 0, 1, 0], np.float32)
    parameters["faces"] = np.array([0, 1, 2], np.uint32)
    parameters.update()
    mesh.add_attribute("face_part", 1, [4.0])
    scene = mi.load_dict({"type": "scene", "plate": mesh, "lamp": {"type": "sphere"}})
    subject = weighted(open_subject(scene, "face_part"), {"lamp": 7})
    assert dict(zip(subject.names, subject.weights, strict=True)) == {"face_part 4": 1, "without": 7}


def test_a_part_of_a_surface_is_not_weighed():
    with pytest.raises(SettingsError, match="'lamp\\*' matches some of the shapes of the surface 'white'"):
        weighted(open_subject(furniture(), "bsdf"), {"lamp*": 5})
    with pytest.raises(SettingsError, match="Nothing is called 'balls'"):
        weighted(open_molecule(Atoms(["C", "O"], np.array([[0.0, 0, 0], [1, 0, 0]]))), {"balls": 2})


def test_weights_are_read_from_text():
    assert weights_from_text(["lamp*=5", "a=b=0"]) == {"lamp*": 5, "a=b": 0}
    for wrong in ("lamp", "=3", "lamp=", "lamp=-1", "lamp=nan", "lamp=1e9"):
        with pytest.raises(SettingsError, match="A weight is a name"):
            weights_from_text([wrong])


def test_what_cannot_be_weighed_is_said(subject):
    heavy = weighted(subject, {"cube": 2})
    for name in ("maximum_depth", "silhouette_length", "curvature_entropy"):
        with pytest.raises(SettingsError, match="do not tell surfaces apart"):
            survey(heavy, views_of(subject), LENS, RAYS, [name])
    with pytest.raises(SettingsError, match="leave out --random"):
        estimate_entropy(heavy, views_of(subject), LENS, 100)
    with pytest.raises(SettingsError, match="Nothing is called 'rod', did you mean"):
        weighted(subject, {"rod": 2})
    with pytest.raises(SettingsError, match=r"Nothing is called 'z'; there are cube, rod_1, rod_2\."):
        weighted(subject, {"z": 2})
    with pytest.raises(SettingsError, match="all weights are 0"):
        weighted(subject, {"*": 0})
    assert not replace(subject, weights=np.ones(3)).is_weighted

"""Light gathered anew, against Lambert's closed form, wherever a guide sends the rays."""

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest

from tracer.radiosity.final_gather import FinalGather, carried
from tracer.radiosity.gathering import solve
from tracer.radiosity.groups import neighbours
from tracer.radiosity.guide import Guidance, make_guide
from tracer.radiosity.hemisphere import Division
from tracer.radiosity.meshing import cut
from tracer.radiosity.patches import by_face
from tracer.radiosity.warp import Warp

from .scenery import form_factor

T = mi.ScalarTransform4f
PLACE = np.array([0.21, 0.13, 0.0])
COUNT = 1 << 17


@pytest.fixture(scope="module")
def lit():
    """A grey floor below a large lamp that reflects nothing and stands to one side."""
    grey, black = ({"type": "diffuse", "reflectance": {"type": "rgb", "value": value}} for value in (0.5, 0.0))
    emitter = {"type": "area", "radiance": {"type": "rgb", "value": 3.0}}
    over = T().translate([0.8, 0, 0.6]).rotate([1, 0, 0], 180).scale(0.5)
    lamp = {"type": "rectangle", "to_world": over, "bsdf": black, "emitter": emitter}
    return mi.load_dict({"type": "scene", "floor": {"type": "rectangle", "bsdf": grey}, "lamp": lamp})


@pytest.mark.parametrize("floor", [None, 0.5, 0.1])
def test_lamps_are_weighed_by_the_density_of_the_rays_that_hit_them(lit, floor):
    """``floor``: the share of rays that the guide leaves to the cosine; None goes without a guide."""
    patches = cut(lit, 0.25)
    warp = None
    if floor is not None:
        guidance = Guidance(members=64, worth=0, overall=0, floor=floor)
        see, groups = patches.see(patches.emitted), neighbours(patches.points, 64)
        guide = make_guide(see, groups, Division("deviation", 0.6, 2, 64), guidance, len(patches), 1)
        assert guide.guided.all()
        warp = Warp(guide)
    gather = FinalGather(lit, patches, patches.emitted, warp)
    sampler = mi.load_dict({"type": "independent"})
    sampler.seed(3, COUNT)
    ray = mi.Ray3f(
        mi.Point3f(*PLACE.tolist()) + mi.Vector3f(0, 0, 0.3), dr.zeros(mi.Vector3f, COUNT) - mi.Vector3f(0, 0, 1)
    )
    radiance, hit = gather.radiance(lit, ray, sampler, True)
    found = np.array(radiance)[0].astype(np.float64)
    assert hit.numpy().all()
    corners = np.array([[0.3, -0.5, 0.6], [1.3, -0.5, 0.6], [1.3, 0.5, 0.6], [0.3, 0.5, 0.6]])
    expected = 0.5 * 3.0 * form_factor(PLACE, np.array([0.0, 0, 1]), corners)
    stderr = found.std() / np.sqrt(COUNT)
    assert stderr < 2e-3 * expected
    # Three comparisons at 4.5 standard errors: false alarms below 1 in 40,000.
    assert abs(found.mean() - expected) < 4.5 * stderr


def test_lights_behind_a_surface_bring_nothing(lit):
    patches = cut(lit, 0.5)
    gather = FinalGather(lit, patches, patches.emitted, None)
    ray = mi.Ray3f(
        mi.Point3f(*PLACE.tolist()) + mi.Vector3f(0, 0, 0.3), dr.zeros(mi.Vector3f, 64) - mi.Vector3f(0, 0, 1)
    )
    found, sample = lit.ray_intersect(ray), mi.Point2f(np.random.default_rng(1).random((2, 64)).astype(np.float32))
    brought = {
        side: np.array(gather.from_lights(lit, found, mi.UInt32(0), mi.Vector3f(0, 0, side), sample, mi.Bool(True)))
        for side in (1, -1)
    }
    assert (brought[1] > 0).all()
    assert not brought[-1].any()


@pytest.fixture(scope="module")
def room():
    """A Cornell box that is solved, with a lamp that shines at the ceiling: what is seen is lit by a bright part."""
    parts = mi.cornell_box()
    parts["light"]["to_world"] = T().translate([0.3, 0.85, 0.2]).rotate([1, 0, 0], -90).scale(0.15)
    scene = mi.load_dict(parts)
    patches = cut(scene, 0.2)
    return scene, patches, solve(patches, 64, 1e-4, lights=True).radiosity


@pytest.mark.parametrize("place", [(-0.5, 0.5), (0.7, 0.8), (0.45, 0.05)])
@pytest.mark.parametrize("floor", [None, 0.5, 0.1])
def test_gathers_with_a_warp_and_weights_agree_with_plain_cosine_samples(room, place, floor):
    """The brute force sees patches and the lamp along 4 million rays distributed as the cosine."""
    scene, patches, radiosity = room
    warp = None
    if floor is not None:
        guidance = Guidance(members=64, worth=0, overall=0, floor=floor)
        see = by_face(patches, carried(patches, radiosity))
        groups = neighbours(patches.points, 64)
        warp = Warp(make_guide(see, groups, Division("deviation", 0.3, 2, 64), guidance, patches.faces, 1))
    above = mi.Point3f(place[0], -0.8, place[1])
    sampler = mi.load_dict({"type": "independent"})
    sampler.seed(5, COUNT)
    ray = mi.Ray3f(above + dr.zeros(mi.Point3f, COUNT), dr.zeros(mi.Vector3f, COUNT) - mi.Vector3f(0, 1, 0))
    radiance, _ = FinalGather(scene, patches, radiosity, warp).radiance(scene, ray, sampler, True)
    found = np.array(radiance).astype(np.float64)

    surface = scene.ray_intersect(mi.Ray3f(above, mi.Vector3f(0, -1, 0)))
    numbers = np.random.default_rng(6).random((2, 1 << 22)).astype(np.float32)
    local = mi.warp.square_to_cosine_hemisphere(mi.Point2f(numbers))
    toward = mi.Frame3f(mi.Vector3f(0, 1, 0)).to_world(local)
    seen = np.array(patches.see(radiosity)(surface.spawn_ray(toward))[1]).astype(np.float64)
    reflectance = np.array(surface.bsdf().eval_diffuse_reflectance(surface), np.float64).reshape(3, 1)
    expected = reflectance * seen
    stderr = np.hypot(*(values.std(axis=1) / np.sqrt(values.shape[1]) for values in (found, expected)))
    assert (stderr < 0.03 * expected.mean(axis=1)).all()
    # 27 comparisons at 4.5 standard errors: false alarms below 1 in 5,000.
    assert (np.abs(found.mean(axis=1) - expected.mean(axis=1)) < 4.5 * stderr).all()

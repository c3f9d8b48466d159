"""Light gathered anew at a place that is seen: what patches reflect along one ray, and lights in two ways.

Light straight from emitters is found by the ray that gathers and by a place chosen on a light, each weighted by its
density over both (the balance heuristic: E. Veach and L. Guibas, SIGGRAPH 1995). What patches reflect is found by the
ray alone, which goes as the cosine does or where a group of patches saw radiance vary.
"""

from __future__ import annotations

from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from tracer.core.arrays import Floats
from tracer.radiosity.albedo import not_diffuse
from tracer.radiosity.hemisphere import NOTHING, See
from tracer.radiosity.patches import Patches, look_up, on_device
from tracer.radiosity.tessellate import sagitta
from tracer.radiosity.warp import Warp

MIDDLING = 0.5 / np.pi
"""Density of a ray that leaves as the cosine does, at 60 degrees."""


class FinalGather:
    """Radiance of places, from the radiosity of patches."""

    def __init__(self, scene: Any, patches: Patches, radiosity: Floats, warp: Warp | None) -> None:
        self.patches = patches
        self.warp = warp
        self.reach = mi.Float(2 * sagitta(scene) + patches.points.outside)
        self.reflected = on_device((radiosity - patches.emitted) / np.pi)
        self.albedo = on_device(patches.albedo)

    def radiance(self, scene: Any, ray: Any, sampler: Any, active: Any) -> tuple[Any, Any]:
        """Return the radiance (mi.Color3f) along rays of a scene, and whether they hit anything."""
        first = scene.ray_intersect_preliminary(ray, active=active)
        found = first.compute_surface_interaction(ray, mi.RayFlags.All, active)
        hit = found.is_valid()
        emitted = mi.Color3f(found.emitter(scene, active).eval(found, active))
        patch = self.patch(scene, first, found, ray)
        # On the side that is seen, if that side reflects at all.
        front = found.wi.z > 0
        lit = hit & (front | mi.has_flag(found.bsdf().flags(), mi.BSDFFlags.BackSide))
        normal = mi.Vector3f(dr.select(front, 1, -1) * found.sh_frame.n)
        gathered = self.gathered(scene, found, patch, normal, sampler.next_2d(active), lit)
        direct = self.from_lights(scene, found, patch, normal, sampler.next_2d(active), lit)
        return emitted + dr.select(lit, self.reflectance(found, patch, lit) * (gathered + direct), 0), hit & active

    def patch(self, scene: Any, hit: Any, found: Any, ray: Any) -> Any:
        """Return the patch (mi.UInt32) at places that rays hit.

        Where spheres became meshes it is looked for from above the place, as far as their triangles may be from it.
        """
        if self.patches.scene is scene:
            return self.patches.at(hit, ray)
        above = mi.Vector3f(dr.select(dr.dot(found.n, ray.d) < 0, found.n, -found.n))
        start = mi.Point3f(found.p + above * self.reach)
        down = mi.Ray3f(start, -above)
        down.maxt = 3 * self.reach
        patch = self.patches.find(down)
        return dr.select(hit.is_valid(), patch, NOTHING)

    def reflectance(self, found: Any, patch: Any, active: Any) -> Any:
        """Return the reflectance (mi.Color3f) at hits: of the place if diffuse, else the albedo of the patch."""
        own = mi.Color3f(found.bsdf().eval_diffuse_reflectance(found, active))
        return dr.select(not_diffuse(found.bsdf()), look_up(self.albedo, patch), own)

    def gathered(self, scene: Any, found: Any, patch: Any, normal: Any, place: Any, active: Any) -> Any:
        """Return what one ray brings (mi.Color3f), over the cosine's density."""
        if self.warp is None:
            toward = mi.Frame3f(normal).to_world(mi.warp.square_to_cosine_hemisphere(place))
            density = mi.Float(1)
        else:
            group = self.warp.groups.group(dr.select(patch == NOTHING, 0, patch))
            place, density = self.warp.warp(group, place.x, place.y)
            toward = self.warp.groups.to_world(group, normal, mi.warp.square_to_cosine_hemisphere(place))
        ray = found.spawn_ray(toward)
        second = scene.ray_intersect_preliminary(ray, active=active)
        there = second.compute_surface_interaction(ray, mi.RayFlags.All, active)
        emitter = there.emitter(scene, active)
        shines = active & (emitter != None)  # noqa: E711
        by_light = scene.pdf_emitter_direction(found, mi.DirectionSample3f(scene, there, found), shines)
        by_ray = density * dr.dot(toward, normal) / dr.pi
        emitted = dr.select(shines, mi.Color3f(emitter.eval(there, shines)) * share(by_ray, by_light), 0)
        return (look_up(self.reflected, self.patch(scene, second, there, ray)) + emitted) / density

    def from_lights(self, scene: Any, found: Any, patch: Any, normal: Any, sample: Any, active: Any) -> Any:
        """Return what one place on a light brings (mi.Color3f), over pi."""
        direction, weight = scene.sample_emitter_direction(found, sample, True, active)
        cosine = dr.dot(direction.d, normal)
        useful = active & (direction.pdf > 0) & (cosine > 0)
        density = mi.Float(1)
        if self.warp is not None:
            group = self.warp.groups.group(dr.select(patch == NOTHING, 0, patch))
            density = self.warp.density_of(group, self.warp.groups.to_local(group, normal, direction.d))
        by_light = dr.select(direction.delta, 1, share(direction.pdf, density * cosine / dr.pi))
        return dr.select(useful, mi.Color3f(weight) * (cosine / dr.pi * by_light), 0)


def carried(patches: Patches, radiosity: Floats) -> See:
    """Return what rays that gather bring, for a look: what patches reflect, and of lights what is not left to a place
    on them."""
    scene, reflected = patches.scene, on_device((radiosity - patches.emitted) / np.pi)

    def see(ray: Any) -> tuple[Any, Any]:
        found = scene.ray_intersect_preliminary(ray)
        there = found.compute_surface_interaction(ray, mi.RayFlags.All, True)
        patch = patches.at(found, ray)
        emitter = there.emitter(scene, True)
        shines = emitter != None  # noqa: E711
        here = dr.zeros(mi.Interaction3f, dr.width(ray))
        here.p = ray.o
        by_light = scene.pdf_emitter_direction(here, mi.DirectionSample3f(scene, there, here), shines)
        emitted = dr.select(shines, mi.Color3f(emitter.eval(there, shines)) * share(MIDDLING, by_light), 0)
        return patch, look_up(reflected, patch) + emitted

    return see


def share(own: Any, other: Any) -> Any:
    """Return the balance heuristic of two densities."""
    return own / dr.maximum(own + other, 1e-20)

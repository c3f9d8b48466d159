"""Light gathered anew at each place that is seen, from what patches reflect and from lights.

Light straight from emitters is sampled in two ways, by the gathering ray and by a place chosen on a light. Each is
weighted by its density over the sum of both (the balance heuristic: E. Veach and L. Guibas, SIGGRAPH 1995). What
patches reflect is sampled by the gathering ray alone. This ray is distributed as the cosine, or more densely where a
group of patches saw radiance vary.
"""

from __future__ import annotations

from dataclasses import dataclass
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
"""Density per steradian of rays distributed as the cosine, 60 degrees from the normal; ``carried`` uses it for all."""


@dataclass(frozen=True)
class Seen:
    """What rays hit."""

    surface: Any
    """mi.SurfaceInteraction3f."""
    patch: Any
    """mi.UInt32; NOTHING where no patch is."""
    normal: Any
    """mi.Vector3f: shading normal on the side that is seen."""
    lit: Any
    """mi.Bool: whether the side that is seen can reflect light."""


class FinalGather:
    """Radiance of places that are seen, gathered from the radiosity of patches."""

    def __init__(self, scene: Any, patches: Patches, radiosity: Floats, warp: Warp | None) -> None:
        self.patches = patches
        self.warp = warp
        self.reach = mi.Float(2 * sagitta(scene) + patches.points.outside)
        self.reflected = on_device((radiosity - patches.emitted) / np.pi)
        self.albedo = on_device(patches.albedo)

    def radiance(self, scene: Any, ray: Any, sampler: Any, active: Any) -> tuple[Any, Any]:
        """Return the radiance (mi.Color3f) along rays of a scene, and whether they hit anything."""
        seen = self.seen(scene, ray, active)
        emitted = mi.Color3f(seen.surface.emitter(scene, active).eval(seen.surface, active))
        arriving = self.arriving(scene, seen, sampler, active)
        reflected = self.reflectance(seen.surface, seen.patch, seen.lit) * arriving
        return emitted + dr.select(seen.lit, reflected, 0), seen.surface.is_valid() & active

    def irradiance(self, scene: Any, ray: Any, sampler: Any, active: Any) -> tuple[Any, Any]:
        """Return the irradiance (mi.Color3f) of what rays hit, on the side that is seen, and whether they hit anything.

        It is 0 on a back that reflects nothing, which is no patch.
        """
        seen = self.seen(scene, ray, active)
        arriving = self.arriving(scene, seen, sampler, active)
        return dr.select(seen.lit, dr.pi * arriving, 0), seen.surface.is_valid() & active

    def seen(self, scene: Any, ray: Any, active: Any) -> Seen:
        """Return what rays of a scene hit."""
        intersection = scene.ray_intersect_preliminary(ray, active=active)
        surface = intersection.compute_surface_interaction(ray, mi.RayFlags.All, active)
        patch = self.patch(scene, intersection, surface, ray)
        # Light is gathered on the side that is seen, if this side reflects at all.
        front = surface.wi.z > 0
        lit = surface.is_valid() & (front | mi.has_flag(surface.bsdf().flags(), mi.BSDFFlags.BackSide))
        return Seen(surface, patch, mi.Vector3f(dr.select(front, 1, -1) * surface.sh_frame.n), lit)

    def arriving(self, scene: Any, seen: Seen, sampler: Any, active: Any) -> Any:
        """Return an estimate of the irradiance over pi (mi.Color3f) of what is seen, from one ray and one light."""
        gathered = self.gathered(scene, seen.surface, seen.patch, seen.normal, sampler.next_2d(active), seen.lit)
        direct = self.from_lights(scene, seen.surface, seen.patch, seen.normal, sampler.next_2d(active), seen.lit)
        return gathered + direct

    def patch(self, scene: Any, intersection: Any, surface: Any, ray: Any) -> Any:
        """Return the patch (mi.UInt32) at places that rays hit.

        Where patches come from meshes that replace spheres and the like, a second ray looks for the patch: it starts
        above the place, and reaches as far as the triangles of the mesh may be from it.
        """
        if self.patches.scene is scene:
            return self.patches.at(intersection, ray)
        above = mi.Vector3f(dr.select(dr.dot(surface.n, ray.d) < 0, surface.n, -surface.n))
        start = mi.Point3f(surface.p + above * self.reach)
        down = mi.Ray3f(start, -above)
        down.maxt = 3 * self.reach
        patch = self.patches.find(down)
        return dr.select(intersection.is_valid(), patch, NOTHING)

    def reflectance(self, surface: Any, patch: Any, active: Any) -> Any:
        """Return the reflectance (mi.Color3f) at hits: of the place if it is diffuse, else the albedo of the patch."""
        diffuse = mi.Color3f(surface.bsdf().eval_diffuse_reflectance(surface, active))
        return dr.select(not_diffuse(surface.bsdf()), look_up(self.albedo, patch), diffuse)

    def gathered(self, scene: Any, surface: Any, patch: Any, normal: Any, sample: Any, active: Any) -> Any:
        """Return what one gathering ray contributes: its irradiance over pi (mi.Color3f)."""
        if self.warp is None:
            toward = mi.Frame3f(normal).to_world(mi.warp.square_to_cosine_hemisphere(sample))
            density = mi.Float(1)
        else:
            group = self.warp.groups.group(dr.select(patch == NOTHING, 0, patch))
            sample, density = self.warp.warp(group, sample.x, sample.y)
            toward = self.warp.groups.to_world(group, normal, mi.warp.square_to_cosine_hemisphere(sample))
        ray = surface.spawn_ray(toward)
        intersection = scene.ray_intersect_preliminary(ray, active=active)
        far_surface = intersection.compute_surface_interaction(ray, mi.RayFlags.All, active)
        emitter = far_surface.emitter(scene, active)
        shines = active & (emitter != None)  # noqa: E711
        by_light = scene.pdf_emitter_direction(surface, mi.DirectionSample3f(scene, far_surface, surface), shines)
        by_ray = density * dr.dot(toward, normal) / dr.pi
        emitted = dr.select(shines, mi.Color3f(emitter.eval(far_surface, shines)) * share(by_ray, by_light), 0)
        return (look_up(self.reflected, self.patch(scene, intersection, far_surface, ray)) + emitted) / density

    def from_lights(self, scene: Any, surface: Any, patch: Any, normal: Any, sample: Any, active: Any) -> Any:
        """Return what one place on a light contributes: its irradiance over pi (mi.Color3f)."""
        direction, weight = scene.sample_emitter_direction(surface, sample, True, active)
        cosine = dr.dot(direction.d, normal)
        useful = active & (direction.pdf > 0) & (cosine > 0)
        density = mi.Float(1)
        if self.warp is not None:
            group = self.warp.groups.group(dr.select(patch == NOTHING, 0, patch))
            density = self.warp.density_of(group, self.warp.groups.to_local(group, normal, direction.d))
        by_light = dr.select(direction.delta, 1, share(direction.pdf, density * cosine / dr.pi))
        return dr.select(useful, mi.Color3f(weight) * (cosine / dr.pi * by_light), 0)


def carried(patches: Patches, radiosity: Floats) -> See:
    """Return how rays see what gathering rays bring, from which a guide is made.

    Gathering rays bring the light that patches reflect, and the share of the light of emitters that is not left to
    places chosen on the emitters.
    """
    scene, reflected = patches.scene, on_device((radiosity - patches.emitted) / np.pi)

    def see(ray: Any) -> tuple[Any, Any]:
        intersection = scene.ray_intersect_preliminary(ray)
        surface = intersection.compute_surface_interaction(ray, mi.RayFlags.All, True)
        patch = patches.at(intersection, ray)
        emitter = surface.emitter(scene, True)
        shines = emitter != None  # noqa: E711
        origin = dr.zeros(mi.Interaction3f, dr.width(ray))
        origin.p = ray.o
        by_light = scene.pdf_emitter_direction(origin, mi.DirectionSample3f(scene, surface, origin), shines)
        emitted = dr.select(shines, mi.Color3f(emitter.eval(surface, shines)) * share(MIDDLING, by_light), 0)
        return patch, look_up(reflected, patch) + emitted

    return see


def share(density: Any, other_density: Any) -> Any:
    """Return the weight that the balance heuristic gives to the first of two densities."""
    return density / dr.maximum(density + other_density, 1e-20)

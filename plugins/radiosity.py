"""Integrator ``radiosity``: shows the radiosity of a scene of diffuse meshes, which it solves when it is first asked.

The scene is cut into patches, each of which gathers light along rays that are traced once, until nothing changes any
more. What is seen is the radiosity of the patch (``final_gather`` off), or light gathered anew at every place that a
camera ray hits, of which patches are seen only in the second place: textures and shadows are sharp then.

.. pluginparameters::

 * - size
   - |float|
   - Longest edge of a patch, in units of the scene. (Default: a 40th of the scene's largest extent)
 * - rays
   - |int|
   - Rays that every patch gathers with. (Default: 256)
 * - residual
   - |float|
   - Share of the power that the last round may have changed. (Default: 1e-5)
 * - final_gather
   - |bool|
   - Whether light is gathered at every place that is seen. (Default: true)
 * - guided
   - |bool|
   - Whether rays go where what a patch sees varies, instead of evenly. (Default: true)
 * - seed
   - |int|
   - Of the rays of patches. (Default: 0)

.. tabs::
    .. code-tab:: xml

        <integrator type="radiosity"><float name="size" value="0.1"/></integrator>

    .. code-tab:: python

        {'type': 'radiosity', 'size': 0.1}
"""

from __future__ import annotations

from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from tracer.errors import SettingsError
from tracer.radiosity.cut import cut
from tracer.radiosity.direct import direct_light
from tracer.radiosity.groups import neighbours
from tracer.radiosity.guide import Guidance, make_guide
from tracer.radiosity.hemisphere import NOTHING, Division, See
from tracer.radiosity.patches import Patches
from tracer.radiosity.solve import Solution, Told, solve
from tracer.radiosity.warp import Warp

EXTENT = 40
"""Patches along the scene's largest extent, unless a size is given."""
GUIDANCE = Guidance()
DIVISION = Division(GUIDANCE.kind, GUIDANCE.threshold, depth=2, rays=256, widest=0.5)
"""28 rays a patch, at most."""


class RadiosityIntegrator(mi.SamplingIntegrator):
    """See the documentation of this file."""

    def __init__(self, props: mi.Properties) -> None:
        super().__init__(props)
        self.size = float(props.get("size", 0.0))
        self.rays = int(props.get("rays", 256))
        self.residual = float(props.get("residual", 1e-5))
        self.final_gather = bool(props.get("final_gather", True))
        self.guided = bool(props.get("guided", True))
        self.seed = int(props.get("seed", 0))
        if not 0 <= self.size < float("inf") or not 0 < self.residual < 1 or not 1 <= self.rays <= 1 << 20:
            raise SettingsError("radiosity: size must be positive, residual in (0, 1), rays from 1 to 2^20.")
        self.patches: Patches | None = None
        self.solution: Solution | None = None
        self.see: See
        self.warp: Warp | None = None

    def solve_for(self, scene: mi.Scene, told: Told = lambda text, done, total: None) -> None:
        """Cut and solve ``scene`` unless that is done. ``told`` hears of progress, and may raise to stop."""
        if self.patches is not None and self.patches.scene is scene:
            return
        box = scene.bbox()
        extent = float(np.max(np.array(box.max, np.float64) - np.array(box.min, np.float64)))
        patches = cut(scene, self.size or extent / EXTENT)
        if patches.not_diffuse:
            names = ", ".join(patches.not_diffuse)
            mi.Log(mi.LogLevel.Warn, f"radiosity: not diffuse, and taken by the diffuse part alone: {names}")
        guidance = GUIDANCE if self.guided else None
        self.solution = solve(patches, self.rays, self.residual, self.seed, True, guidance, told)
        reflected = self.solution.radiosity - patches.emitted
        if not self.final_gather:
            self.see = patches.see(reflected + patches.emitted)
        else:
            self.see = patches.see(reflected, surroundings=False)
            if guidance is not None:
                told("looks", 0, 1)
                groups = neighbours(patches.points, guidance.members)
                self.warp = Warp(make_guide(self.see, groups, DIVISION, guidance, len(patches), self.seed))
        self.patches = patches

    def render(self, scene: mi.Scene, *arguments: Any, **keywords: Any) -> mi.TensorXf:
        self.solve_for(scene)
        return super().render(scene, *arguments, **keywords)

    def sample(
        self, scene: mi.Scene, sampler: mi.Sampler, ray: Any, medium: Any = None, active: Any = True
    ) -> tuple[Any, Any, list[Any]]:
        self.solve_for(scene)
        plain = mi.Ray3f(ray.o, ray.d)
        if not self.final_gather:
            _, radiance = self.see(plain)
            return radiance, scene.ray_test(plain) & active, []
        assert self.patches is not None
        first = scene.ray_intersect_preliminary(plain, active=active)
        found = first.compute_surface_interaction(plain, mi.RayFlags.All, active)
        hit = found.is_valid()
        light = mi.Color3f(found.emitter(scene, active).eval(found, active))
        reflectance = mi.Color3f(found.bsdf().eval_diffuse_reflectance(found, hit))
        # On the side that is seen, if that side reflects at all.
        front = found.wi.z > 0
        lit = hit & (front | mi.has_flag(found.bsdf().flags(), mi.BSDFFlags.BackSide))
        normal = dr.select(front, 1, -1) * found.sh_frame.n
        toward, density = self.toward(self.patches.at(first, plain), normal, sampler.next_2d(active))
        _, gathered = self.see(found.spawn_ray(toward))
        direct = direct_light(scene, found, normal, sampler.next_2d(active), lit) / dr.pi
        return light + dr.select(lit, reflectance * (gathered / density + direct), 0), hit & active, []

    def toward(self, patch: Any, normal: Any, place: Any) -> tuple[Any, Any]:
        """Return where a gathering ray goes (mi.Vector3f), and its density over that of the cosine (mi.Float)."""
        if self.warp is None:
            return mi.Frame3f(normal).to_world(mi.warp.square_to_cosine_hemisphere(place)), mi.Float(1)
        group = self.warp.groups.group(dr.select(patch == NOTHING, 0, patch))
        place, density = self.warp.warp(group, place.x, place.y)
        return self.warp.groups.to_world(group, normal, mi.warp.square_to_cosine_hemisphere(place)), density

    def to_string(self) -> str:
        return f"RadiosityIntegrator[size={self.size}, rays={self.rays}, final_gather={self.final_gather}]"


mi.register_integrator("radiosity", RadiosityIntegrator)

"""Integrator ``radiosity``: shows the radiosity of a scene of diffuse surfaces, which it solves at the first rendering.

The scene is cut into patches. Patches either gather light, along rays that are traced once, until a round changes
almost nothing, or shoot their light until almost none is left. The picture shows light that is gathered anew at every
place that a camera ray hits, so that patches are seen only indirectly and textures and shadows are sharp. It can also
show the patches themselves, as they are or smoothed. Surfaces that are not diffuse are treated as diffuse surfaces of
the same albedo, and media are left out: warnings name both. A scene is solved once: after the scene has changed, load
the integrator again. ``hide_emitters`` has no effect.

.. pluginparameters::

 * - size
   - |float|
   - Longest edge of a patch, in units of the scene. (Default: a 40th of the scene's largest extent)
 * - rays
   - |int|
   - Rays that every patch gathers with, and as many again to lights; or rays that it shoots, on average. (Default: 256)
 * - residual
   - |float|
   - Largest share of the power that the last round may change, or that may be left to shoot. (Default: 1e-5)
 * - method
   - |string|
   - ``gathering`` or ``shooting``. (Default: gathering)
 * - show
   - |string|
   - What the picture shows: ``gather`` (light gathered anew), ``smooth`` or ``patches``. (Default: gather)
 * - quantity
   - |string|
   - What a pixel holds: ``radiance``, or the ``irradiance`` of what is seen. (Default: radiance)
 * - spread
   - |string|
   - How the rays of a patch are spread: ``guided`` to where the radiance that is seen varies, ``evenly`` in a lattice,
     ``randomly`` as in classical Monte Carlo radiosity, by the rules of the ``paper`` as they are printed, or
     ``paper_right``, with the energies of its rays made right. As they are printed, the result is biased, and a warning
     says by how much energy. (Default: guided for gathering, evenly for shooting)
 * - threshold, depth
   - |float|, |int|
   - For the paper's rules: the number of faces seen above which a part of a hemisphere is split, and how many times it
     may be split, up to 4. (Default: 2.5, 1)
 * - seed
   - |int|
   - Seed of the rays of patches. (Default: 0)

.. tabs::
    .. code-tab:: xml

        <integrator type="radiosity"><float name="size" value="0.1"/></integrator>

    .. code-tab:: python

        {'type': 'radiosity', 'size': 0.1}
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from tracer.core.arrays import Floats
from tracer.errors import SettingsError
from tracer.progress import StepCallback
from tracer.radiosity.direct import silent
from tracer.radiosity.final_gather import FinalGather, carried
from tracer.radiosity.gathering import Solution, solve
from tracer.radiosity.groups import neighbours
from tracer.radiosity.guide import Guidance, make_guide
from tracer.radiosity.hemisphere import Division
from tracer.radiosity.meshing import EXTENT, cut, extent
from tracer.radiosity.patches import Patches, by_face
from tracer.radiosity.remarks import bias_remarks, remarks
from tracer.radiosity.shooting import ShootingSolution, shoot
from tracer.radiosity.smooth import Smooth
from tracer.radiosity.spread import chosen_spread, usual_spread
from tracer.radiosity.warp import Warp

SHOWN = "gather", "smooth", "patches"
"""Values of the parameter ``show``."""
QUANTITIES = ("radiance", "irradiance")
"""Values of the parameter ``quantity``."""
Look = Callable[[Any], Any]
"""From rays (mi.Ray3f) to the radiance (mi.Color3f), or the irradiance, of what they hit."""
DIVISION = Division(Guidance().kind, Guidance().threshold, depth=2, rays=256, widest=0.5)
"""How hemispheres are divided for ``gather``: with 28 rays a patch, and twice as many in the smallest groups."""


class RadiosityIntegrator(mi.SamplingIntegrator):
    """See the documentation of this file."""

    def __init__(self, props: mi.Properties) -> None:
        super().__init__(props)
        self.size = float(props.get("size", 0.0))
        self.rays = int(props.get("rays", 256))
        self.residual = float(props.get("residual", 1e-5))
        self.method = str(props.get("method", "gathering"))
        self.show = str(props.get("show", "gather"))
        self.quantity = str(props.get("quantity", "radiance"))
        self.spread = str(props.get("spread", usual_spread(self.method)))
        threshold = float(props["threshold"]) if "threshold" in props else None
        depth = int(props["depth"]) if "depth" in props else None
        self.seed = int(props.get("seed", 0))
        if not 0 <= self.size < float("inf") or not 0 < self.residual < 1 or not 1 <= self.rays <= 1 << 20:
            raise SettingsError("radiosity: size must be positive or 0, residual in (0, 1), rays from 1 to 2^20.")
        if self.show not in SHOWN:
            raise SettingsError(f"radiosity: show is one of {', '.join(SHOWN)}, not '{self.show}'.")
        if self.quantity not in QUANTITIES:
            raise SettingsError(f"radiosity: quantity is one of {', '.join(QUANTITIES)}, not '{self.quantity}'.")
        self.rules = chosen_spread(self.spread, self.method, threshold, depth)
        self.scene: mi.Scene | None = None
        self.patches: Patches
        self.solution: Solution | ShootingSolution
        self.looks: dict[str, Look]
        self.final: FinalGather

    def prepare_scene(self, scene: mi.Scene, on_step: StepCallback = silent) -> None:
        """Cut and solve ``scene`` unless it is the scene solved last.

        ``on_step`` is called with the progress, and may raise an error to stop.
        """
        if self.scene is scene:
            return
        patches = cut(scene, self.size or extent(scene) / EXTENT)
        for sentence in remarks(scene) if on_step is silent else []:
            mi.Log(mi.LogLevel.Warn, f"radiosity: {sentence}")
        guidance = self.rules if isinstance(self.rules, Guidance) else None
        if self.method == "shooting":
            self.solution = shoot(patches, self.rays, self.residual, self.seed, self.rules, on_step)
        else:
            self.solution = solve(patches, self.rays, self.residual, self.seed, True, self.rules, on_step)
        for sentence in bias_remarks(self.solution.energy, self.rules) if on_step is silent else []:
            mi.Log(mi.LogLevel.Warn, f"radiosity: {sentence}")
        radiosity = self.solution.radiosity
        if self.show == "gather":
            warp = None
            if guidance is not None:
                on_step("looks", 0, 1)
                groups = neighbours(patches.points, guidance.members)
                see = by_face(patches, carried(patches, radiosity))
                guide = make_guide(see, groups, DIVISION, guidance, patches.faces, self.seed)
                warp = Warp(guide) if len(guide.share) else None
            self.final = FinalGather(scene, patches, radiosity, warp)
        else:
            irradiance = self.solution.irradiance
            self.looks = {
                "radiance": look(patches, radiosity, self.show, True),
                "irradiance": look(patches, np.pi * irradiance, self.show, False),
            }
        on_step("ready", 1, 1)
        self.patches, self.scene = patches, scene

    def render(self, scene: mi.Scene, *arguments: Any, **keywords: Any) -> mi.TensorXf:
        self.prepare_scene(scene)
        return super().render(scene, *arguments, **keywords)

    def sample(
        self,
        scene: mi.Scene,
        sampler: mi.Sampler,
        ray: mi.RayDifferential3f,
        medium: mi.Medium | None = None,
        active: mi.Bool | bool = True,
    ) -> tuple[mi.Spectrum, mi.Bool, list[mi.Float]]:
        self.prepare_scene(scene)
        primal_ray = mi.Ray3f(ray.o, ray.d)
        if self.show == "gather":
            draw = self.final.irradiance if self.quantity == "irradiance" else self.final.radiance
            return *draw(scene, primal_ray, sampler, active), []
        return self.looks[self.quantity](primal_ray), scene.ray_test(primal_ray) & active, []

    def to_string(self) -> str:
        return (
            f"RadiosityIntegrator[size={self.size}, rays={self.rays}, method={self.method}, show={self.show}, "
            f"quantity={self.quantity}]"
        )


def look(patches: Patches, radiosity: Floats, show: str, surroundings: bool) -> Look:
    """Return what rays see of a radiosity (P, 3): its radiance, of patches or smoothed.

    ``surroundings``: whether rays that miss see the environment; they see 0 otherwise.
    """
    see = patches.see(radiosity, surroundings)
    smooth = Smooth(patches, radiosity) if show == "smooth" else None

    def seen(ray: Any) -> Any:
        _, radiance = see(ray)
        if smooth is None:
            return radiance
        intersection = patches.scene.ray_intersect_preliminary(ray)
        return dr.select(intersection.is_valid(), smooth.at(intersection, ray), radiance)

    return seen


mi.register_integrator("radiosity", RadiosityIntegrator)

"""Integrator ``guided``: ``path``, which can learn which lights matter where.

Mitsuba's ``path`` sends a shadow ray from every vertex to one of all lights, each with the same chance. Most scenes
have lights that matter from here and not from there: those behind a wall, those far away, the lower half of a sky. This
integrator takes a table that has the chance of every light, and of every part of a large light, for each cell of space.
Where tracer renders it, by itself or nested in ``aov``, the table is learned from a few samples first. Before anything
is learned it is ``path``: the same numbers of the sampler make the same picture. Under plain ``mi.render`` it learns
unless it is nested in another integrator.

A shadow ray is traced only where the light would give something.

.. pluginparameters::

 * - max_depth, rr_depth
   - |int|
   - As for ``path``: longest path, where 1 is directly visible light and -1 is without limit; and the length from which
     paths may end at random. (Default: -1, 5)
 * - hide_emitters
   - |bool|
   - As for ``path``: whether lights are invisible to the camera. (Default: false)

.. tabs::
    .. code-tab:: xml

        <integrator type="guided"/>

    .. code-tab:: python

        {'type': 'guided', 'max_depth': 8}
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import drjit as dr
import mitsuba as mi

from tracer.core.device import seed_number
from tracer.errors import SettingsError
from tracer.guiding.mis import power_heuristic
from tracer.guiding.table import LightChances, LightTable
from tracer.scene.view import open_scene
from tracer.session.guidance import Terms, choose_by, learn_lights

NO_LIMIT = 2**32 - 1


@dataclass
class LightSample:
    """What was learned at a vertex of a path: one shadow ray to a light that was chosen."""

    taught: mi.Bool
    """Whether there was such a vertex."""
    position: mi.Point3f
    """Place of the vertex."""
    normal: mi.Vector3f
    """Normal of the surface, on the side from which it is seen."""
    slot: mi.UInt32
    """Slot that was chosen; see ``tracer.guiding.slots``."""
    chance: mi.Float
    """Chance with which it was chosen."""
    given: mi.Float
    """What this would have given to the pixel if the choice of the slot had been certain."""

    @classmethod
    def nothing(cls) -> LightSample:
        """Return that nothing was learned."""
        return cls(mi.Bool(False), mi.Point3f(0.0), mi.Vector3f(0.0), mi.UInt32(0), mi.Float(1.0), mi.Float(0.0))


class GuidedIntegrator(mi.SamplingIntegrator):
    """See the documentation of this file."""

    def __init__(self, props: mi.Properties) -> None:
        super().__init__(props)
        max_depth = props.get("max_depth", -1)
        if max_depth < -1:
            raise SettingsError(f"guided: max_depth must be -1 or at least 0 (was {max_depth}).")
        self.max_depth = NO_LIMIT if max_depth == -1 else max_depth
        self.rr_depth = props.get("rr_depth", 5)
        if self.rr_depth < 1:
            raise SettingsError(f"guided: rr_depth must be at least 1 (was {self.rr_depth}).")
        self.table: LightTable | None = None
        """By which lights are chosen; None: all with the same chance."""
        self.learned: LightChances | None = None
        """The same as arrays, which can be sent and kept."""

    def render(
        self,
        scene: mi.Scene,
        sensor: int | mi.Sensor = 0,
        seed: mi.UInt32 | int = 0,
        spp: int = 0,
        develop: bool = True,
        evaluate: bool = True,
    ) -> mi.TensorXf:
        """Learn, and then render as Mitsuba does, with the sensor's own sampler and film."""
        chosen_sensor = sensor if isinstance(sensor, mi.Sensor) else scene.sensors()[sensor]
        with dr.suspend_grad(), open_scene(scene, chosen_sensor, self) as view:
            spp_of_picture = spp or chosen_sensor.sampler().sample_count()
            lesson = learn_lights(view, spp_of_picture, seed_number(seed), terms=Terms(keep=True))
            if lesson is None:
                choose_by(view, None)
            else:
                choose_by(view, lesson.learned, lesson.plan)
        try:
            return super().render(scene, chosen_sensor, seed, spp, develop, evaluate)
        finally:
            self.table = self.learned = None  # they are of this scene

    def sample(
        self,
        scene: mi.Scene,
        sampler: mi.Sampler,
        ray: mi.RayDifferential3f,
        medium: mi.Medium | None = None,
        active: mi.Bool | bool = True,
    ) -> tuple[mi.Spectrum, mi.Bool, list[mi.Float]]:
        radiance, valid, _ = self.follow(scene, sampler, ray, active, vertices=0)
        return radiance, valid, []

    @dr.syntax
    def follow(
        self, scene: mi.Scene, sampler: mi.Sampler, ray: Any, active: Any, vertices: int
    ) -> tuple[Any, Any, Any]:
        """Return (radiance, valid, light samples of the first ``vertices`` vertices) of paths along rays.

        The loop and the order of the sampler's numbers are those of Mitsuba's ``path.cpp``.
        """
        table: Any = self.table
        guided = table is not None
        context = mi.BSDFContext()
        ray = mi.Ray3f(ray)
        throughput, radiance = mi.Spectrum(1.0), mi.Spectrum(0.0)
        eta, depth = mi.Float(1.0), mi.UInt32(0)
        active = mi.Bool(active) & (self.max_depth > 0)
        valid = mi.Bool(not self.hide_emitters and scene.environment() is not None and self.max_depth > 0)
        before = dr.zeros(mi.Interaction3f)
        before_density, before_is_delta, before_row = mi.Float(1.0), mi.Bool(True), mi.UInt32(0)
        lessons = [LightSample.nothing() for _ in range(vertices)]

        hit = scene.ray_intersect_preliminary(ray, coherent=True, reorder=False, active=active)
        if dr.hint(self.hide_emitters, mode="scalar"):
            hit = behind_emitters(scene, ray, hit, active)
        while active:
            surface = hit.compute_surface_interaction(ray, mi.RayFlags.All)

            # Light that the ray met
            emitter = surface.emitter(scene)
            met = mi.DirectionSample3f(scene, surface, before)
            if dr.hint(guided, mode="scalar"):
                density = emitter.pdf_direction(before, met, ~before_is_delta)
                density *= table.chance_of(before_row, emitter, ~before_is_delta & (emitter != None))  # noqa: E711
            else:
                density = scene.pdf_emitter_direction(before, met, ~before_is_delta)
            density = dr.select(before_is_delta, 0.0, density)
            emitted = emitter.eval(surface, before_density > 0)
            radiance = dr.fma(throughput, emitted * power_heuristic(before_density, density), radiance)

            continues = (depth + 1 < self.max_depth) & surface.is_valid()
            bsdf = surface.bsdf(ray)

            # A light is chosen, and a direction towards it
            lit = continues & mi.has_flag(bsdf.flags(), mi.BSDFFlags.Smooth)
            number = sampler.next_2d()
            slot, slot_chance, row = mi.UInt32(0), mi.Float(1.0), mi.UInt32(0)
            normal = dr.mulsign(mi.Vector3f(surface.n), -dr.dot(surface.n, ray.d))
            if dr.hint(guided, mode="scalar"):
                row = table.row_at(surface.p, normal, lit)
                choice = table.choose(row, number, lit)
                slot, slot_chance = choice.slot, choice.slot_chance
                towards, weight = choice.light.sample_direction(surface, choice.number, lit)
                towards.pdf *= choice.light_chance
                weight /= choice.density
            else:
                towards, weight = scene.sample_emitter_direction(surface, number, False, lit)
            lit &= towards.pdf != 0
            wo = surface.to_local(towards.d)

            value, density, drawn, drawn_weight = bsdf.eval_pdf_sample(
                context, surface, wo, sampler.next_1d(), sampler.next_2d()
            )
            value = surface.to_world_mueller(value, -wo, surface.wi)
            mis_weight = dr.select(towards.delta, 1.0, power_heuristic(towards.pdf, density))
            given = throughput * value * weight * mis_weight
            lit &= dr.max(dr.abs(mi.unpolarized_spectrum(given))) > 0
            lit &= ~scene.ray_test(surface.spawn_ray_to(towards.p), False, lit)
            given = dr.select(lit, given, 0.0)
            radiance += given
            for k in range(vertices):
                now = continues & (depth == k) & mi.has_flag(bsdf.flags(), mi.BSDFFlags.Smooth)
                size = dr.mean(mi.unpolarized_spectrum(given)) * slot_chance
                lesson = LightSample(now, surface.p, normal, slot, slot_chance, size)
                lessons[k] = dr.select(now, lesson, lessons[k])

            # The path goes on
            drawn_weight = surface.to_world_mueller(drawn_weight, -drawn.wo, surface.wi)
            ray = surface.spawn_ray(surface.to_world(drawn.wo))
            throughput *= drawn_weight
            eta *= drawn.eta
            valid |= active & surface.is_valid() & ~mi.has_flag(drawn.sampled_type, mi.BSDFFlags.Null)
            before, before_density, before_row = mi.Interaction3f(surface), drawn.pdf, row
            before_is_delta = mi.has_flag(drawn.sampled_type, mi.BSDFFlags.Delta)

            # Roulette
            depth[surface.is_valid()] += 1
            largest = dr.max(mi.unpolarized_spectrum(throughput))
            chance = dr.minimum(largest * dr.square(eta), 0.95)
            may_end, goes_on = depth >= self.rr_depth, sampler.next_1d() < chance
            throughput[may_end] *= dr.rcp(chance)
            active = continues & (~may_end | goes_on) & (largest != 0)
            hit = scene.ray_intersect_preliminary(ray, coherent=False, reorder=True, active=active)
        return dr.select(valid, radiance, 0.0), valid, lessons

    def aov_names(self) -> list[str]:
        return []

    def to_string(self) -> str:
        depth = -1 if self.max_depth == NO_LIMIT else self.max_depth
        return (
            f"GuidedIntegrator[\n  max_depth = {depth},\n  rr_depth = {self.rr_depth},\n"
            f"  hide_emitters = {self.hide_emitters},\n  guided = {self.table is not None}\n]"
        )


@dr.syntax
def behind_emitters(
    scene: mi.Scene, ray: mi.Ray3f, hit: mi.PreliminaryIntersection3f, active: mi.Bool
) -> mi.PreliminaryIntersection3f:
    """Return what rays of the camera hit behind the lights that they hit first."""
    ray = mi.Ray3f(ray)
    skips = mi.Bool(active) & hit.is_valid() & (hit.shape.emitter() != None)  # noqa: E711
    while skips:
        surface = hit.compute_surface_interaction(ray, mi.RayFlags.Minimal)
        ray = surface.spawn_ray(ray.d)
        hit = scene.ray_intersect_preliminary(ray, coherent=True, reorder=False, active=skips)
        skips &= hit.is_valid() & (hit.shape.emitter() != None)  # noqa: E711
    return hit


mi.register_integrator("guided", GuidedIntegrator)

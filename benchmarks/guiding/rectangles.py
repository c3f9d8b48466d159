"""What it would gain to choose places on rectangular lights by solid angle, where Mitsuba chooses them by area."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from benchmarks.guiding.spherical_rectangle import SphericalRectangle, warped
from tracer.core.arrays import Floats
from tracer.core.device import to_host, upload
from tracer.guiding.mis import power_heuristic
from tracer.image import objective
from tracer.sampling.samples import camera_rays, make_sampler
from tracer.scene.view import View

WAYS = ("area", "solid angle", "cosine")
"""How a place is chosen: evenly over area, evenly over solid angle, or about as the cosine at the lit surface."""
SPP, SEEDS = (16, 64), 8
"""Samples per pixel, and number of pictures of each way whose differences tell the variance."""


@dataclass
class Lights:
    """The lights of a scene, one of which is chosen with equal chance."""

    lights: Any
    """mi.EmitterPtr"""
    place: Any
    """mi.UInt32, by the number that stands for a light in kernels: which light it is."""
    rectangles: Any
    """mi.Float, ten numbers by light: corner and both sides of a rectangle, and 1; zeros for other lights."""
    count: int
    rectangle_count: int

    @classmethod
    def of(cls, scene: Any) -> Lights:
        """Return the lights of an ``mi.Scene``."""
        lights = scene.emitters()
        table = np.zeros((len(lights), 10))
        for entry, light in zip(table, lights, strict=True):
            shape = light.get_shape()
            if shape is None or shape.class_name() != "Rectangle":
                continue
            x, y, _, centre = np.array(mi.traverse(shape)["to_world"].matrix).reshape(4, 4)[:3].T
            if abs(x @ y) < 1e-4 * np.linalg.norm(x) * np.linalg.norm(y):
                entry[:] = *(centre - x - y), *(2 * x), *(2 * y), 1
        pointers = mi.EmitterPtr(lights)
        numbers = dr.reinterpret_array(mi.UInt32, pointers).numpy()
        place = np.zeros(int(numbers.max(initial=0)) + 1, np.uint32)
        place[numbers] = np.arange(len(numbers))
        rectangles = upload(mi.Float, table.ravel().astype(np.float32))
        return cls(pointers, upload(mi.UInt32, place), rectangles, len(lights), int(table[:, 9].sum()))

    def seen(self, which: Any, surface: Any) -> tuple[SphericalRectangle, Any]:
        """Return lights (mi.UInt32) as rectangles seen from surfaces, and whether they are such and wide enough."""
        values = [dr.gather(mi.Float, self.rectangles, 10 * which + k) for k in range(10)]
        is_rectangle = values[9] > 0
        first = dr.select(is_rectangle, mi.Vector3f(*values[3:6]), [1, 0, 0])
        second = dr.select(is_rectangle, mi.Vector3f(*values[6:9]), [0, 1, 0])
        rectangle = SphericalRectangle.of(mi.Point3f(*values[:3]), first, second, surface.p)
        return rectangle, is_rectangle & rectangle.is_wide

    def sample(self, way: str, surface: Any, number: Any) -> tuple[Any, Any]:
        """Return directions to lights (mi.DirectionSample3f), and the light from there over its density.

        ``surface``: mi.SurfaceInteraction3f; ``number``: mi.Point2f, evenly in the unit square. The density in the
        direction is that by area or solid angle, whatever the cosines: it is for weights only.
        """
        scaled = number.x * self.count
        which = dr.minimum(mi.UInt32(scaled), self.count - 1)
        number = mi.Point2f(scaled - mi.Float(which), number.y)
        light = dr.gather(mi.EmitterPtr, self.lights, which)
        towards, weight = light.sample_direction(surface, number, surface.is_valid())
        if way != "area":
            rectangle, by_angle = self.seen(which, surface)
            by_angle &= towards.pdf > 0
            density = mi.Float(1.0)
            if way == "cosine":
                normal = dr.mulsign(mi.Vector3f(surface.n), dr.dot(surface.n, surface.to_world(surface.wi)))
                number, density = warped(number, rectangle.cosines(normal))
            other = mi.DirectionSample3f(towards)
            other.p = rectangle.place(number)
            other.dist = dr.norm(other.p - surface.p)
            other.d = (other.p - surface.p) / other.dist
            other.pdf = dr.rcp(rectangle.solid_angle)
            other_weight = light.eval_direction(surface, other, by_angle) / (other.pdf * density)
            towards, weight = dr.select(by_angle, other, towards), dr.select(by_angle, other_weight, weight)
        towards.pdf /= self.count
        return towards, weight * self.count

    def density(self, way: str, surface: Any, towards: Any) -> Any:
        """Return the density (mi.Float) with which ``sample`` chooses directions (mi.DirectionSample3f) to lights."""
        lit = towards.emitter != None  # noqa: E711
        density = towards.emitter.pdf_direction(surface, towards, lit)
        if way != "area":
            number = dr.reinterpret_array(mi.UInt32, towards.emitter)
            rectangle, by_angle = self.seen(dr.gather(mi.UInt32, self.place, number, lit), surface)
            density = dr.select(by_angle & (density > 0), dr.rcp(rectangle.solid_angle), density)
        return density / self.count


def direct_light(view: View, lights: Lights, way: str, seed: int, spp: int) -> Floats:
    """Return the light (pixels,) that comes from lights straight to what the camera sees.

    As by ``path``, it comes by a shadow ray and by a ray that the material chooses, weighted by the power heuristic.
    """
    pixel_count, scene = view.pixel_count, view.scene
    pixel = dr.repeat(dr.arange(mi.UInt32, pixel_count), spp)
    sampler = make_sampler()
    sampler.seed_samples(dr.opaque(mi.UInt32, seed), pixel, dr.tile(dr.arange(mi.UInt32, spp), pixel_count))
    ray, ray_weight, _ = camera_rays(view, sampler, pixel, dr.opaque(mi.Float, 1.0))
    surface = scene.ray_intersect(ray)
    bsdf, context = surface.bsdf(ray), mi.BSDFContext()

    towards, light = lights.sample(way, surface, sampler.next_2d())
    active = surface.is_valid() & (towards.pdf > 0)
    value, material = bsdf.eval_pdf(context, surface, surface.to_local(towards.d), active)
    active &= ~scene.ray_test(surface.spawn_ray_to(towards.p), active)
    mis = dr.select(towards.delta, 1.0, power_heuristic(towards.pdf, material))
    by_light = dr.select(active, mi.unpolarized_spectrum(value * light) * mis, 0.0)

    drawn, value = bsdf.sample(context, surface, sampler.next_1d(), sampler.next_2d(), surface.is_valid())
    hit = scene.ray_intersect(surface.spawn_ray(surface.to_world(drawn.wo)), surface.is_valid())
    met = mi.DirectionSample3f(scene, hit, surface)
    is_delta = mi.has_flag(drawn.sampled_type, mi.BSDFFlags.Delta)
    mis = dr.select(is_delta, 1.0, power_heuristic(drawn.pdf, lights.density(way, surface, met)))
    by_material = mi.unpolarized_spectrum(value * met.emitter.eval(hit)) * mis

    brightness = dr.mean(mi.unpolarized_spectrum(ray_weight) * (by_light + by_material))
    brightness = dr.select(surface.is_valid() & dr.isfinite(brightness), brightness, 0.0)
    return to_host(brightness, (pixel_count, spp)).mean(axis=1, dtype=np.float64)


@dataclass(frozen=True)
class Gains:
    """What the other ways gain over "area"."""

    variance: dict[str, list[float]]
    """For each of them, by which factor the variance of direct light falls, one for each of ``SPP``."""
    time: dict[str, float]
    """For each of them, how many times as long the kernels take: the median over pairs of pictures."""


def gains(view: View, lights: Lights, first_seed: int) -> Gains:
    """Return what the other ways gain in a scene. Each pixel's variance is weighted as relMSE weights it."""
    factors: dict[str, list[float]] = {way: [] for way in WAYS[1:]}
    seconds: dict[str, list[float]] = {way: [] for way in WAYS}
    for spp in SPP:
        pictures: dict[str, list[Floats]] = {way: [] for way in WAYS}
        for seed in range(first_seed, first_seed + SEEDS):
            for way in WAYS:
                with kernel_seconds(seconds[way]):
                    pictures[way].append(direct_light(view, lights, way, seed, spp))
        mean = np.mean([np.mean(drawn, axis=0) for drawn in pictures.values()], axis=0)
        weight = objective.weights("relative", mean)
        variance = {way: float((weight * np.var(drawn, axis=0, ddof=1)).sum()) for way, drawn in pictures.items()}
        for way, values in factors.items():
            values.append(variance["area"] / variance[way])
    slower = {way: float(np.median(np.divide(seconds[way], seconds["area"]))) for way in WAYS[1:]}
    return Gains(factors, slower)


@contextmanager
def kernel_seconds(seconds: list[float]) -> Iterator[None]:
    """Append the time that the kernels of the block take, in seconds."""
    with dr.scoped_set_flag(dr.JitFlag.KernelHistory, True):
        dr.kernel_history_clear()
        yield
        seconds.append(sum(kernel["execution_time"] for kernel in dr.kernel_history()) / 1000)

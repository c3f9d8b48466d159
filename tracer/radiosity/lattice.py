"""Directions of the rays of a hemisphere: a Fibonacci lattice, shifted at random for every point, or random ones."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import drjit as dr
import mitsuba as mi

from tracer.core.device import to_unit
from tracer.core.hashing import GOLDEN_RATIO, mix

Way = Callable[[Any, Any, Any, int], tuple[Any, Any]]
"""A way to spread rays: from the number of the point, the number of the ray and the count of rays of the point (each
mi.UInt32), and a seed, to local directions (mi.Vector3f), z the normal, and weights (mi.Float). The weight of a ray is
its part of the projected solid angle of the hemisphere, which is pi."""


def lattice(point: Any, ray_index: Any, rays: Any, seed: int) -> tuple[Any, Any, Any]:
    """Return (bits, u, v) of rays: random bits (mi.UInt32) of the point, and places (mi.Float) in the unit square."""
    bits = mix(point ^ mix(dr.opaque(mi.UInt32, (seed + 0x1B873593) & 0xFFFFFFFF)))
    return bits, spread(ray_index, rays, bits), to_unit(ray_index * GOLDEN_RATIO + mix(bits))


def spread(ray_index: Any, count: Any, bits: Any) -> Any:
    """Return the first coordinate (mi.Float) of the points of a lattice of ``count`` points, shifted by random bits."""
    return dr.minimum((mi.Float(ray_index) + to_unit(bits)) / mi.Float(count), 1 - dr.epsilon(mi.Float))


def evenly(point: Any, ray_index: Any, rays: Any, seed: int) -> tuple[Any, Any]:
    """Return directions distributed as the cosine, all of the same weight (a ``Way``)."""
    _, u, v = lattice(point, ray_index, rays, seed)
    return mi.warp.square_to_cosine_hemisphere(mi.Point2f(u, v)), dr.pi / mi.Float(rays)


def randomly(point: Any, ray_index: Any, rays: Any, seed: int) -> tuple[Any, Any]:
    """Return independent directions distributed as the cosine, as in classical Monte Carlo radiosity (a ``Way``)."""
    bits, _, _ = lattice(point, ray_index, rays, seed)
    u, v = random_numbers(bits, ray_index)
    return mi.warp.square_to_cosine_hemisphere(mi.Point2f(u, v)), dr.pi / mi.Float(rays)


def random_numbers(bits: Any, ray_index: Any) -> tuple[Any, Any]:
    """Return two independent numbers (mi.Float) in [0, 1) for each ray, from random bits (mi.UInt32) of its point."""
    key = mix(bits ^ mix(ray_index + 0x7F4A7C15))
    return to_unit(key), to_unit(mix(key ^ 0x94D049BB))

"""Directions of the rays of one hemisphere, spread evenly: a Fibonacci lattice, shifted at random for every point."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import drjit as dr
import mitsuba as mi

from tracer.core.device import to_unit
from tracer.core.hashing import GOLDEN_RATIO, mix

Way = Callable[[Any, Any, Any, int], tuple[Any, Any]]
"""From point, number of the ray and count of rays of the point (mi.UInt32), and a seed, to directions (mi.Vector3f), z
the normal, and what each stands for (mi.Float) of the pi that is the whole hemisphere."""


def lattice(point: Any, number: Any, rays: Any, seed: int) -> tuple[Any, Any, Any]:
    """Return (bits, u, v) of rays: random bits (mi.UInt32) of the point, and its lattice in the unit square."""
    key = mix(point ^ mix(dr.opaque(mi.UInt32, (seed + 0x1B873593) & 0xFFFFFFFF)))
    return key, spread(number, rays, key), to_unit(number * GOLDEN_RATIO + mix(key))


def spread(number: Any, count: Any, key: Any) -> Any:
    """Return the first coordinate (mi.Float) of points of a lattice of ``count``, shifted by random bits."""
    return dr.minimum((mi.Float(number) + to_unit(key)) / mi.Float(count), 1 - dr.epsilon(mi.Float))


def evenly(point: Any, number: Any, rays: Any, seed: int) -> tuple[Any, Any]:
    """Return directions as the cosine is; each stands for as much (``Way``)."""
    _, u, v = lattice(point, number, rays, seed)
    return mi.warp.square_to_cosine_hemisphere(mi.Point2f(u, v)), dr.pi / mi.Float(rays)

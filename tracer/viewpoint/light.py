"""How well a scene's own light shows each surface: what is dark or burnt out tells a person who looks nothing.

The light that a surface sends out, whatever the view, is estimated by paths that end at random places on either side of
it. The scene's integrator follows them, so that shadows, materials and light from other surfaces count.
"""

from __future__ import annotations

from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from tracer.core.arrays import Floats, Integers
from tracer.core.device import upload
from tracer.errors import SceneError
from tracer.image.colour import luminance
from tracer.viewpoint.surfaces import Subject
from tracer.viewpoint.weights import with_weights

MOST_PATHS = 1 << 20
"""Most paths that are followed at once."""
ALL_PATHS = 1 << 21
"""Number of paths, about, that are shared out to the surfaces, within LEAST and MOST for each of their sides."""
LEAST, MOST = 4, 256
"""Least and most paths that end on a side of a surface."""
OFFSET = 1e-3
"""Paths begin so far from the place where they end, in radii of the subject."""

BEST = 0.25
"""The luminance of which the cube root, times what it lacks to white, is greatest."""


def shown_by_light(subject: Subject, seed: int = 0) -> Floats:
    """Return how much a picture can tell apart on front and back of each surface (Z, 2), 0 to 1: b (1 - L) / 0.47.

    L is the mean luminance of the side, at most 1, which is white in a picture, and b = L^(1/3) is its brightness there
    (CIE 1976): nothing can be told apart on what is black or burnt out. The best luminance is 0.25. Surfaces whose
    places are unknown, such as instances, have the value 1. Raises SceneError for a scene without light, or if all
    surfaces are black or burnt out.
    """
    if not subject.scene.emitters():
        raise SceneError("There is no light in the scene that could show anything.")
    points, normals, surface = places_on(subject, seed)
    sides = [radiance_sent(subject, points, sign * normals, seed + k) for k, sign in enumerate((1.0, -1.0))]
    count = np.maximum(np.bincount(surface, minlength=subject.count), 1)
    sent = np.stack([np.bincount(surface, side, subject.count) / count for side in sides], axis=-1)
    if not np.any(sent > 0):
        raise SceneError("The light of the scene reaches no surface, so that it shows nothing.")
    seen = np.minimum(sent, 1.0)
    shown = np.cbrt(seen) * (1 - seen) / (np.cbrt(BEST) * (1 - BEST))
    if not np.any(shown > 0):
        raise SceneError(
            "All that light reaches is burnt out, brighter than white; make the lights of the scene weaker."
        )
    has_places = np.bincount(surface, minlength=subject.count) > 0
    return np.where(has_places[:, None], shown, 1.0)


def weighted_by_light(subject: Subject) -> Subject:
    """Return a subject whose surfaces are sides, each of which counts as well as light shows it.

    Raises SceneError as ``shown_by_light``.
    """
    shown = shown_by_light(subject)
    sides = subject.with_sides()
    return with_weights(sides, sides.weights * shown.ravel())


def places_on(subject: Subject, seed: int) -> tuple[Floats, Floats, Integers]:
    """Return places (N, 3) on the surfaces, their normals (N, 3), and the surface (N,) of each."""
    generator = np.random.default_rng(seed)
    per_surface = int(np.clip(ALL_PATHS // (2 * subject.count), LEAST, MOST))
    found = [places_on_mesh(subject, per_surface, generator)] if len(subject.mesh.triangles) else []
    first_face = 0
    for shape, face_count in zip(subject.scene.shapes(), subject.face_counts, strict=True):
        if not shape.is_mesh() and face_count == 1 and (places := places_on_shape(shape, per_surface, generator)):
            found.append((*places, np.full(per_surface, surface_of(subject, first_face))))
        first_face += int(face_count)
    if not found:
        raise SceneError("Light can be measured on meshes and simple shapes, and the scene has none.")
    points, normals, surface = (np.concatenate(columns) for columns in zip(*found, strict=True))
    return points, normals, surface


def surface_of(subject: Subject, face: int) -> int:
    """Return the surface that a face belongs to."""
    return face if subject.surface_of_face is None else int(subject.surface_of_face[face])


def places_on_mesh(
    subject: Subject, per_surface: int, generator: np.random.Generator
) -> tuple[Floats, Floats, Integers]:
    """Return (places, normals, surfaces) of ``per_surface`` places on each surface of meshes, uniform in area."""
    mesh = subject.mesh
    a, b, c = mesh.vertices[mesh.triangles].transpose(1, 0, 2)
    cross = np.cross(b - a, c - a)
    doubled_areas = np.linalg.norm(cross, axis=-1)
    order = np.argsort(mesh.surface, kind="stable")
    ends = np.cumsum(doubled_areas[order])
    surfaces, begins = np.unique(mesh.surface[order], return_index=True)
    first = np.where(begins > 0, ends[begins - 1], 0.0)
    last = ends[np.append(begins[1:], len(order)) - 1]
    draws = first[:, None] + generator.random((len(surfaces), per_surface)) * (last - first)[:, None]
    limits = np.append(begins[1:], len(order)) - 1
    place = np.minimum(np.searchsorted(ends, draws.ravel(), side="right"), np.repeat(limits, per_surface))
    triangle = order[place]
    u, v = generator.random((2, len(triangle)))
    root = np.sqrt(u)[:, None]
    points = (1 - root) * a[triangle] + root * (1 - v[:, None]) * b[triangle] + root * v[:, None] * c[triangle]
    normals = cross[triangle] / np.maximum(doubled_areas[triangle], 1e-300)[:, None]
    return points, normals, np.repeat(surfaces, per_surface)


def places_on_shape(shape: Any, count: int, generator: np.random.Generator) -> tuple[Floats, Floats] | None:
    """Return (places, normals), (N, 3) each, on a shape that is no mesh; None if it has none, as an instance."""
    sample = mi.Point2f(*(upload(mi.Float, numbers) for numbers in generator.random((2, count))))
    try:
        record = shape.sample_position(mi.Float(0), sample)
    except RuntimeError:  # Mitsuba raises this for a kind of shape that cannot be sampled
        return None
    points, normals = (np.array(vectors, np.float64).T for vectors in (record.p, record.n))
    if points.shape != (count, 3) or not np.all(np.isfinite(points)):
        return None
    return points, np.broadcast_to(normals, points.shape)  # a flat shape has one normal


def radiance_sent(subject: Subject, points: Floats, normals: Floats, seed: int) -> Floats:
    """Return the luminance (N,) that each place sends out, in a random direction about its normal, by cosine."""
    found = []
    for begin in range(0, len(points), MOST_PATHS):
        part = slice(begin, begin + MOST_PATHS)
        count = len(points[part])
        sampler = mi.load_dict({"type": "independent"})
        sampler.seed(seed + begin, count)
        point, normal = (
            mi.Vector3f(*(upload(mi.Float, column) for column in rows[part].T)) for rows in (points, normals)
        )
        direction = mi.Frame3f(normal).to_world(mi.warp.square_to_cosine_hemisphere(sampler.next_2d()))
        start = mi.Point3f(point + direction * dr.opaque(mi.Float, OFFSET * subject.radius))
        ray = mi.RayDifferential3f(o=start, d=-direction)
        radiance = integrator_of(subject).sample(subject.scene, sampler, ray)[0]
        spectrum = np.array(radiance, np.float64).T
        bright = luminance(spectrum) if spectrum.shape[-1] == 3 else spectrum.mean(axis=-1)
        found.append(np.where(np.isfinite(bright), np.maximum(bright, 0.0), 0.0))
    return np.concatenate(found)


def integrator_of(subject: Subject) -> Any:
    """Return the scene's integrator if it follows paths by itself, else Mitsuba's path tracer."""
    own = subject.scene.integrator()
    follows = own is not None and own.class_name() in ("PathIntegrator", "VolumetricPathIntegrator")
    return own if follows else mi.load_dict({"type": "path"})

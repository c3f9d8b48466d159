"""Remarks on the parts of a scene that radiosity changes or leaves out: it treats every surface as diffuse."""

from __future__ import annotations

from collections import Counter
from typing import Any

from tracer.radiosity.albedo import not_diffuse
from tracer.radiosity.tessellate import name_of


def remarks(scene: Any) -> list[str]:
    """Return a sentence for each kind of content that a picture by radiosity changes or leaves out."""
    materials, media = other_than_diffuse(scene), with_media(scene)
    sentences = [f"Not diffuse, and shown as if they were: {', '.join(materials)}."] if materials else []
    return sentences + ([f"Media are left out, as radiosity knows only surfaces: {', '.join(media)}."] if media else [])


def other_than_diffuse(scene: Any) -> list[str]:
    """Return the names of shapes whose material is not purely diffuse."""
    return counted(shape for shape in scene.shapes() if shape.bsdf() is not None and not_diffuse(shape.bsdf()))


def with_media(scene: Any) -> list[str]:
    """Return the names of shapes with a medium inside or outside, and of sensors that stand in a medium."""
    shapes = [shape for shape in scene.shapes() if shape.interior_medium() or shape.exterior_medium()]
    sensors = [f"sensor {number}" for number, sensor in enumerate(scene.sensors()) if sensor.get_medium()]
    return counted(shapes) + sensors


def counted(shapes: Any) -> list[str]:
    """Return the names of shapes in alphabetical order, each name once and with the number of shapes that bear it.

    They are sorted because the order in which Mitsuba loads shapes may vary.
    """
    counts = Counter(name_of(shape) for shape in shapes)
    return [name if count == 1 else f"{count} times {name}" for name, count in sorted(counts.items())]

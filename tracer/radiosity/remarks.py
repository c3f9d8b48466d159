"""Remarks on what radiosity changes or leaves out of a scene, as it treats all as diffuse, and on biased solutions."""

from __future__ import annotations

from collections import Counter
from typing import Any

from tracer.radiosity.albedo import not_diffuse
from tracer.radiosity.paper import PaperRules
from tracer.radiosity.spread import Spread
from tracer.radiosity.tessellate import name_of
from tracer.scene.shape_names import material_name

TOLERABLE = 1e-3
"""Share of the energy by which rays may be off before a person is told."""


def remarks(scene: Any) -> list[str]:
    """Return a sentence for each kind of content that a picture by radiosity changes or leaves out."""
    materials, media = other_than_diffuse(scene), with_media(scene)
    sentences = [f"Not diffuse, and shown as if they were: {', '.join(materials)}."] if materials else []
    return sentences + ([f"Media are left out, as radiosity knows only surfaces: {', '.join(media)}."] if media else [])


def other_than_diffuse(scene: Any) -> list[str]:
    """Return what is not purely diffuse: materials by name, with their shapes, and shapes whose material has none."""
    shapes = [shape for shape in scene.shapes() if shape.bsdf() is not None and not_diffuse(shape.bsdf())]
    by_material: dict[str, list[Any]] = {}
    for shape in shapes:
        by_material.setdefault(material_name(shape.bsdf()), []).append(shape)
    nameless = counted(by_material.pop("", []))
    return [
        f"material '{name}' of {', '.join(counted(bearers)) if len(bearers) == 1 else f'{len(bearers)} shapes'}"
        for name, bearers in sorted(by_material.items())
    ] + nameless


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


def bias_remarks(energy: float, spread: Spread) -> list[str]:
    """Return the sentence that a solution is biased, if it is: its rays follow the paper's rules as they are printed.

    ``energy``: what the rays carried, as a share of the energy there is.
    """
    if not isinstance(spread, PaperRules) or spread.right or abs(energy - 1) <= TOLERABLE:
        return []
    return [
        f"The rays of patches carry {100 * energy:.1f} % of their energy by the paper's rules: the result is biased."
    ]

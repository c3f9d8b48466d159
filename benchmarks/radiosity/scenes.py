"""Scenes of the benchmark: some in which complexity should help, some in which it should not, some that mislead it."""

from __future__ import annotations

from dataclasses import dataclass
from importlib.resources import as_file, files
from typing import Any

import mitsuba as mi
import numpy as np


@dataclass(frozen=True)
class Example:
    """A scene and how it is measured."""

    name: str
    says: str
    """What is special about the scene."""
    scene: Any
    size: float
    """Longest edge of a patch, in units of the scene."""
    lights: bool
    """Whether rays have to find the lights; otherwise reflected light alone is measured."""


def examples() -> list[Example]:
    """Return all scenes of the benchmark."""
    return [
        Example("chandelier", "60 small bright cubes fill few directions", load(chandelier()), 0.3, True),
        Example("Cornell box", "one lamp, which rays have to find", load(mi.cornell_box()), 0.1, True),
        Example("Cornell box, reflected", "its reflected light alone", load(mi.cornell_box()), 0.1, False),
        Example("cove", "a lamp that shines at the ceiling: reflected light alone", load(cove()), 0.1, False),
        Example("window", "daylight through a window: a bundled scene", bundled("window_interior"), 0.45, True),
        Example("many lights", "72 lamps: a bundled scene", bundled("many_lights"), 3.0, True),
        Example("foliage", "busy but dark, under a large even light", load(foliage()), 0.125, True),
    ]


def bundled(name: str) -> Any:
    """Return a bundled scene."""
    with as_file(files("tracer.scenes") / f"{name}.xml") as scene:
        return mi.load_file(str(scene))


def load(scene: dict[str, Any]) -> Any:
    """Return the loaded scene with a small film."""
    parts = {
        **scene,
        "sensor": {
            **scene["sensor"],
            "film": {"type": "hdrfilm", "width": 160, "height": 160, "rfilter": {"type": "box"}},
            "sampler": {"type": "independent"},
        },
    }
    return mi.load_dict(parts)


def rgb(values: Any) -> dict[str, Any]:
    """Return a colour."""
    return {"type": "rgb", "value": np.asarray(values, float).tolist()}


def grey(value: float) -> dict[str, Any]:
    """Return a diffuse material."""
    return {"type": "diffuse", "reflectance": rgb([value] * 3)}


def camera(origin: list[float], target: list[float]) -> dict[str, Any]:
    """Return a camera; z is up."""
    return {"type": "perspective", "fov": 55, "to_world": mi.ScalarTransform4f().look_at(origin, target, [0, 0, 1])}


def scattered(count: int, middle: list[float], reach: float, side: float, seed: int) -> list[Any]:
    """Return transforms that place ``count`` small cubes at random within ``reach`` of ``middle`` along each axis."""
    places = np.random.default_rng(seed).uniform(-reach, reach, (count, 3)) + middle
    return [mi.ScalarTransform4f().translate(place.tolist()).scale(side) for place in places]


def chandelier() -> dict[str, Any]:
    """Return a hall with a cluster of small lamps of all colours."""
    transform = mi.ScalarTransform4f
    parts: dict[str, Any] = {
        "type": "scene",
        "sensor": camera([-4.5, -4.5, 2.5], [1.5, 1.5, 1.8]),
        "hall": {
            "type": "cube",
            "flip_normals": True,
            "to_world": transform().translate([0, 0, 3]).scale([5, 5, 3]),
            "bsdf": grey(0.5),
        },
        "table": {
            "type": "cube",
            "to_world": transform().translate([1, 1, 0.6]).scale([1.5, 1, 0.05]),
            "bsdf": grey(0.7),
        },
    }
    colours = np.random.default_rng(0).random((60, 3)) * 40
    for index, place in enumerate(scattered(60, [2.0, 2.0, 4.0], 0.5, 0.04, 1)):
        emitter = {"type": "area", "radiance": rgb(colours[index])}
        parts[f"lamp_{index:02}"] = {"type": "cube", "to_world": place, "emitter": emitter}
    return parts


def cove() -> dict[str, Any]:
    """Return a Cornell box whose lamp shines at the ceiling from nearby."""
    parts = dict(mi.cornell_box())
    transform = mi.ScalarTransform4f
    up = transform().translate([0.3, 0.85, 0.2]).rotate([1, 0, 0], -90).scale(0.08)
    down = transform().translate([0.3, 0.84, 0.2]).rotate([1, 0, 0], 90).scale(0.12)
    parts["light"] = {**parts["light"], "to_world": up, "emitter": {"type": "area", "radiance": rgb([80, 60, 40])}}
    parts["shade"] = {"type": "rectangle", "to_world": down, "bsdf": {"type": "twosided", "both": grey(0.2)}}
    return parts


def foliage() -> dict[str, Any]:
    """Return many small dark cubes over a floor, under a large light."""
    transform = mi.ScalarTransform4f
    sky = transform().translate([0, 0, 6]).rotate([1, 0, 0], 180).scale(4)
    parts: dict[str, Any] = {
        "type": "scene",
        "sensor": camera([-4, -8, 5], [0, 0, 1]),
        "floor": {"type": "rectangle", "to_world": transform().scale(5), "bsdf": grey(0.5)},
        "sky": {"type": "rectangle", "to_world": sky, "emitter": {"type": "area", "radiance": rgb([1, 1, 1])}},
    }
    for index, place in enumerate(scattered(60, [-3.5, 0.0, 1.5], 1.0, 0.06, 1)):
        parts[f"leaf_{index:02}"] = {"type": "cube", "to_world": place, "bsdf": grey(0.02)}
    return parts

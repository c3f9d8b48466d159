"""A mesh file alone as a scene: seen from the best view in a neutral light."""

from __future__ import annotations

from pathlib import Path
from typing import Any, TypeGuard

import mitsuba as mi
import numpy as np

from tracer.core.arrays import Floats
from tracer.core.sphere import icosphere, normalised
from tracer.errors import SettingsError
from tracer.scene import mesh_files
from tracer.scene.fingerprint import digest
from tracer.scene.loaded import LoadedScene
from tracer.scene.mesh_scene import shapes_of
from tracer.scene.parts import content_of, recentred
from tracer.viewpoint.direction_measure import Gauge, Stand, stand
from tracer.viewpoint.item_buffer import Rays
from tracer.viewpoint.source import up_of_file
from tracer.viewpoint.surfaces import open_subject

SIZE = (960, 720)
"""Width and height of the picture, unless another size is asked for."""
LEVEL, SIDE = 2, 128
"""Views from the corners of an icosphere of this level are compared, by this many rays along each side."""
LOWEST, HIGHEST = np.sin(np.radians(5)), np.sin(np.radians(50))
"""Sines of the least and the largest height of the camera above the horizon: people look at things from there."""
SKY, LAMP = 0.55, 9.0
"""Radiance of the grey sky, and of the lamp above the camera's left shoulder."""
VERSION = b"showcase 2"
"""Changes when other pictures are made of the same file, which a checkpoint must notice."""


def is_mesh_file(source: Any) -> TypeGuard[str | Path]:
    """Return whether a scene is given as the path of a mesh file."""
    return isinstance(source, str | Path) and Path(source).suffix.lower() in mesh_files.SUFFIXES


def require_scene_file(source: Any) -> None:
    """Raise SettingsError for a mesh file, which workers cannot open alone."""
    if is_mesh_file(source):
        raise SettingsError(
            f"Workers open scene files, and '{source}' is a mesh; name it in a scene, or use no workers."
        )


def showcase(path: Path) -> LoadedScene:
    """Return the scene of a mesh file. Raises SceneError."""
    parts, _ = recentred(mesh_files.read_parts(path))
    shapes = shapes_of(parts)
    subject = open_subject(mi.load_dict({"type": "scene", **shapes}))
    place = stand(subject, up=up_of_file(path))
    direction = best_direction(Gauge(subject, place, Rays(side=SIDE), "entropy"), place.up)
    scene = {"type": "scene", "integrator": {"type": "path"}, **shapes}
    scene |= {**camera(place, direction), **lights(place, direction)}
    return LoadedScene(path, {}, digest(VERSION, *content_of(parts)), mi.load_dict(scene))


def best_direction(gauge: Gauge, up: Floats) -> Floats:
    """Return the direction (3,) of the view with the most entropy of faces, somewhat above the horizon."""
    directions = icosphere(LEVEL)[0]
    height = directions @ normalised(up)
    directions = directions[(height > LOWEST) & (height < HIGHEST)]
    return np.asarray(directions[np.argmax(np.nan_to_num(gauge.better(directions), nan=-np.inf))], np.float64)


def camera(place: Stand, direction: Floats) -> dict[str, Any]:
    """Return a sensor that sees the whole subject from a direction."""
    eye = place.centre + place.distance * direction
    near, far = place.clip
    film = {"type": "hdrfilm", "width": SIZE[0], "height": SIZE[1]}
    return {
        "sensor": {
            "type": "perspective",
            "fov": float(2 * np.degrees(np.arcsin(place.radius / place.distance))),
            "fov_axis": "smaller",
            "near_clip": near,
            "far_clip": far,
            "to_world": mi.ScalarTransform4f().look_at(
                origin=eye.tolist(), target=place.centre.tolist(), up=place.up.tolist()
            ),
            "film": film,
        }
    }


def lights(place: Stand, direction: Floats) -> dict[str, Any]:
    """Return a grey sky, and a round lamp above the left shoulder of who looks from a direction."""
    up = normalised(place.up)
    left = normalised(np.cross(up, direction)) * -1
    towards = normalised(direction + 0.8 * up + 0.7 * left)
    origin = place.centre + 4 * place.radius * towards
    to_world = mi.ScalarTransform4f().look_at(
        origin=origin.tolist(), target=place.centre.tolist(), up=direction.tolist()
    ) @ mi.ScalarTransform4f().scale(1.2 * place.radius)
    return {
        "sky": {"type": "constant", "radiance": SKY},
        "lamp": {"type": "disk", "to_world": to_world, "emitter": {"type": "area", "radiance": LAMP}},
    }

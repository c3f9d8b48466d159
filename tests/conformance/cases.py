"""Scenes that between them use what a picture can depend on: integrators, sensors, films, filters, crops."""

from __future__ import annotations

import mitsuba as mi

FILTERS = ("box", "tent", "gaussian", "mitchell", "catmullrom", "lanczos")

INTEGRATORS = {
    "path": {"type": "path", "max_depth": 4},
    "direct": {"type": "direct"},
    "volpath": {"type": "volpath", "max_depth": 6},
    "volpathmis": {"type": "volpathmis", "max_depth": 6},
    "prb": {"type": "prb", "max_depth": 4},
    "depth": {"type": "depth"},
    "moment": {"type": "moment", "inner": {"type": "direct"}},
    "aov": {"type": "aov", "aovs": "dd.y:depth,nn:sh_normal", "inner": {"type": "direct"}},
}
FILMS = {
    "rgba": {"pixel_format": "rgba"},
    "luminance": {"pixel_format": "luminance"},
    "luminance_alpha": {"pixel_format": "luminance_alpha"},
    "xyz": {"pixel_format": "xyz"},
    "float16": {"component_format": "float16"},
    "crop": {"crop_offset_x": 3, "crop_offset_y": 2, "crop_width": 11, "crop_height": 9},
    "border": {"sample_border": True},
    "crop_and_border": {"sample_border": True, "crop_offset_x": 3, "crop_width": 11},
}


def sensors() -> dict[str, dict]:
    """Return cameras that look at the scene; they need a variant for their transforms."""
    at = mi.ScalarTransform4f().look_at([0, 1.5, 5], [0, 0, 0], [0, 1, 0])
    return {
        "perspective": {"type": "perspective", "to_world": at},
        "thinlens": {"type": "thinlens", "to_world": at, "aperture_radius": 0.2, "focus_distance": 5.0},
        "orthographic": {"type": "orthographic", "to_world": at @ mi.ScalarTransform4f().scale(1.8)},
        "shutter": {"type": "perspective", "to_world": at, "shutter_open": 0.2, "shutter_close": 0.7},
    }


def scene(
    integrator: str = "direct",
    sensor: str = "perspective",
    film: str | None = None,
    filter_name: str = "gaussian",
    sample_count: int = 16,
) -> dict:
    """Return a ball in fog, a block and a floor under a small lamp before a dim sky.

    Edges, shadows and an open background, but no light that is found only by chance.
    """
    t = mi.ScalarTransform4f()
    lamp = {"type": "rectangle", "to_world": t.look_at([1, 3, 2], [0, 0, 0], [0, 0, 1]) @ t.scale(0.8)}
    size = {"type": "hdrfilm", "width": 20, "height": 16, "rfilter": {"type": filter_name}}
    ball = {"type": "sphere", "center": [-0.6, 0, 0], "radius": 0.7}
    if integrator.startswith("volpath"):
        ball |= {"bsdf": {"type": "null"}, "interior": {"type": "homogeneous", "albedo": 0.8, "sigma_t": 2.0}}
    camera = sensors()[sensor] | {
        "film": size | FILMS.get(film, {}),
        "sampler": {"type": "owen_sobol", "sample_count": sample_count},
    }
    return {
        "type": "scene",
        "integrator": INTEGRATORS[integrator],
        "sensor": camera,
        "lamp": lamp | {"emitter": {"type": "area", "radiance": 6.0}},
        "sky": {"type": "constant", "radiance": 0.05},
        "ball": ball,
        "block": {"type": "cube", "to_world": t.translate([0.9, -0.3, 0]) @ t.scale(0.4)},
        "floor": {"type": "rectangle", "to_world": t.translate([0, -0.7, 0]) @ t.rotate([1, 0, 0], -90) @ t.scale(4)},
    }


def cases() -> list[dict[str, str]]:
    """Return arguments of ``scene``: every integrator, sensor, film and filter once, and some together."""
    found = [{"integrator": name} for name in INTEGRATORS]
    found += [{"sensor": name} for name in ("thinlens", "orthographic", "shutter")]
    found += [{"film": name} for name in FILMS]
    found += [{"filter_name": name} for name in FILTERS]
    found.append({"integrator": "aov", "film": "rgba", "filter_name": "box"})
    found.append({"integrator": "volpath", "sensor": "thinlens", "film": "crop_and_border", "filter_name": "mitchell"})
    return found


def name(case: dict[str, str]) -> str:
    """Return what a case is called in the report."""
    return "-".join(case.values())


def mitsuba_picture(scene: mi.Scene, seed: int, spp: int, sensor: int = 0) -> mi.TensorXf:
    """Return ``mi.render``'s picture with all channels, as they are in the film.

    What it returns for ``aov`` lacks the copies of the nested image that the film has under their names.
    """
    scene.integrator().render(scene, sensor=scene.sensors()[sensor], seed=seed, spp=spp)
    return scene.sensors()[sensor].film().develop()

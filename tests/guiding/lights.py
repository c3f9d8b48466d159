"""Small scenes with lights of chosen kinds."""

import mitsuba as mi
import numpy as np

MAKE = {
    "area": lambda place: {
        "type": "rectangle",
        "to_world": mi.ScalarTransform4f().translate([*place, 2.0]).rotate([1, 0, 0], 180).scale(0.4),
        "emitter": {"type": "area", "radiance": {"type": "rgb", "value": [4.0, 3.0, 2.0]}},
    },
    "sphere": lambda place: {
        "type": "sphere",
        "center": [*place, 1.5],
        "radius": 0.2,
        "emitter": {"type": "area", "radiance": {"type": "rgb", "value": [2.0, 3.0, 4.0]}},
    },
    "far lamp": lambda place: {
        "type": "sphere",
        "center": [*place, -30.0],
        "radius": 0.5,
        "emitter": {"type": "area", "radiance": 20.0},
    },
    "half black": lambda place: {
        "type": "rectangle",
        "to_world": mi.ScalarTransform4f().translate([*place, 2.0]).rotate([1, 0, 0], 180).scale(0.4),
        "emitter": {"type": "area", "radiance": bitmap_of(half_black(4.0))},
    },
    "black sky": lambda place: {"type": "envmap", "bitmap": mi.Bitmap(half_black(0.5))},
    "projector": lambda place: {
        "type": "projector",
        "to_world": mi.ScalarTransform4f().look_at(origin=[*place, 3.0], target=[0, 0, 0], up=[0, 1, 0]),
        "irradiance": bitmap_of(half_black(4.0)),
        "fov": 60.0,
    },
    "point": lambda place: {"type": "point", "position": [*place, 1.0], "intensity": {"type": "rgb", "value": 0.7}},
    "spot": lambda place: {
        "type": "spot",
        "to_world": mi.ScalarTransform4f().look_at(origin=[*place, 2.0], target=[0, 0, 0], up=[0, 1, 0]),
        "intensity": 3.0,
    },
    "sun": lambda place: {"type": "directional", "direction": [0.3, 0.2, -1.0], "irradiance": 0.4},
    "sky": lambda place: {"type": "constant", "radiance": {"type": "rgb", "value": [0.2, 0.3, 0.4]}},
    "sky picture": lambda place: {"type": "envmap", "bitmap": sky(), "to_world": mi.ScalarTransform4f()},
}


def sky():
    """Return a picture of a sky with a bright spot."""
    picture = np.full((16, 32, 3), 0.1, np.float32)
    picture[3:5, 7:10] = (8, 6, 4)
    return mi.Bitmap(picture)


def half_black(brightness):
    """Return a picture (16, 32, 3) of which one half and single pixels of the other are black."""
    picture = np.full((16, 32, 3), brightness, np.float32)
    picture[:, 16:], picture[::3, ::5] = 0, 0
    return picture


def bitmap_of(picture):
    """Return a texture that shows a picture as it is."""
    return {"type": "bitmap", "bitmap": mi.Bitmap(picture), "raw": True, "filter_type": "nearest"}


def scene_with_lights(*kinds, size=(16, 12), **more):
    """Return a floor, a wall and a glossy ball under lights of these kinds, at places that differ."""
    random = np.random.default_rng(len(kinds))
    shapes = {f"light{k}": MAKE[kind](random.uniform(-1.5, 1.5, 2).tolist()) for k, kind in enumerate(kinds)}
    return mi.load_dict(
        {
            "type": "scene",
            "integrator": {"type": "path", "max_depth": 5},
            "sensor": {
                "type": "perspective",
                "to_world": mi.ScalarTransform4f().look_at(origin=[0, -5, 2.5], target=[0, 0, 0.5], up=[0, 0, 1]),
                "film": {"type": "hdrfilm", "width": size[0], "height": size[1], "rfilter": {"type": "box"}},
            },
            "floor": {"type": "rectangle", "to_world": mi.ScalarTransform4f().scale(2.0)},
            "wall": {
                "type": "cube",
                "to_world": mi.ScalarTransform4f().translate([0.3, 0.5, 0.5]).scale([0.05, 1.0, 0.5]),
            },
            "ball": {
                "type": "sphere",
                "center": [-0.7, -0.3, 0.4],
                "radius": 0.4,
                "bsdf": {"type": "roughconductor", "alpha": 0.2},
            },
            **shapes,
            **more,
        }
    )

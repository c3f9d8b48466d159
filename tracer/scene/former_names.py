"""What to use instead of names that Mitsuba 3 does not know: those of Mitsuba 0.6 and before, and of other programs.

Renamed parameters are not here. In files with version="0.6.0" Mitsuba renames them itself; for other files the error
message offers the nearest name.
"""

from __future__ import annotations

import re

import numpy as np

from tracer.image.colour import decode_srgb

FORMATS = "Mitsuba reads meshes from 'ply', 'obj' and 'serialized' files, so convert it to one of these"
"""What to do about meshes in formats that Mitsuba does not read."""
LEAVE_OUT = "leave it out"
"""What to do about parameters that have no successor."""

PLUGINS: dict[str, dict[str, str]] = {
    "integrator": {
        **dict.fromkeys(("bdpt", "mlt", "pssmlt", "erpt"), "use 'path', or 'volpath' where there are media"),
        **dict.fromkeys(("photonmapper", "ppm", "sppm", "vpl", "irrcache"), "use 'path'"),
        "volpath_simple": "use 'volpath'",
        "ao": "use 'path' in a scene whose only light is a 'constant' emitter",
        **dict.fromkeys(("multichannel", "field"), "use 'aov'"),
    },
    "bsdf": {
        **dict.fromkeys(("phong", "ward"), "use 'roughplastic', or 'roughconductor' for a metal"),
        **dict.fromkeys(("coating", "roughcoating"), "use 'principled' with its clearcoat"),
        **dict.fromkeys(("roughdiffuse", "lambertian"), "use 'diffuse'"),
        "microfacet": "use 'roughplastic'",
        "mixturebsdf": "use 'blendbsdf', one in another for more than two materials",
        "difftrans": "use 'principledthin' with its diff_trans",
        "hk": "use a medium in the shape, and the integrator 'volpath'",
        "irawan": "use 'principled' with its sheen",
    },
    "texture": {
        **dict.fromkeys(("ldrtexture", "exrtexture"), "use 'bitmap'"),
        "gridtexture": "use 'checkerboard', or 'bitmap' with a picture of the grid",
        "scale": "scale the colours or the picture itself",
        "vertexcolors": "use 'mesh_attribute' with the name vertex_color",
        **dict.fromkeys(("wireframe", "curvature"), "use 'bitmap' with a picture of it"),
    },
    "emitter": {
        **dict.fromkeys(("sky", "sun"), "use 'sunsky'"),
        "collimated": "use 'directionalarea' on a small 'disk'",
    },
    "sensor": {
        "telecentric": "use 'orthographic'",
        "spherical": "use several 'perspective' sensors",
        "fluencemeter": "use 'irradiancemeter'",
        "perspective_rdist": "use 'perspective', which does not distort",
    },
    "sampler": dict.fromkeys(("halton", "hammersley", "sobol"), "use 'owen_sobol'"),
    "film": dict.fromkeys(("ldrfilm", "tiledhdrfilm", "mfilm", "exrfilm", "pngfilm"), "use 'hdrfilm'"),
    "shape": {
        "hair": "use 'bsplinecurve' or 'linearcurve'",
        "heightfield": "convert it to a mesh",
        "deformable": "use one mesh of it, as nothing moves in Mitsuba 3",
        **dict.fromkeys(("stl", "off", "gltf", "glb", "fbx", "dae", "x3d", "abc", "usd"), FORMATS),
    },
    "phase": {
        **dict.fromkeys(("kkay", "microflake"), "use 'sggx'"),
        "mixturephase": "use 'blendphase'",
    },
    "volume": {
        **dict.fromkeys(("volcache", "hgridvolume"), "use 'gridvolume'"),
    },
}
"""What to do instead of using a plugin, by its kind and name."""

PARAMETERS: dict[str, dict[str, str]] = {
    "integrator": {"strict_normals": LEAVE_OUT},
    "film": {"high_quality_edges": "it is now 'sample_border'", "attach_log": LEAVE_OUT, "banner": LEAVE_OUT},
    "sampler": dict.fromkeys(("dimension", "scramble"), LEAVE_OUT),
    "sensor": {"kc": LEAVE_OUT},
    "shape": {
        "srgb": "leave it out, and store linear vertex colours in the file",
        "collapse": LEAVE_OUT,
        "max_smooth_angle": "store the normals in the file, or set 'face_normals'",
    },
    "texture": {
        "gamma": "set 'raw' to true for a picture that is not encoded for a screen",
        **dict.fromkeys(("max_anisotropy", "cache"), LEAVE_OUT),
    },
    "emitter": {"gamma": LEAVE_OUT, "cache": LEAVE_OUT},
    "bsdf": {"ext_eta": "divide 'eta' and 'k' by it"},
    "medium": {
        **dict.fromkeys(
            ("sigma_s", "sigma_a"), "give 'sigma_t', which is sigma_s + sigma_a, and 'albedo', sigma_s / sigma_t"
        ),
        "material": "give 'sigma_t' and 'albedo' of it",
        "density": "it is now 'sigma_t'",
        **dict.fromkeys(("method", "step_size"), LEAVE_OUT),
    },
}
"""What to do instead of using a parameter, by kind of its plugin and by its name as Mitsuba 3 would write it."""

ELEMENTS = {
    "srgb": "use <rgb> with three linear numbers, each of the encoded v being ((v + 0.055) / 1.055)^2.4",
    "xyz": "use <rgb> with the same colour",
    "blackbody": 'use <spectrum type="blackbody"> with its <float name="temperature">',
    "subsurface": "use a medium in the shape, and the integrator 'volpath'",
    "animation": "use one <transform>, as nothing moves in Mitsuba 3",
    "luminaire": "use <emitter>",
    "camera": "use <sensor>",
}
"""What to do instead of using an XML element, by its name."""


def former_plugin(kind: str | None, name: str) -> str | None:
    """Return what to use instead of a plugin, or None if nothing is known of it. ``kind`` None means any kind."""
    kinds = PLUGINS if kind is None else {kind: PLUGINS.get(kind, {})}
    return next((plugins[name] for plugins in kinds.values() if name in plugins), None)


def former_parameter(kind: str, name: str) -> str | None:
    """Return what to do about a parameter of a plugin of this ``kind``, or None if nothing is known of it."""
    return PARAMETERS.get(kind, {}).get(re.sub(r"(?<=[a-z])([A-Z])", r"_\1", name).lower())


def linear_colour(code: str) -> str | None:
    """Return a screen colour "#rrggbb" as three linear numbers, the way <rgb> takes them; None for other text."""
    if not re.fullmatch(r"#[0-9a-fA-F]{6}", code):
        return None
    return ", ".join(f"{value:.4g}" for value in decode_srgb(np.array(list(bytes.fromhex(code[1:]))) / 255))

"""Make Mitsuba's shapes of the parts of a mesh file."""

from __future__ import annotations

from typing import Any

import mitsuba as mi
import numpy as np

from tracer.core.device import upload
from tracer.image.colour import decode_srgb, encode_srgb
from tracer.scene.parts import Material, Part

TAKEN = ("type", "id", "integrator", "sensor", "sky", "lamp")
"""Words that mean something else where a scene is described."""


def shapes_of(parts: list[Part]) -> dict[str, Any]:
    """Return a Mitsuba shape for each part, by its identifier. Parts of equal materials share one BSDF."""
    bsdfs: dict[Any, Any] = {}
    shapes = {}
    for part in parts:
        key = key_of(part)
        if key not in bsdfs:
            name = part.material.name or f"material{len(bsdfs)}"
            bsdfs[key] = mi.load_dict({**bsdf_of(part.material, part.places is not None), "id": name})
        shapes[identifier_of(part.name)] = mesh_of(part, bsdfs[key])
    return shapes


def identifier_of(name: str) -> str:
    """Return the name of a part as Mitsuba allows it for an object: without dots, and no word of its own."""
    return name.replace(".", "_") + ("_" if name in TAKEN else "")


def key_of(part: Part) -> Any:
    """Return what is equal for parts whose BSDF is the same."""
    material, has_places = part.material, part.places is not None
    texture = None if material.texture is None or not has_places else material.texture.tobytes()
    return material.name, material.colour, material.metallic, material.roughness, texture


def bsdf_of(material: Material, has_places: bool) -> dict[str, Any]:
    """Return a BSDF for a material, seen from both sides; its texture is left out if there are no places in it."""
    colour: dict[str, Any] = {"type": "rgb", "value": [min(max(value, 0.0), 1.0) for value in material.colour]}
    if material.texture is not None and has_places:
        picture: Any = material.texture
        if min(material.colour) < 1:  # the factor is linear, and the picture is encoded
            picture = encode_srgb(decode_srgb(picture) * np.array(material.colour))
        bitmap = mi.Bitmap(np.round(255 * np.clip(picture, 0, 1)).astype(np.uint8), mi.Bitmap.PixelFormat.RGB)
        colour = {"type": "bitmap", "bitmap": bitmap}
    if material.metallic == 0 and material.roughness >= 0.99:
        return {"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": colour}}
    surface = {
        "type": "principled",
        "base_color": colour,
        "metallic": min(max(material.metallic, 0.0), 1.0),
        "roughness": min(max(material.roughness, 0.03), 1.0),
    }
    return {"type": "twosided", "bsdf": surface}


def mesh_of(part: Part, bsdf: Any) -> Any:
    """Return a part as an ``mi.Mesh``."""
    properties = mi.Properties()
    properties["mesh_bsdf"] = bsdf
    has_places = part.places is not None
    mesh = mi.Mesh(
        part.name,
        vertex_count=len(part.vertices),
        face_count=len(part.faces),
        has_vertex_normals=part.normals is not None,
        has_vertex_texcoords=has_places,
        props=properties,
    )
    parameters = mi.traverse(mesh)
    parameters["vertex_positions"] = upload(mi.Float, part.vertices.ravel())
    if part.normals is not None:
        parameters["vertex_normals"] = upload(mi.Float, part.normals.ravel())
    if part.places is not None:
        # Mitsuba counts rows of a picture from above.
        flipped = np.column_stack([part.places[:, 0], 1 - part.places[:, 1]])
        parameters["vertex_texcoords"] = upload(mi.Float, flipped.ravel())
    parameters["faces"] = upload(mi.UInt32, part.faces.ravel())
    parameters.update()
    for name, values in part.attributes.items():
        mesh.add_attribute(name, values.shape[1], upload(mi.Float, values.ravel()))
    return mesh

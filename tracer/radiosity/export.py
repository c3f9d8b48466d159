"""Write patches with their light, for programs that show meshes: VTK for ParaView, and glTF.

A VTU file has the arrays ``radiosity``, ``irradiance``, ``emitted`` and ``albedo`` (red, green and blue, W/m^2 or a
share), ``illuminance`` (lux), ``area``, ``shape`` and ``material`` (numbers) of each patch; its field data has an array
"shape NAME" or "material NAME" for each name, whose only entry is the number. A GLB file has a mesh for each shape
and side, named after it, with the attributes ``_RADIOSITY``, ``_IRRADIANCE`` and ``_ILLUMINANCE`` of its corners.
Patches share no corners there, so that each keeps its own values. Its colours show the light that leaves, unlit.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np

from tracer.core.arrays import Floats, Integers
from tracer.core.extras import require_package
from tracer.io import atomic
from tracer.radiosity.patches import Patches
from tracer.radiosity.photometry import side_of_patches
from tracer.radiosity.placed_cells import cells_of_patches, placed_cells, shapes_with_faces
from tracer.radiosity.smooth import corner_numbers
from tracer.scene.shape_names import label_of, material_name

SUFFIXES = (".vtu", ".glb")
"""Suffixes of files of patches."""
WHITE = 99.0
"""Percentile of the radiosity of patches that do not shine which colours show as white."""


def check_export(path: Path) -> None:
    """Raise MissingPackageError if a package is not installed that a file of this name needs."""
    if path.suffix.lower() == ".vtu":
        require_package("meshio", "meshio", f"'{path}' is a VTK file, and writing it", "radiosity")


def write_patches(path: Path, patches: Patches, radiosity: Floats, irradiance: Floats, lux: Floats) -> None:
    """Write patches by the suffix of ``path``. Raises WriteError.

    ``radiosity`` and ``irradiance`` (P, 3): power per area that leaves and arrives; ``lux`` (P,): illuminance.
    """
    write = write_vtu if path.suffix.lower() == ".vtu" else write_glb
    with atomic.whole(path) as temporary:
        write(temporary, patches, radiosity, irradiance, lux)


def write_vtu(path: Path, patches: Patches, radiosity: Floats, irradiance: Floats, lux: Floats) -> None:
    """Write patches as an unstructured grid of VTK; see the documentation of this file."""
    import meshio

    corners, _, shape_of_cell = placed_cells(patches)
    cell, corner = cells_of_patches(patches), corner_numbers(patches)
    points: Floats = np.zeros((int(corner.max()) + 1, 3))
    points[corner] = corners[cell]
    shape = shape_of_cell[cell]
    shapes = shapes_with_faces(patches)
    materials = [material_name(found.bsdf()) for found in shapes]
    names = list(dict.fromkeys(materials))
    columns = {
        "radiosity": radiosity,
        "irradiance": irradiance,
        "illuminance": lux,
        "emitted": patches.emitted,
        "albedo": patches.albedo,
        "area": patches.areas,
        "shape": shape + 1,
        "material": np.array([names.index(name) for name in materials])[shape] + 1,
    }
    # On its back a patch goes round the other way, so that its normal points to where its light goes.
    is_back = np.arange(len(patches)) >= len(corners)
    triangles = np.where(is_back[:, None], corner[:, ::-1], corner)
    data = {name: [np.ascontiguousarray(column)] for name, column in columns.items()}
    meshio.Mesh(points, [("triangle", triangles)], cell_data=data).write(path, file_format="vtu")
    fields = {f"shape {label_of(found, number)}": number for number, found in enumerate(shapes, 1)}
    fields |= {f"material {name or 'without a name'}": number for number, name in enumerate(names, 1)}
    add_fields(path, fields)


def add_fields(path: Path, fields: dict[str, int]) -> None:
    """Add field data to a VTU file: an array of one number for each name. The library reads such, but writes none."""
    tree = ElementTree.parse(path)
    grid = tree.getroot().find("UnstructuredGrid")
    assert grid is not None
    data = ElementTree.Element("FieldData")
    for name, number in fields.items():
        about = {"type": "Int32", "Name": name, "NumberOfTuples": "1", "format": "ascii"}
        ElementTree.SubElement(data, "DataArray", about).text = str(number)
    grid.insert(0, data)
    tree.write(path, xml_declaration=True, encoding="utf-8")


def write_glb(path: Path, patches: Patches, radiosity: Floats, irradiance: Floats, lux: Floats) -> None:
    """Write patches as glTF; see the documentation of this file."""
    import trimesh

    corners = placed_cells(patches)[0][cells_of_patches(patches)]
    side, shapes = side_of_patches(patches), shapes_with_faces(patches)
    colours = colours_of(patches, radiosity)
    scene = trimesh.Scene()
    for number in np.unique(side).tolist():
        chosen = np.flatnonzero(side == number)
        shape, is_back = shapes[number // 2], number % 2 == 1
        name = label_of(shape, number // 2 + 1) + (", back" if is_back else "")
        triangles: Integers = np.arange(3 * len(chosen)).reshape(-1, 3)
        columns = {"_RADIOSITY": radiosity, "_IRRADIANCE": irradiance, "_ILLUMINANCE": lux}
        mesh = trimesh.Trimesh(
            corners[chosen].reshape(-1, 3),
            triangles[:, ::-1] if is_back else triangles,
            vertex_colors=np.repeat(colours[chosen], 3, axis=0),
            vertex_attributes={
                name: np.repeat(column[chosen], 3, axis=0).astype(np.float32) for name, column in columns.items()
            },
            metadata={"material": material_name(shape.bsdf())},
            process=False,
        )
        scene.add_geometry(mesh, node_name=name, geom_name=name)
    path.write_bytes(scene.export(file_type="glb", tree_postprocessor=unlit))


def colours_of(patches: Patches, radiosity: Floats) -> Any:
    """Return the colours (P, 4) of patches, linear as in glTF, 0 to 255; white is the percentile ``WHITE``."""
    is_dark = patches.emitted.max(axis=1) == 0
    brightest = radiosity.max(axis=1)
    white = float(np.percentile(brightest[is_dark] if is_dark.any() else brightest, WHITE)) or 1.0
    colours = np.round(255 * np.clip(radiosity / white, 0, 1)).astype(np.uint8)
    return np.column_stack([colours, np.full(len(colours), 255, np.uint8)])


def unlit(tree: dict[str, Any]) -> None:
    """Give the meshes of a glTF file a material that shows their colours as they are (KHR_materials_unlit)."""
    name = "KHR_materials_unlit"
    tree["extensionsUsed"] = sorted({*tree.get("extensionsUsed", []), name})
    plain = {"pbrMetallicRoughness": {"metallicFactor": 0.0, "roughnessFactor": 1.0}, "extensions": {name: {}}}
    tree["materials"] = [plain]
    for mesh in tree["meshes"]:
        for primitive in mesh["primitives"]:
            primitive["material"] = 0

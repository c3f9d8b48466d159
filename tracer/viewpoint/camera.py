"""Views as sensors of Mitsuba."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import mitsuba as mi
import numpy as np

from tracer import files
from tracer.viewpoint.item_buffer import Viewpoints
from tracer.viewpoint.lens import Lens, Orthographic, Perspective


def sensors(viewpoints: Viewpoints, lens: Lens, size: int = 512) -> list[dict[str, Any]]:
    """Return a Mitsuba sensor, as dictionary, for each view; the image is ``size`` pixels wide and high.

    Raises ValueError for a lens that is no camera.
    """
    found = []
    for eye, forward, up in zip(viewpoints.eyes, viewpoints.forward, viewpoints.up, strict=True):
        place = mi.ScalarTransform4f().look_at(eye.tolist(), (eye + forward).tolist(), up.tolist())
        film = {"type": "hdrfilm", "width": size, "height": size}
        if isinstance(lens, Orthographic):
            scaled = place @ mi.ScalarTransform4f().scale([lens.reach, lens.reach, 1.0])
            found.append({"type": "orthographic", "to_world": scaled, "film": film})
        elif isinstance(lens, Perspective):
            found.append({"type": "perspective", "fov": lens.field_of_view, "to_world": place, "film": film})
        else:
            raise ValueError("a view of all directions is no camera")
    return found


def write_sensors(path: Path, viewpoints: Viewpoints, lens: Lens, size: int = 512) -> None:
    """Write the views as a Mitsuba file of sensors, for ``<include filename="..."/>`` in a scene."""
    lines = ['<scene version="3.0.0">']
    for sensor in sensors(viewpoints, lens, size):
        matrix = " ".join(f"{value:.9g}" for value in np.array(sensor["to_world"].matrix).ravel())
        fov = f'        <float name="fov" value="{sensor["fov"]:.9g}"/>' if "fov" in sensor else None
        lines += [
            f'    <sensor type="{sensor["type"]}">',
            *([fov] if fov else []),
            f'        <transform name="to_world"><matrix value="{matrix}"/></transform>',
            '        <sampler type="independent"/>',
            '        <film type="hdrfilm">',
            f'            <integer name="width" value="{size}"/>',
            f'            <integer name="height" value="{size}"/>',
            "        </film>",
            "    </sensor>",
        ]
    files.write_text(path, "\n".join([*lines, "</scene>", ""]))

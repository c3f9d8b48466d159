"""Views as Mitsuba sensors."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import mitsuba as mi
import numpy as np

from tracer.io import atomic
from tracer.viewpoint.item_buffer import Viewpoints
from tracer.viewpoint.lens import Lens, Orthographic, Perspective


def sensors(
    viewpoints: Viewpoints, lens: Lens, size: int = 512, clip: tuple[float, float] | None = None
) -> list[dict[str, Any]]:
    """Return a Mitsuba sensor for each view, as a dictionary; its image is ``size`` pixels wide and high.

    ``clip``: nearest and farthest distance that is seen; by default Mitsuba's own, 0.01 and 10000.
    Raises ValueError for a lens that is no camera.
    """
    dictionaries = []
    clip_planes = {} if clip is None else {"near_clip": clip[0], "far_clip": clip[1]}
    for eye, forward, right, up in zip(
        viewpoints.eyes, viewpoints.forward, viewpoints.right, viewpoints.up, strict=True
    ):
        # Not made by look_at: far from the origin, single precision cannot tell a target next to the eye from the eye.
        to_world = mi.ScalarTransform4f(
            np.vstack([np.column_stack([-right, up, forward, eye]), [0.0, 0, 0, 1]]).tolist()
        )
        film = {"type": "hdrfilm", "width": size, "height": size}
        if isinstance(lens, Orthographic):
            scaled = to_world @ mi.ScalarTransform4f().scale([lens.reach, lens.reach, 1.0])
            dictionaries.append({"type": "orthographic", "to_world": scaled, "film": film, **clip_planes})
        elif isinstance(lens, Perspective):
            dictionaries.append(
                {"type": "perspective", "fov": lens.field_of_view, "to_world": to_world, "film": film, **clip_planes}
            )
        else:
            raise ValueError("a view of all directions is no camera")
    return dictionaries


def write_sensors(
    path: Path, viewpoints: Viewpoints, lens: Lens, size: int = 512, clip: tuple[float, float] | None = None
) -> None:
    """Write the views as a Mitsuba file of sensors, for ``<include filename="..."/>`` in a scene."""
    lines = ['<scene version="3.0.0">']
    for sensor in sensors(viewpoints, lens, size, clip):
        matrix = " ".join(f"{value:.9g}" for value in np.array(sensor["to_world"].matrix).ravel())
        numbers = [name for name in ("fov", "near_clip", "far_clip") if name in sensor]
        lines += [
            f'    <sensor type="{sensor["type"]}">',
            *(f'        <float name="{name}" value="{sensor[name]:.9g}"/>' for name in numbers),
            f'        <transform name="to_world"><matrix value="{matrix}"/></transform>',
            '        <sampler type="independent"/>',
            '        <film type="hdrfilm">',
            f'            <integer name="width" value="{size}"/>',
            f'            <integer name="height" value="{size}"/>',
            "        </film>",
            "    </sensor>",
        ]
    atomic.write_text(path, "\n".join([*lines, "</scene>", ""]))

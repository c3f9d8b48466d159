"""Check what Mitsuba does not check of a scene, although it would crash or read memory that is not its own."""

from __future__ import annotations

from typing import Any

import numpy as np

from tracer.errors import SceneError


def require_sources(subject: str, state: Any) -> None:
    """Raise SceneError for a bitmap of a parsed scene that names no picture: Mitsuba crashes over it."""
    for node in state.nodes:
        if node.props.plugin_name() == "bitmap" and not any(
            name in node.props for name in ("filename", "bitmap", "data")
        ):
            raise SceneError(f"{subject} has a 'bitmap' without a picture; give it a filename.")


def require_faces(subject: str, scene: Any) -> None:
    """Raise SceneError for a mesh whose faces use vertices that it does not have."""
    if scene.class_name() != "Scene":
        return
    for shape in scene.shapes():
        if not shape.is_mesh() or not shape.face_count():
            continue
        last = int(np.max(shape.faces_buffer().numpy()))
        if last >= shape.vertex_count():
            raise SceneError(
                f"{subject} has a mesh '{shape.id()}' with faces that use vertex {last}, counted from 0, "
                f"and only {shape.vertex_count()} vertices; export it anew."
            )

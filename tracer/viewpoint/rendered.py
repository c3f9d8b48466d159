"""Pictures of views in the light of the scene, rendered adaptively."""

from __future__ import annotations

import mitsuba as mi
import numpy as np

from tracer.core.arrays import Floats
from tracer.errors import SceneError
from tracer.image.colour import encode_srgb
from tracer.session.render import render_request
from tracer.session.request import Request
from tracer.settings import make_settings
from tracer.viewpoint.camera import sensors
from tracer.viewpoint.item_buffer import Viewpoints
from tracer.viewpoint.lens import Lens
from tracer.viewpoint.surfaces import Subject


def render_views(
    subject: Subject, viewpoints: Viewpoints, lens: Lens, size: int, spp: int, clip: tuple[float, float] | None = None
) -> list[Floats]:
    """Return a picture (size, size, 3) of each view in [0, 1], encoded as sRGB, with ``spp`` samples per pixel.

    Pictures are rendered with the scene's own integrator. The lens must be one that ``stand`` makes, with a square
    image: orthographic or perspective. Raises SceneError for a scene without light.
    """
    require_light(subject)
    pictures = []
    for sensor in sensors(viewpoints, lens, size, clip):
        settings = make_settings(spp=spp, objective="display")
        image = render_request(Request(subject.scene, settings, sensor=mi.load_dict(sensor))).image
        pictures.append(np.asarray(encode_srgb(np.clip(np.nan_to_num(image[..., :3]), 0, 1))))
    return pictures


def require_light(subject: Subject) -> None:
    """Raise SceneError for a scene without light."""
    if not subject.scene.emitters():
        raise SceneError("There is no light in the scene to render with; without --spp, pictures are lit from the eye.")

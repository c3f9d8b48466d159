"""The width of a picture from the scene file alone: to make the objects of a large scene takes a minute."""

from __future__ import annotations

from itertools import takewhile
from pathlib import Path

import mitsuba as mi

from tracer.scene.load import parse, properties

USUAL_WIDTH = 768
"""Width in pixels of Mitsuba's films where a scene says nothing."""


def film_width(path: Path, sensor: int = 0) -> int | None:
    """Return the width in pixels of the picture of a sensor, by number; None if there is no such sensor.

    Raises SceneError for a file that cannot be read.
    """
    nodes = parse(path).state.nodes
    sensors = [place for place, node in enumerate(nodes) if node.type == mi.ObjectType.Sensor]
    if sensor >= len(sensors):
        return None
    within = takewhile(lambda node: node.type != mi.ObjectType.Sensor, nodes[sensors[sensor] + 1 :])
    film = next((node for node in within if node.type == mi.ObjectType.Film), None)
    sizes = {} if film is None else dict(properties(path, film))
    return int(sizes.get("crop_width", sizes.get("width", USUAL_WIDTH)))

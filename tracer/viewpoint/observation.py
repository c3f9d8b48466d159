"""What a measure is given: a view, and if it needs them the neighbours of the view and the channel of all views."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from tracer.core.arrays import Floats, Integers
from tracer.viewpoint.channel import Channel
from tracer.viewpoint.surfaces import Subject


@dataclass(frozen=True)
class Picture:
    """A view as an image (H, W)."""

    hit: NDArray[np.bool_]
    """Where a surface is seen."""
    depth: NDArray[np.float32]
    """Depth along the view: 0 where the sphere around the subject begins, 1 where it ends; NaN for background."""


@dataclass(frozen=True)
class Sight:
    """What is seen from one viewpoint."""

    subject: Subject
    surfaces: Integers
    """(K,): the surfaces that are seen, ascending."""
    projected: Floats
    """(K,): their projected areas, all > 0."""
    image_area: float
    """Area of the image, in the unit of ``projected``."""
    background: bool = True
    """Whether the background counts as a surface in entropy."""
    picture: Picture | None = None
    vertices: Integers | None = None
    """(K,): vertices of meshes that are seen, as ``Mesh.joined`` numbers them."""
    channel: Channel | None = None
    neighbours: list[Sight] = field(default_factory=list)

    @property
    def total(self) -> float:
        """Projected area a_t of all that is seen."""
        return float(self.projected.sum())

    @property
    def weights(self) -> Floats:
        """(K,): how much each surface that is seen counts."""
        return self.subject.weights[self.surfaces]

    @property
    def weighted(self) -> Floats:
        """(K,): projected areas times weights."""
        return self.projected * self.weights

    @property
    def shares(self) -> Floats:
        """(K,): p(z|v) = a_z / a_t; empty where nothing is seen."""
        return self.projected / self.total if len(self.projected) else self.projected


def sight_of(subject: Subject, areas: NDArray, image_area: float, background: bool = True) -> Sight:
    """Return what is seen in a view with the projected ``areas`` (Z,) of all surfaces."""
    seen = np.flatnonzero(areas)
    return Sight(subject, seen, areas[seen].astype(np.float64), image_area, background)

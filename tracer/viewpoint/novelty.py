"""What a camera has not seen yet, so that it can look there."""

from __future__ import annotations

import numpy as np

from tracer.core.arrays import Floats
from tracer.viewpoint.inside import COARSE_SIDE, LENS, Pose, viewpoints_of
from tracer.viewpoint.item_buffer import Rays, projected_areas
from tracer.viewpoint.room import Room
from tracer.viewpoint.surfaces import Subject


class Memory:
    """How large each surface was at most in the views so far, in the unit of the lens."""

    def __init__(self, subject: Subject, room: Room) -> None:
        self.subject, self.room, self.rays = subject, room, Rays(side=COARSE_SIDE)
        self.largest = np.zeros(subject.count, np.float32)

    def new_share(self, pose: Pose) -> Floats:
        """Return the share (N,) of the entropy of views that is new, as far as surfaces are larger than they ever were.

        The entropy of a view is a sum over surfaces, to which small ones, such as pictures on a wall, add more than
        their areas do. Surfaces count by their weights.
        """
        views, shares = viewpoints_of(self.room, pose), [np.zeros(0)]
        for batch in projected_areas(self.subject, views, LENS, self.rays):
            part = np.minimum(batch.areas / np.float32(LENS.image_area), 1)
            terms = -part * np.log2(np.maximum(part, 1e-30)) * self.subject.weights.astype(np.float32)
            new = np.maximum(1 - self.largest / np.maximum(batch.areas, 1e-30), 0)
            shares.append((terms * new).sum(axis=1) / np.maximum(terms.sum(axis=1), 1e-30))
        return np.concatenate(shares)

    def remember(self, pose: Pose) -> None:
        """Take in what poses see."""
        for batch in projected_areas(self.subject, viewpoints_of(self.room, pose), LENS, self.rays):
            self.largest = np.maximum(self.largest, batch.areas.max(axis=0))

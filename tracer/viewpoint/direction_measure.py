"""A measure as a function of the direction to look from, which a search can evaluate for many directions at once."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from tracer.core.arrays import Floats, Integers
from tracer.core.sphere import frame, icosphere, normalised
from tracer.viewpoint import measures
from tracer.viewpoint.channel import Channel
from tracer.viewpoint.fast import Estimate, estimate_entropy
from tracer.viewpoint.item_buffer import Rays, Viewpoints, around
from tracer.viewpoint.lens import Lens, Orthographic, Perspective
from tracer.viewpoint.surfaces import Subject
from tracer.viewpoint.survey import better, sum_up, survey

DISTANCE = 6.0
"""A viewpoint is this many radii from the centre, as in the survey; the sphere around the subject fills the image."""
RING, RING_ANGLE = 6, np.radians(9.0)
"""A view is compared with RING views beside it, at RING_ANGLE in radians: as on an icosphere of 642 viewpoints."""
SHARE = "projected_area"
"""The measure of this name tells whether a view sees anything."""
CHANNEL_LEVEL = 3
"""Measures that need all views compare with the viewpoints of an icosphere of this level."""


@dataclass(frozen=True)
class Stand:
    """What a view looks at, from what distance, and through which lens: all but its direction."""

    centre: Floats
    distance: float
    lens: Lens
    up: Floats

    radius: float = 0.0
    """Radius of the sphere around the centre that holds the subject."""

    def viewpoints(self, directions: Floats) -> Viewpoints:
        """Return viewpoints in directions (V, 3) from the centre."""
        return around(self.centre, self.distance, directions, self.up)

    @property
    def clip(self) -> tuple[float, float]:
        """Nearest and farthest distance along the view at which a part of the subject may be."""
        return max(self.distance - 1.1 * self.radius, 1e-3 * self.distance), self.distance + 1.1 * self.radius


def stand(
    subject: Subject,
    distance: float | None = None,
    centre: Floats | None = None,
    up: Floats | tuple[float, float, float] = (0.0, 0.0, 1.0),
    orthographic: bool = False,
) -> Stand:
    """Return where to stand so that the sphere around the subject fills the image.

    ``distance`` is in units of length, by default six radii. The field of view is at most 120 degrees, so the sphere
    does not fit if the viewpoint is too near.
    """
    centre = subject.centre if centre is None else np.asarray(centre, np.float64)
    radius = max(subject.radius + float(np.linalg.norm(centre - subject.centre)), 1e-12)
    distance = DISTANCE * radius if distance is None else distance
    if orthographic:
        return Stand(centre, distance, Orthographic(radius), np.asarray(up, np.float64), radius)
    half = np.degrees(np.arcsin(min(radius / distance, np.sin(np.radians(60)))))
    return Stand(centre, distance, Perspective(float(2 * half)), np.asarray(up, np.float64), radius)


@dataclass
class Gauge:
    """The values of a measure by direction."""

    subject: Subject
    stand: Stand
    rays: Rays
    name: str
    background: bool = True
    good: measures.Best = "most"
    """Whether good views have the most or the least of the measure."""
    evaluations: int = 0
    """Number of views that were measured, including those of a channel."""
    channel: Channel | None = field(default=None, repr=False)
    progress: Callable[[int, int], None] | None = field(default=None, repr=False)
    """Called with the number of views that are done and of all views, in each call of the gauge. May raise to stop."""
    seen: NDArray[np.bool_] = field(default_factory=lambda: np.zeros(0, bool), repr=False)
    """(V,): which views of the last call saw anything."""
    sighted: bool = False
    """Whether any view of any call saw anything."""

    @property
    def measure(self) -> measures.Measure:
        """The measure that is called ``name``."""
        return measures.get(self.name)

    def __call__(self, directions: Floats) -> Floats:
        """Return the values (V,) of the measure from directions (V, 3)."""
        directions = normalised(directions)
        needs = self.measure.needs
        if "channel" in needs and self.channel is None:
            views = self.stand.viewpoints(icosphere(CHANNEL_LEVEL)[0])
            self.channel = sum_up(self.subject, views, self.stand.lens, self.rays, "saliency" in needs, self.tell)
            self.evaluations += len(views)
        count = len(directions)
        beside: list[Integers] | None = None
        if "neighbours" in needs:
            rings = np.concatenate([ring(direction, RING_ANGLE) for direction in directions])
            ring_numbers = count + np.arange(count * RING).reshape(count, RING)
            beside = [*ring_numbers, *np.repeat(np.arange(count), RING)[:, None]]
            directions = np.concatenate([directions, rings])
        self.evaluations += len(directions)
        views = self.stand.viewpoints(directions)
        if self.estimated:
            estimate = self.estimate(views)
            self.note(estimate.covered)
            return estimate.entropy
        values = survey(
            self.subject,
            views,
            self.stand.lens,
            self.rays,
            [self.name, SHARE],
            background=self.background,
            beside=beside,
            channel=self.channel,
            progress=self.progress,
        )
        self.note(values[SHARE][:count])
        return values[self.name][:count]

    def note(self, covered: Floats) -> None:
        """Note which views saw anything; ``covered`` (V,): share of the image that surfaces cover."""
        self.seen = covered > 0
        self.sighted |= bool(self.seen.any())

    @property
    def estimated(self) -> bool:
        """Whether values have a standard error: those of entropy from random rays."""
        return self.rays.random > 0 and self.name == "entropy"

    def estimate(self, views: Viewpoints) -> Estimate:
        """Return the entropy of views from random rays."""
        return estimate_entropy(self.subject, views, self.stand.lens, self.rays.random, self.rays.seed, self.background)

    def tell(self, done: int) -> None:
        """Report how many views of a channel are done."""
        if self.progress is not None:
            self.progress(done, len(icosphere(CHANNEL_LEVEL)[0]))

    @property
    def sign(self) -> int:
        """1 if more is better, else -1."""
        return 1 if self.good == "most" else -1

    def better(self, directions: Floats) -> Floats:
        """Return the values (V,), negated if less is better, so that more is better; -inf if a view sees nothing."""
        values = self(directions)
        return better(values, self.seen, self.good)


def ring(direction: Floats, angle: float) -> Floats:
    """Return six directions (6, 3) at ``angle`` in radians around ``direction`` (3,)."""
    right, up = frame(direction)
    turn = np.arange(RING) * (2 * np.pi / RING)
    sideways = np.cos(turn)[:, None] * right + np.sin(turn)[:, None] * up
    return np.cos(angle) * direction + np.sin(angle) * sideways

"""An estimate whose sums are with workers; here is only what decisions are made from."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tracer.cluster.work_balancer import Region
from tracer.cluster.worker_setup import Work
from tracer.core.arrays import Counts
from tracer.film.estimate import Estimate, Statistics
from tracer.sampling.wavefront import Stretch
from tracer.scene.frame import Frame

Gather = Callable[["Held"], Estimate]
Scatter = Callable[[Estimate], list[Region]]


class Held(Estimate):
    """Sums of a frame, by regions, in the hands of workers."""

    def __init__(self, view: Frame, moments: int, peaks: int, gather: Gather, scatter: Scatter) -> None:
        """``gather`` brings all sums here, ``scatter`` takes them to workers."""
        self.view, self.reach = view, view.reach
        self.moments, self.peaks = moments, peaks
        self.gather, self.scatter = gather, scatter
        self.regions = [Region(0, view.pixel_count)]
        self.work: Work | None = None
        """What its samples have in common, once there are any."""
        self.begun: list[NDArray] | None = None
        """Sums of an earlier render that this one goes on from. No worker can draw them again, so they are kept."""
        self.rounds: list[Stretch] = []
        """What was drawn since then, or is being drawn."""
        self.known = nothing(view, moments, peaks)
        self.whole_here: Estimate | None = None

    def learn(self, region: Region, found: Statistics) -> None:
        """Take in the statistics of a region, of a grid of one row."""
        for name, values in vars(found).items():
            mine = getattr(self.known, name)
            mine.reshape(self.view.pixel_count, *mine.shape[2:])[region.pixels] = values[0]
        self.whole_here = None

    def cut(self, parts: list[Region]) -> None:
        """Put the parts of a region in its place."""
        place = next(k for k, region in enumerate(self.regions) if region.first == parts[0].first)
        self.regions[place : place + 1] = parts

    def rounds_of(self, region: Region, goal: Counts) -> list[Stretch]:
        """Return what has to be drawn of a region, so that its pixels go from what there was to ``goal`` (P,)."""
        found = []
        for whole in self.rounds:
            before, after = whole.before[region.pixels], whole.after[region.pixels]
            if np.any(before < after) and np.all(after <= goal):
                found.append(whole.part(region.first, region.size))
        return found

    def statistics(self) -> Statistics:
        """See ``Estimate``."""
        return Statistics(**{name: values.copy() for name, values in vars(self.known).items()})

    def samples(self) -> NDArray[np.uint32]:
        """See ``Estimate``."""
        return self.known.count[self.view.inner].copy()

    def drawn(self) -> NDArray[np.uint32]:
        """See ``Estimate``."""
        return self.known.count + self.known.invalid

    def here(self) -> Estimate:
        """Return an estimate in this process with the sums of all workers. Raises ClusterError."""
        if self.whole_here is None:
            self.whole_here = self.gather(self)
        return self.whole_here

    def develop(self) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """See ``Estimate``."""
        return self.here().develop()

    def state(self) -> list[NDArray]:
        """See ``Estimate``."""
        return self.here().state()

    def restore(self, state: list[NDArray]) -> None:
        """See ``Estimate``."""
        whole = Estimate(self.view, self.moments, self.peaks)
        whole.restore(state)
        self.begun = state[1:]
        self.known = whole.statistics()
        self.regions = self.scatter(whole)
        self.whole_here = whole


def nothing(view: Frame, moments: int, peaks: int) -> Statistics:
    """Return the statistics of no samples."""
    channels = len(view.channels)

    def zeros(*more: int, kind: Any = np.float32) -> NDArray:
        return np.zeros((*view.grid, *more), kind)

    return Statistics(
        count=zeros(kind=np.uint32),
        invalid=zeros(kind=np.uint32),
        mean=zeros(channels),
        variance=zeros(channels),
        rays=zeros(),
        moments=zeros(moments),
        peaks=np.full((*view.grid, peaks), -np.inf, np.float32),
    )

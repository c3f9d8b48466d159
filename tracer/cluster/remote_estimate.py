"""An estimate whose sums are on workers. This process has only the statistics that decisions are made from."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from tracer.cluster.remote_sums import RemoteSums
from tracer.cluster.work_balancer import Region
from tracer.film.estimate import Estimate, Statistics
from tracer.scene.frame import Frame


class SumsKeeper(Protocol):
    """Object that can fetch sums from workers, and send sums to workers."""

    def gather(self, estimate: RemoteEstimate) -> Estimate:
        """Return an estimate in this process with all sums. Raises ClusterError."""

    def scatter(self, whole: Estimate) -> list[Region]:
        """Send sums to workers; return where they are. Raises ClusterError."""


class RemoteEstimate(Estimate):
    """An estimate of a frame whose sums are on workers."""

    def __init__(self, view: Frame, moments: int, peaks: int, keeper: SumsKeeper) -> None:
        """See ``Estimate``; ``keeper`` fetches the sums when they are needed here."""
        self.view, self.reach = view, view.reach
        self.moments, self.peaks = moments, peaks
        self.keeper = keeper
        self.sums = RemoteSums([Region(0, view.pixel_count)])
        self.known = nothing(view, moments, peaks)
        """Statistics of the whole frame, from which decisions are made."""
        self.whole_here: Estimate | None = None
        """The estimate with all sums, if they were fetched and no samples have been drawn since; else None."""

    def learn(self, region: Region, statistics: Statistics) -> None:
        """Note where the sums of a region are now, and its statistics, which are those of a grid of one row."""
        self.sums.put(region)
        for name, values in vars(statistics).items():
            whole = getattr(self.known, name)
            whole.reshape(self.view.pixel_count, *whole.shape[2:])[region.pixels] = values[0]
        self.whole_here = None

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
            self.whole_here = self.keeper.gather(self)
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
        self.known = whole.statistics()
        self.sums.begun = state[1:]
        self.sums.regions = self.keeper.scatter(whole)
        self.whole_here = whole


def nothing(view: Frame, moments: int, peaks: int) -> Statistics:
    """Return the statistics of a frame without samples."""
    channels = len(view.channels)

    def zeros(*more: int, kind: Any = np.float32) -> NDArray:
        return np.zeros((*view.grid, *more), kind)

    return Statistics(
        count=zeros(kind=np.uint32),
        invalid=zeros(kind=np.uint32),
        mean=zeros(channels),
        variance=zeros(channels),
        work=zeros(),
        moments=zeros(moments),
        peaks=np.full((*view.grid, peaks), -np.inf, np.float32),
    )

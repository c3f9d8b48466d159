"""Where the sums of a picture are, and what it takes to draw them again."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tracer.cluster.sums import Sums, packed
from tracer.cluster.units import UnitRequest
from tracer.cluster.work_balancer import Region
from tracer.cluster.worker_setup import RoundSettings
from tracer.core.arrays import Counts
from tracer.sampling.wavefront import Stretch


@dataclass
class RemoteSums:
    """Sums of a picture, by regions, that workers have."""

    regions: list[Region]
    """They cover the picture, one after the other."""
    settings: RoundSettings | None = None
    """What the samples have in common, once there are any."""
    begun: list[NDArray] | None = None
    """Sums of an earlier render that this one goes on from. No worker can draw them again, so they are kept."""
    rounds: list[Stretch] = field(default_factory=list)
    """What was drawn since then, or is being drawn."""

    def put(self, region: Region) -> None:
        """Take note of where the sums of a region are now; it is one of the regions, or a part of one."""
        place, whole = next(
            (place, whole)
            for place, whole in enumerate(self.regions)
            if whole.first <= region.first < whole.first + whole.size
        )
        begin = region.first - whole.first
        end = begin + region.size
        before = [whole.part(0, begin)] if begin > 0 else []
        after = [whole.part(end, whole.size)] if end < whole.size else []
        self.regions[place : place + 1] = [*before, region, *after]

    def rounds_of(self, region: Region, goal: Counts) -> list[Stretch]:
        """Return what has to be drawn of a region, so that its pixels go from what there was to ``goal`` (P,)."""
        stretches = []
        for whole in self.rounds:
            before, after = whole.before[region.pixels], whole.after[region.pixels]
            if np.any(before < after) and np.all(after <= goal):
                stretches.append(whole.part(region.first, region.size))
        return stretches

    def arguments(self, request: UnitRequest) -> tuple[Any, int, int, int, list[Stretch]]:
        """Return the arguments of ``draw_unit`` for a request."""
        region = request.unit.region
        place = region.first, region.size
        if request.needs_sums:
            return region.source, region.skip, *place, [self.rounds[-1].part(*place)]
        # With the unit itself, as a worker that would be given them first may be gone, too.
        begun = None if self.begun is None else {"sums": Sums(None, packed(self.begun, *place))}
        return begun, 0, *place, self.rounds_of(region, request.unit.goal)

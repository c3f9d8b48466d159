"""Where the sums of a picture are, and which samples must be drawn to have them again."""

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
    """The sums of a picture that workers have, by regions."""

    regions: list[Region]
    """Regions that cover the picture, in the order of their pixels."""
    settings: RoundSettings | None = None
    """Settings that all samples have in common; None before the first round."""
    begun: list[NDArray] | None = None
    """Sums (P, ...) of an earlier render that this one goes on from, which workers cannot draw again."""
    rounds: list[Stretch] = field(default_factory=list)
    """Rounds of the whole picture that were drawn since then, or are being drawn."""

    def put(self, region: Region) -> None:
        """Note where the sums of ``region`` are now; its pixels are those of one of the regions, or a part of them."""
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
        """Return the rounds of a region that must be drawn for its pixels to have ``goal`` (P,) samples.

        The first of them goes on from the sums of an earlier render, or from no samples.
        """
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
        # Sums of an earlier render are sent with the unit, as a worker to which they were sent before may be gone, too.
        begun = None if self.begun is None else {"sums": Sums(None, packed(self.begun, *place))}
        return begun, 0, *place, self.rounds_of(region, request.unit.goal)

"""Fetch sums from workers, and send sums to them."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np
from distributed import CancelledError, KilledWorker
from numpy.typing import NDArray

from tracer.cluster.connection import Connection
from tracer.cluster.messages import TICK, Messages, explained
from tracer.cluster.sums import Sums, by_source, packed, write
from tracer.cluster.work_balancer import Region
from tracer.errors import SceneMissingError

AT_ONCE = 16
"""Number of units whose sums are fetched at a time. The sums of one unit are megabytes."""
HANG_SECONDS = 10.0
"""If no sums come for this many seconds, the workers that have the others count as hanging."""


def fetch_sums(
    connection: Connection,
    regions: Sequence[Region],
    silent: Collection[str],
    arrays: Sequence[NDArray],
    came: NDArray[np.bool_],
) -> int:
    """Write the sums of regions into ``arrays`` (P, ...), and mark in ``came`` (P,) the pixels whose sums came.

    Sums of ``silent`` workers are asked for last. Sums that are lost with their worker do not come. Returns the bytes
    that were received. Raises ClusterError.
    """
    messages = Messages(connection)  # a separate inbox, as that of the scheduler is for units
    # Groups are taken from the end of this list, so those of workers that answer stand last.
    groups = sorted(by_source(regions), key=lambda group: group[0].worker not in silent)
    under_way, quiet, byte_count = 0, 0.0, 0
    while (groups or under_way) and quiet < HANG_SECONDS:
        while groups and under_way < AT_ONCE:
            group = groups.pop()
            messages.listen(group[0].source, group)
            under_way += 1
        answers = messages.hear()
        quiet = 0.0 if answers else quiet + TICK
        for group, outcome in answers:
            under_way -= 1
            if isinstance(outcome, CancelledError | KilledWorker | SceneMissingError):
                continue  # lost with its worker, or with one that was to draw it again: the caller has it drawn again
            if isinstance(outcome, BaseException):
                raise explained(outcome) from None
            sums = outcome["sums"].packed()
            byte_count += sums.nbytes
            for region in group:
                write(sums, region, arrays)
                came[region.pixels] = True
    return byte_count


def scatter_sums(connection: Connection, arrays: Sequence[NDArray], parts: int) -> list[Region]:
    """Send the sums (P, ...) of a whole picture to workers in at most ``parts`` pieces; return where they are."""
    pixel_count = len(arrays[0])
    size = -(-pixel_count // parts)
    regions = []
    for first in range(0, pixel_count, size):
        place = first, min(size, pixel_count - first)
        (future,) = connection.client.scatter([{"sums": Sums(None, packed(arrays, *place))}], hash=False)
        regions.append(Region(*place, future))
    return regions

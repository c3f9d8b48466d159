"""Bring sums from workers, and take sums to them."""

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
"""Sums that are fetched at a time, each of megabytes."""
HANG_SECONDS = 10.0
"""If no sums come for so long, whoever has them hangs."""


def fetch_sums(
    connection: Connection,
    regions: Sequence[Region],
    silent: Collection[str],
    arrays: Sequence[NDArray],
    came: NDArray[np.bool_],
) -> int:
    """Write the sums of regions into ``arrays`` (P,), and note in ``came`` (P,) those that came; return their bytes.

    Those of ``silent`` workers are asked for last. What is lost with its worker does not come. Raises ClusterError.
    """
    messages = Messages(connection)  # of its own, as others hear of units
    # Last, as they are taken from the end, those of workers that are there.
    wanted = sorted(by_source(regions), key=lambda several: several[0].worker not in silent)
    under_way, quiet, byte_count = 0, 0.0, 0
    while (wanted or under_way) and quiet < HANG_SECONDS:
        while wanted and under_way < AT_ONCE:
            several = wanted.pop()
            messages.listen(several[0].source, several)
            under_way += 1
        heard = messages.hear()
        quiet = 0.0 if heard else quiet + TICK
        for several, outcome in heard:
            under_way -= 1
            if isinstance(outcome, CancelledError | KilledWorker | SceneMissingError):
                continue  # lost with its worker, or with one that was to draw it again: whoever misses it draws it
            if isinstance(outcome, BaseException):
                raise explained(outcome) from None
            sums = outcome["sums"].packed()
            byte_count += sums.nbytes
            for region in several:
                write(sums, region, arrays)
                came[region.pixels] = True
    return byte_count


def scatter_sums(connection: Connection, arrays: Sequence[NDArray], parts: int) -> list[Region]:
    """Take sums (P,) of a whole picture to workers in about so many parts; return where they are."""
    pixel_count = len(arrays[0])
    size = -(-pixel_count // parts)
    regions = []
    for first in range(0, pixel_count, size):
        place = first, min(size, pixel_count - first)
        (future,) = connection.client.scatter([{"sums": Sums(None, packed(arrays, *place))}], hash=False)
        regions.append(Region(*place, future))
    return regions

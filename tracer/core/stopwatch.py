"""Seconds on the clock and of the processor, read together."""

from __future__ import annotations

import time
from dataclasses import dataclass


@dataclass(frozen=True)
class Seconds:
    """How long something took."""

    wall: float = 0.0
    """Seconds on the clock."""
    cpu: float = 0.0
    """Seconds of all threads of this process together."""

    def __add__(self, other: Seconds) -> Seconds:
        return Seconds(self.wall + other.wall, self.cpu + other.cpu)

    def __sub__(self, other: Seconds) -> Seconds:
        return Seconds(self.wall - other.wall, self.cpu - other.cpu)


NO_TIME = Seconds()
"""What nothing takes."""


def read() -> Seconds:
    """Return the time, counted from any beginning."""
    return Seconds(time.perf_counter(), time.process_time())

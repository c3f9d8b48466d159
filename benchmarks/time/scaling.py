"""A model of the time with more cores, from the seconds in which one thread worked alone."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

Parts = Mapping[str, tuple[float, float]]
"""Seconds on the clock and of the processor of each part, by its name."""
CORES = (2, 8, 32, 64)
"""Numbers of cores of the model."""


@dataclass(frozen=True)
class Work:
    """The seconds of a picture, divided by how many threads can work on them (G. Amdahl, 1967)."""

    serial: float
    """Seconds in which one thread works alone."""
    parallel: float
    """Seconds of the processor that any number of threads share."""

    def seconds(self, cores: int) -> float:
        """Return the seconds on the clock with so many cores."""
        return self.serial + self.parallel / cores

    def serial_share(self, cores: int) -> float:
        """Return the part of the time in which one of so many cores works alone."""
        return self.serial / self.seconds(cores)


def work_of(parts: Parts, parts_of_one: Parts, threads: int) -> Work:
    """Return the work of a picture whose parts took ``parts`` with ``threads``, >= 2, and ``parts_of_one`` with one.

    A part that took t seconds on the clock with n threads and u with one has s seconds in which one thread works alone,
    with t = s + (u - s) / n. Drawing is taken to have none: there s is small, and lost in the noise of t and u. The
    seconds of the processor do not tell, as idle threads of Dr.Jit wait actively.
    """
    serial, whole = 0.0, 0.0
    for name, (seconds, _) in parts.items():
        seconds_of_one = parts_of_one.get(name, (seconds, 0.0))[0]
        if name != "seconds_drawing":
            serial += min(max((threads * seconds - seconds_of_one) / (threads - 1), 0.0), seconds)
        whole += seconds_of_one
    return Work(serial, max(whole - serial, 0.0))

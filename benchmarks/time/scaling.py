"""A model of the time with more cores, from the seconds in which one thread worked alone."""

from __future__ import annotations

from dataclasses import dataclass

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


def work_of(seconds: float, shared: float, threads: int) -> Work:
    """Return the work of a picture that took ``seconds`` on the clock; ``threads`` worked together in ``shared``."""
    return Work(max(seconds - shared, 0.0), shared * threads)

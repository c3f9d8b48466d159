"""What paths have shown so far: how wrong pixels are, and what lights give."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from tracer.core.arrays import Floats
from tracer.guiding.training import Paths, Trials, joined
from tracer.image import objective

SQUARE = 8
"""Side in pixels of the squares over which the brightness of the picture is averaged."""
TYPICAL, MOST = 0.99, 4.0
"""Share of the pixels whose error is typical, and how many times as large an error may be to count in full."""


@dataclass(frozen=True)
class Evidence:
    """What all paths so far have shown."""

    trials: Trials
    squares: Floats
    """(N,): square of what each trial gave, times how much its pixel counts."""
    noise: Floats
    """(pixels,): variances of single paths where Mitsuba chooses, times how much they count."""
    path_count: int
    block: int
    """See ``Paths``."""
    errors: list[Floats] = field(default_factory=list)
    """For each training (pixels,): squared errors of the means of blocks, times how much they count."""

    @staticmethod
    def of(paths: Paths, trials: Trials, grid: tuple[int, int], objective_name: str, exposure: float) -> Evidence:
        """Return what these paths have shown; ``grid``: rows and columns of the picture."""
        weight = path_weights(objective_name, exposure, brightness(paths.pixel, paths.radiance, grid))
        squares = np.square(trials.given) * weight[trials.path]
        noise, errors = path_noise(paths, weight), block_errors(paths, weight)
        return Evidence(trials, squares, noise, paths.pixel.size, paths.block, [errors])

    def after(self, before: Evidence | None) -> Evidence:
        """Return all that was seen, with what was seen ``before``; only its noise is that of Mitsuba's choice."""
        if before is None:
            return self
        trials = joined(before.trials, before.path_count, self.trials)
        squares = np.concatenate([before.squares, self.squares])
        path_count = before.path_count + self.path_count
        return Evidence(trials, squares, before.noise, path_count, self.block, [*before.errors, *self.errors])

    def error_left(self) -> tuple[float, float]:
        """Return the mean error in the last training as a part of that in the first, and its relative standard error.

        Of the last training only pixels of the first count, which have the same rays of the camera. Errors far above
        those of most pixels count as less.
        """
        cap = MOST * float(np.quantile(self.errors[0], TYPICAL))
        step = len(self.errors[-1]) // len(self.errors[0])
        first, last = np.minimum(self.errors[0], cap), np.minimum(self.errors[-1][::step][: len(self.errors[0])], cap)
        if not first.any() or not last.any():
            return 1.0, 0.0
        deviation = first / first.mean() - last / last.mean()
        return float(last.mean() / first.mean()), float(deviation.std() / np.sqrt(deviation.size))


def brightness(pixel: NDArray, radiance: Floats, grid_shape: tuple[int, int]) -> Floats:
    """Return, for each path (paths,), the mean radiance of the paths in its square of pixels, others' and its own."""
    row, column = np.divmod(pixel.astype(np.int64), grid_shape[1])
    square = row // SQUARE * (-(-grid_shape[1] // SQUARE)) + column // SQUARE
    count = np.bincount(square)
    cut = np.minimum(radiance, 30 * max(float(radiance.mean()), 1e-30))  # a firefly does not make its square bright
    return (np.bincount(square, cut) / np.maximum(count, 1))[square]


def path_noise(paths: Paths, weight: Floats) -> Floats:
    """Return the variance of single paths in each pixel (pixels,), times how much they count: ``weight`` (paths,)."""
    twice = 2 * paths.block
    return weight[::twice] * paths.radiance.reshape(-1, twice).var(axis=1, ddof=1)


def block_errors(paths: Paths, weight: Floats) -> Floats:
    """Return the squared error of the mean of a block in each pixel (pixels,), times its ``weight`` (paths,)."""
    first, second = paths.radiance.reshape(-1, 2, paths.block).mean(axis=2).T
    return 0.5 * weight[:: 2 * paths.block] * np.square(first - second)


def path_weights(objective_name: str, exposure: float, level: Floats) -> Floats:
    """Return how much the squared error of each path (paths,) counts, from the brightness around it."""
    return objective.weights(objective_name, level, exposure)

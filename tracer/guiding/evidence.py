"""What paths have shown: how wrong pixels are, and what lights give."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from tracer.core.arrays import Floats, Indices
from tracer.guiding.training import Paths, Trials, joined
from tracer.image import objective

SQUARE = 8
"""Side in pixels of the squares over which the brightness of the picture is averaged."""
TYPICAL, MOST = 0.99, 4.0
"""Share of the pixels whose error is typical, and how many times as large an error may be to count in full."""


@dataclass(frozen=True)
class Judgement:
    """What the samples that judge have shown in one training."""

    pixel: Indices
    """(pixels,): pixel (grid) of each."""
    mean: Floats
    """(pixels,): mean of all samples."""
    error: Floats
    """(pixels,): squared error of the mean of a block."""

    @staticmethod
    def of(paths: Paths) -> Judgement:
        """Return what these paths have shown."""
        means = paths.blocks.mean(axis=2)
        pixel = paths.chosen.pixel[: paths.chosen.judge_count : 2 * paths.chosen.block]
        return Judgement(pixel, means.mean(axis=1), 0.5 * np.square(means[:, 0] - means[:, 1]))


@dataclass(frozen=True)
class Taught:
    """What all paths that teach have shown so far."""

    trials: Trials
    squares: Floats
    """(N,): square of what each trial gave, times how much its pixel counts."""
    noise: Floats
    """(pixels,): variances of single paths where Mitsuba chooses, times how much they count."""
    path_count: int
    """Number of these paths."""

    @staticmethod
    def of(paths: Paths, trials: list[Trials], grid: tuple[int, int], objective_name: str, exposure: float) -> Taught:
        """Return what these paths have shown; ``grid``: rows and columns of the picture."""
        pixel, radiance = paths.chosen.pixel[paths.chosen.judge_count :], paths.teachers
        weight = objective.weights(objective_name, brightness(pixel, radiance, grid), exposure)
        together = joined(trials)
        squares = np.square(together.given) * weight[together.path]
        noise = 0.5 * weight[::2] * np.square(radiance[::2] - radiance[1::2])
        return Taught(together, squares, noise, radiance.size)

    def after(self, before: Taught | None) -> Taught:
        """Return all that was seen, with what was seen ``before``; only its noise is that of Mitsuba's choice."""
        if before is None:
            return self
        later = replace(self.trials, path=self.trials.path + np.uint32(before.path_count))
        squares = np.concatenate([before.squares, self.squares])
        return Taught(joined([before.trials, later]), squares, before.noise, before.path_count + self.path_count)


def error_left(
    first: Judgement, last: Judgement, grid: tuple[int, int], objective_name: str, exposure: float
) -> tuple[float, float]:
    """Return the mean error in the last training as a part of that in the first, and its relative standard error.

    Both are of the same pixels and rays of the camera. Errors far above those of most pixels count as less.
    """
    level = brightness(first.pixel, 0.5 * (first.mean + last.mean), grid)
    weight = objective.weights(objective_name, level, exposure)
    errors = [weight * judgement.error for judgement in (first, last)]
    before, after = (np.minimum(error, MOST * np.quantile(error, TYPICAL)) for error in errors)
    if not before.any() or not after.any():
        return 1.0, 0.0
    deviation = before / before.mean() - after / after.mean()
    return float(after.mean() / before.mean()), float(deviation.std() / np.sqrt(deviation.size))


def brightness(pixel: NDArray, radiance: Floats, grid_shape: tuple[int, int]) -> Floats:
    """Return, for each path (paths,), the mean radiance of the paths in its square of pixels, others' and its own."""
    row, column = np.divmod(pixel.astype(np.int64), grid_shape[1])
    square = row // SQUARE * (-(-grid_shape[1] // SQUARE)) + column // SQUARE
    count = np.bincount(square)
    cut = np.minimum(radiance, 30 * max(float(radiance.mean()), 1e-30))  # a firefly does not make its square bright
    return (np.bincount(square, cut) / np.maximum(count, 1))[square]

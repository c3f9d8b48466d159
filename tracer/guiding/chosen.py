"""Which samples of a picture are drawn before it, to teach and to judge."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tracer.core.arrays import Indices

PLASTIC = 1.32471795724474602596
"""Real root of x^3 = x + 1, of which the most even sequence of points in a square is made (Roberts, 2018)."""


@dataclass(frozen=True)
class Chosen:
    """Samples, first those that judge: of each of their pixels a block of the sequence 0, and one of the sequence 1."""

    pixel: Indices
    """(paths,): pixel (grid) of each."""
    sequence: Indices
    """(paths,): which of two sequences it is of, 0 or 1."""
    index: Indices
    """(paths,): its place in the sequence."""
    judge_count: int
    """Number of samples that judge. Those behind teach: one of each sequence in each of their pixels."""
    block: int
    """Samples of a sequence in each pixel of those that judge."""


def choose(grid: tuple[int, int], judge_pixels: int, block: int, first: int, teacher_pixels: int) -> Chosen:
    """Return samples of pixels that are spread evenly over a picture of ``grid`` (rows, columns).

    Those that judge are always the same; those that teach are of the pixels from number ``first`` on of a sequence that
    has no end.
    """
    judges = samples(spread(grid, 0, judge_pixels, 0.0), block)
    teachers = samples(spread(grid, first, teacher_pixels, 0.25), 1)
    pixel, sequence, index = (np.concatenate(parts) for parts in zip(judges, teachers, strict=True))
    return Chosen(pixel, sequence, index, 2 * block * judge_pixels, block)


def samples(pixel: Indices, block: int) -> tuple[Indices, Indices, Indices]:
    """Return (pixel, sequence, index) of two blocks of samples for each entry of ``pixel`` (pixels,).

    A pixel that comes again has the next samples of both sequences.
    """
    order = np.argsort(pixel, kind="stable")
    again = np.empty(len(pixel), np.int64)
    again[order] = np.arange(len(pixel)) - np.searchsorted(pixel[order], pixel[order])
    index = again[:, None, None] * block + np.arange(block)
    shape = len(pixel), 2, block
    pixels, sequences, indices = (
        np.broadcast_to(part, shape).reshape(-1).astype(np.uint32)
        for part in (pixel[:, None, None], np.arange(2)[:, None], index)
    )
    return pixels, sequences, indices


def spread(grid: tuple[int, int], first: int, count: int, shift: float) -> Indices:
    """Return pixels (count,) from number ``first`` on of an even sequence, which ``shift`` moves."""
    number = np.arange(first + 1, first + count + 1, dtype=np.float64)
    row, column = (
        ((shift + number / PLASTIC**power) % 1 * side).astype(np.uint32)
        for power, side in zip((1, 2), grid, strict=True)
    )
    return row * np.uint32(grid[1]) + column

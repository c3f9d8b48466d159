"""One half of a reference: a mean over chunks of samples, each with a seed of its own, and its spread."""

from __future__ import annotations

import logging
import zipfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tracer.core.arrays import Floats
from tracer.image.colour import luminance
from tracer.io import atomic

logger = logging.getLogger(__name__)

TILES = 8
"""Tiles along each side of the picture; the mean of each tile is kept chunk by chunk."""


@dataclass
class Half:
    """Running mean over chunks of equally many samples, and the variance between them (Welford, 1962)."""

    chunk_spp: int
    """Samples per pixel of a chunk."""
    mean: Floats
    """(H, W, 3), linear sRGB: mean over chunks."""
    deviations: Floats
    """(H, W, 3): sum over chunks of squared deviations from the mean."""
    variance: Floats
    """(H, W, 3): variance of one sample, mean over chunks; zero if the chunks come without it."""
    tiles: Floats
    """(chunks, rows, columns): mean luminance of every tile of the picture."""

    @classmethod
    def empty(cls, chunk_spp: int, height: int, width: int) -> Half:
        """Return a half without chunks."""
        mean, deviations, variance = np.zeros((3, height, width, 3))
        rows, columns = min(TILES, height), min(TILES, width)
        return cls(chunk_spp, mean, deviations, variance, np.zeros((0, rows, columns)))

    @property
    def chunks(self) -> int:
        """Number of chunks that were added."""
        return len(self.tiles)

    @property
    def spp(self) -> int:
        """Samples per pixel so far."""
        return self.chunks * self.chunk_spp

    def add(self, image: NDArray, variance: NDArray | None = None) -> None:
        """Add the picture (H, W, 3) of a chunk, and the variance of one of its samples if that is known."""
        self.tiles = np.concatenate([self.tiles, tile_means(luminance(image), self.tiles.shape[1:])[None]])
        difference = image - self.mean
        self.mean += difference / self.chunks
        self.deviations += difference * (image - self.mean)
        if variance is not None:
            self.variance += (variance - self.variance) / self.chunks

    def save(self, path: Path) -> None:
        """Write the half to a file, whole or not at all."""
        with atomic.whole(path) as temporary, open(temporary, "wb") as file:
            np.savez(file, **vars(self))

    @classmethod
    def load(cls, path: Path) -> Half | None:
        """Return the half in a file; None if there is no file, or if it is damaged, so that the half is made anew."""
        try:
            with np.load(path) as stored:
                arrays = (stored[name] for name in ("mean", "deviations", "variance", "tiles"))
                return cls(int(stored["chunk_spp"]), *arrays)
        except FileNotFoundError:
            return None
        except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile) as error:
            logger.warning("'%s' cannot be read (%s) and is made anew.", path, error)
            return None


def tile_means(values: Floats, shape: tuple[int, ...]) -> Floats:
    """Return the means of ``values`` (H, W) over a grid of nearly equal tiles (rows, columns)."""
    rows, columns = (
        np.linspace(0, size, tiles + 1).astype(int) for size, tiles in zip(values.shape, shape, strict=True)
    )
    sums = np.add.reduceat(np.add.reduceat(values, rows[:-1], axis=0), columns[:-1], axis=1)
    return sums / np.outer(np.diff(rows), np.diff(columns))

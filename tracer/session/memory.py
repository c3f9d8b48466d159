"""How much memory a render takes, and passes small enough for a limit.

Memory has three parts: what the process has when its scene is loaded; the sums, statistics and importance of every
pixel; and the values of every sample of a pass. The constants are from renders of 4096 to 2 million pixels with passes
of 2^20 and 2^22 samples; ``tests/system/test_memory.py`` measures that they are enough.
"""

from __future__ import annotations

from dataclasses import dataclass

import psutil

from tracer.denoising.oidn import LEAST_MEMORY, MOST_MEMORY, PIXEL_MEMORY
from tracer.errors import SettingsError
from tracer.film.pixel_sums import footprint_length
from tracer.sampling.passes import PASS_SIZES
from tracer.scene.frame import Frame
from tracer.settings import Settings

GIB = 1 << 30
PROGRAM = 160e6
"""Bytes that kernels and libraries take."""
PIXEL = 420.0
"""Bytes that the decisions take for each pixel, whatever its channels."""
PIXEL_CHANNEL = 36.0
"""Bytes that sums and statistics take for each channel of a pixel."""
PIXEL_FOOTPRINT = 4.6
"""Bytes that each filter-weighted sum takes: one for each channel of each pixel that the filter reaches."""
PIXEL_COPY = 2.5
"""Bytes that each filter-weighted sum takes in addition while a checkpoint is written."""
FEATURE_CHANNELS = 7
"""Channels of albedo, normal and depth together."""
FEATURES = 200.0
"""Bytes that a set of features takes for each pixel."""
SAMPLE = 30.0
"""Bytes that each sample of a pass takes, whatever its channels."""
SAMPLE_CHANNEL = 14.0
"""Bytes that each sample of a pass takes for each channel."""
LEARNING, LEARNING_PATH = 300e6, 700.0
"""Bytes that learning which lights matter takes, whatever the number of paths, and for each path, beside the scene."""
SMALLEST_PASS = 1 << 16
"""Samples of the smallest pass that a limit of memory can lead to."""
LARGE = 2 * GIB
"""Bytes beyond which a person is told, before the render begins, how much memory it takes."""


@dataclass(frozen=True)
class Need:
    """Bytes that a render is expected to take at most."""

    scene: float
    """Taken already."""
    pixels: float
    sample: float
    """For each sample of a pass."""

    def total(self, pass_size: int) -> float:
        """Return the sum, with passes of one size."""
        return self.scene + PROGRAM + self.pixels + self.sample * pass_size


def need(frame: Frame, settings: Settings, features: bool = False, denoise: bool = False, keeps: bool = False) -> Need:
    """Return what a render takes now that its scene is loaded. ``keeps``: it writes checkpoints."""
    channels = len(frame.channels)
    footprint = footprint_length(frame.reach, channels)
    pixel = PIXEL + PIXEL_CHANNEL * channels + (PIXEL_FOOTPRINT + PIXEL_COPY * keeps) * footprint
    if settings.unbiased:
        pixel += 16 * channels + 4 * footprint  # the sums of those held out
    if features:
        pixel += FEATURES + PIXEL_FOOTPRINT * footprint * (FEATURE_CHANNELS + 1) / (channels + 1)
    if denoise or keeps:  # a checkpoint has what denoising needs
        pixel += FEATURES
    pixels = pixel * frame.pixel_count
    if denoise:
        pixels += 1e6 * min(LEAST_MEMORY + PIXEL_MEMORY * frame.pixel_count, MOST_MEMORY)
    return Need(resident(), pixels, SAMPLE + SAMPLE_CHANNEL * channels)


def resident() -> float:
    """Return the bytes of memory that this process has now."""
    return float(psutil.Process().memory_info().rss)


def largest_pass(needed: Need, limit: float | None) -> int:
    """Return the most samples of a pass with which a render stays within ``limit`` (GiB). Raises SettingsError."""
    if limit is None:
        return PASS_SIZES[-1]
    sizes = [SMALLEST_PASS << k for k in range(32) if SMALLEST_PASS << k <= PASS_SIZES[-1]]
    fitting = [size for size in sizes if needed.total(size) <= limit * GIB]
    if not fitting:
        least = needed.total(SMALLEST_PASS) / GIB
        raise SettingsError(
            f"memory: this render needs about {least:.2g} GiB, of which pixels take {needed.pixels / GIB:.2g}, and may "
            f"take {limit:g}; render a smaller size, or part by part with crop."
        )
    return fitting[-1]


def most_learning_paths(needed: Need, limit: float | None, most: int) -> int:
    """Return from how many paths, up to ``most``, may be learned within ``limit`` (GiB)."""
    if limit is None:
        return most
    return min(max(int((limit * GIB - needed.total(0) - LEARNING) / LEARNING_PATH), 0), most)


def in_words(needed: Need, size: int) -> str:
    """Return a sentence for a person."""
    return f"About {needed.total(size) / GIB:.1f} GiB of memory, {needed.pixels / GIB:.1f} of it for the pixels."

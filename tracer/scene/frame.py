"""What is known of a picture apart from the scene it shows: its pixels, and what their numbers mean."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from tracer.core.device import channels_of, upload
from tracer.image.colour import LUMINANCE, luminance


class Frame:
    """The pixels of a picture. They are counted row by row over ``grid``: the image and a border around it."""

    size: tuple[int, int]
    """(height, width) of the image."""
    border: int
    """Pixels that are sampled outside each side of the image, as the film may ask for."""
    channels: list[str]
    """Names of the channels of the image."""
    reach: int
    """Distance in pixels over which a sample counts through the reconstruction filter; 0 for a box filter."""
    window: tuple[int, int, int, int]
    """x and y of the image within the film, and width and height of the film."""

    @property
    def grid(self) -> tuple[int, int]:
        """(height, width) of the area of pixels that are sampled: the image and its border."""
        return self.size[0] + 2 * self.border, self.size[1] + 2 * self.border

    @property
    def inner(self) -> tuple[slice, slice]:
        """The image within the grid."""
        return slice(self.border, self.border + self.size[0]), slice(self.border, self.border + self.size[1])

    @property
    def pixel_count(self) -> int:
        """Number of pixels that are sampled."""
        return self.grid[0] * self.grid[1]

    @property
    def colour_channels(self) -> int:
        """How many channels, from the first on, are colour. Decisions look at these alone."""
        return 3 if self.channels[0] in "RX" else 1

    @property
    def has_alpha(self) -> bool:
        """Whether the channel after the colours is alpha."""
        return self.channels[self.colour_channels : self.colour_channels + 1] == ["A"]

    def luminance(self, image: NDArray) -> NDArray:
        """Return the luminance (H, W) of an image (H, W, C) in the channels of this frame."""
        if self.channels[0] == "X":
            return image[..., 1]
        return luminance(image[..., : self.colour_channels])

    def luminance_on_device(self, image: NDArray) -> Any:
        """Return the same as ``luminance``, computed on the device, as an mi.Float, row by row."""
        channels = [mi.Float64(channel) for channel in channels_of(image, self.colour_channels)]
        if self.channels[0] == "X":
            return mi.Float(channels[1])
        if len(channels) == 1:
            return mi.Float(channels[0])
        return mi.Float(sum(weight * channel for weight, channel in zip(LUMINANCE.tolist(), channels, strict=True)))

    def rgb(self, image: NDArray) -> NDArray:
        """Return the colours (H, W, 3) of an image (H, W, C) in the channels of this frame, as linear sRGB."""
        colour = image[..., : self.colour_channels]
        if self.channels[0] == "X":
            return np.array(mi.xyz_to_srgb(colours(colour))).T.reshape(colour.shape)
        return colour.repeat(3, axis=-1) if self.colour_channels == 1 else colour

    def from_rgb(self, rgb: NDArray) -> NDArray:
        """Return linear sRGB (H, W, 3) as the colour channels of this frame, (H, W, 1 or 3)."""
        if self.channels[0] == "X":
            return np.array(mi.srgb_to_xyz(colours(rgb))).T.reshape(rgb.shape)
        return luminance(rgb)[..., None] if self.colour_channels == 1 else rgb


@dataclass(frozen=True)
class PlainFrame(Frame):
    """A frame without a scene, for pictures whose scene is not open, as when a checkpoint is read."""

    size: tuple[int, int]
    border: int
    channels: list[str]
    reach: int
    window: tuple[int, int, int, int]


def colours(image: NDArray) -> Any:
    """Return the colours of an image (H, W, 3) as mi.Color3f, row by row."""
    return mi.Color3f(*(upload(mi.Float, channel) for channel in image.reshape(-1, 3).T))

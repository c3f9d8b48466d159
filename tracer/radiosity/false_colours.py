"""A picture of illuminance in false colours, with a scale in lux."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from tracer.core.arrays import Floats, Mask
from tracer.errors import SettingsError
from tracer.io import atomic

COLOURS = "viridis"
"""Colour map of matplotlib: equal steps of it look equally large, also to people who do not see all colours."""
NOWHERE = (0.35, 0.35, 0.35)
"""Colour of pixels in which nothing is lit."""
TOP, BOTTOM = 99.5, 0.5
"""Percentiles of the pixels at which the scale ends: a few bright pixels next to a lamp would take all colours."""
DEEPEST = 1e-4
"""The least that a logarithmic scale shows, as a share of the most."""
SHORTEST, DPI = 480, 100
"""Pictures of fewer rows are enlarged to at least so many pixels, so that the scale can be read; pixels an inch."""
SCALE, MARGIN = 130, 16
"""Pixels beside the picture for the scale, and around it."""


@dataclass(frozen=True)
class Scale:
    """How illuminance becomes colours."""

    logarithmic: bool = False
    ends: tuple[float, float] | None = None
    """The least and the most in lux that colours tell apart, so that pictures can be compared; None: those of the
    picture, see ``limits``."""


AUTOMATIC = Scale()
"""A linear scale that suits the picture."""


def scale_of(logarithmic: bool, ends: str | None) -> Scale:
    """Return the scale with the ends of a text such as ``0,500``. Raises SettingsError for another text."""
    if ends is None:
        return Scale(logarithmic)
    try:
        least, most = (float(number) for number in ends.split(","))
    except ValueError:
        raise SettingsError(f"A range is two numbers of lux such as 0,500, not '{ends}'.") from None
    if not 0 <= least < most < float("inf"):
        raise SettingsError(f"A range goes from at least 0 lux to more, such as 0,500; '{ends}' does not.")
    if logarithmic and least == 0:
        raise SettingsError(f"A logarithmic range begins above 0, as in 1,500; '{ends}' does not.")
    return Scale(logarithmic, (least, most))


def write_false_colours(path: Path, lux: Floats, lit: Mask, scale: Scale = AUTOMATIC) -> None:
    """Write illuminance (H, W) in lux as PNG in false colours, with a scale; ``lit`` (H, W): where there is any."""
    figure = false_colours(lux, lit, scale)
    with atomic.whole(path) as temporary:
        figure.savefig(temporary, dpi=DPI, format="png")


def false_colours(lux: Floats, lit: Mask, scale: Scale = AUTOMATIC) -> Any:
    """Return the figure of ``write_false_colours``, a matplotlib figure."""
    import matplotlib
    from matplotlib.colors import LogNorm, Normalize
    from matplotlib.figure import Figure
    from matplotlib.ticker import EngFormatter, LogLocator, MaxNLocator

    logarithmic = scale.logarithmic
    least, most = scale.ends or limits(lux[lit], logarithmic)
    factor = max(1, -(-SHORTEST // lux.shape[0]))
    height, width = (factor * side for side in lux.shape)
    whole_width, whole_height = width + 3 * MARGIN + SCALE, height + 2 * MARGIN
    figure = Figure(figsize=(whole_width / DPI, whole_height / DPI))
    picture = figure.add_axes(
        (MARGIN / whole_width, MARGIN / whole_height, width / whole_width, height / whole_height), frameon=False
    )
    picture.set_axis_off()
    colours = matplotlib.colormaps[COLOURS].with_extremes(bad=NOWHERE)
    norm = LogNorm(least, most, clip=True) if logarithmic else Normalize(least, most, clip=True)
    shown = picture.imshow(
        np.where(lit, np.clip(lux, least, most), np.nan), cmap=colours, norm=norm, interpolation="nearest"
    )
    bar = figure.add_axes(
        ((width + 2 * MARGIN) / whole_width, 3 * MARGIN / whole_height, 22 / whole_width, 1 - 6 * MARGIN / whole_height)
    )
    below = bool(least > 0 and lit.any() and lux[lit].min() < least)
    above = bool(lit.any() and lux[lit].max() > most)
    extend = {(True, True): "both", (True, False): "min", (False, True): "max", (False, False): "neither"}[below, above]
    ticks = LogLocator(subs=(1, 2, 5) if most < 300 * least else (1,)) if logarithmic else MaxNLocator(9)
    colour_bar = figure.colorbar(shown, cax=bar, extend=extend, extendfrac=0.03, ticks=ticks, format=EngFormatter())
    colour_bar.ax.minorticks_off()
    colour_bar.ax.tick_params(labelsize=11)
    colour_bar.set_label("illuminance in lux", fontsize=12)
    return figure


def limits(lux: Floats, logarithmic: bool) -> tuple[float, float]:
    """Return the ends of the scale for the illuminance (N,) of pixels that are lit; a linear scale begins at 0."""
    most = float(np.percentile(lux, TOP)) if len(lux) else 0.0
    if not most > 0:  # almost all is dark
        most = float(lux.max(initial=0.0)) or 1.0
    if not logarithmic:
        return 0.0, most
    least = float(np.percentile(lux, BOTTOM)) if len(lux) else 0.0
    return min(max(least, DEEPEST * most), 0.5 * most), most

"""Figures of a decision: pictures and maps of pixels, each under a caption of its own."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm, Normalize
from matplotlib.ticker import LogLocator, NullLocator, ScalarFormatter
from numpy.typing import NDArray

from benchmarks import harness
from tracer.image.colour import display

WIDTH = 3.7
"""Width of a panel in inches."""
TOP = 0.995
"""Quantile of the values at which the colours of a map end, so that single pixels do not make the others dark."""


@dataclass(frozen=True)
class Panel:
    """A picture (H, W, 3), linear, or a map (H, W) of pixels, and what it shows."""

    caption: str
    values: NDArray
    is_logarithmic: bool = False
    """Whether the colours of a map stand for powers of two."""
    colours: str = "magma"
    """Name of matplotlib's map of colours."""
    top: float | None = None
    """Value at which the colours of a linear map end; None: nearly the largest."""


def write(path: Path, panels: Sequence[Panel], columns: int) -> None:
    """Write panels to a file in rows of ``columns``."""
    height, width = panels[0].values.shape[:2]
    rows = -(-len(panels) // columns)
    with harness.figure(path, WIDTH * columns, rows * (WIDTH * height / width + 0.62)) as figure:
        grid = figure.subplots(rows, columns, squeeze=False)
        for axes, panel in zip(grid.flat, panels, strict=True):
            draw(axes, panel)


def draw(axes: Axes, panel: Panel) -> None:
    """Draw a panel, and below a map its bar of colours, which takes no room, so that all panels are equally large."""
    axes.set_title(panel.caption, fontsize=10)
    axes.set_axis_off()
    values = panel.values
    if values.ndim == 3:
        axes.imshow(display(values), interpolation="nearest")
        return
    top = float(np.quantile(values, TOP)) if panel.top is None else panel.top
    norm = LogNorm(max(values.min(), 1), max(values.max(), 2)) if panel.is_logarithmic else Normalize(0, top or 1)
    mapped = axes.imshow(values, cmap=panel.colours, norm=norm, interpolation="nearest")
    bar = axes.inset_axes((0.05, -0.07, 0.9, 0.035))
    axes.figure.colorbar(mapped, cax=bar, orientation="horizontal")
    bar.tick_params(labelsize=8)
    if panel.is_logarithmic:
        bar.xaxis.set_major_locator(LogLocator(base=2))
        bar.xaxis.set_major_formatter(ScalarFormatter())
        bar.xaxis.set_minor_locator(NullLocator())

"""Pictures, error maps and maps of samples in a row, as an image file."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import BinaryIO

import numpy as np
from numpy.typing import NDArray

from tracer.image import colour, metrics
from tracer.image.colour import display
from tracer.io import atomic

Panel = tuple[str, NDArray, bool]
"""A caption; a linear picture (H, W, C) or values (H, W); and whether values have a logarithmic scale of colours."""


def relative_error(image: NDArray, reference: NDArray) -> NDArray[np.float64]:
    """Return the relative error (H, W): root mean square over channels, divided by the reference's luminance."""
    squared = np.mean((np.asarray(image, np.float64) - reference) ** 2, axis=-1)
    return np.sqrt(squared / (colour.luminance(reference) ** 2 + metrics.EPSILON))


def write_panels(
    target: Path | BinaryIO,
    panels: Sequence[Panel],
    title: str,
    error_top: float | None = None,
    file_format: str = "png",
    columns: int | None = None,
) -> None:
    """Write panels to a file, each with its caption, in rows of ``columns``; None: all in one row.

    Values get a bar of colours, which goes from 0 to ``error_top`` if their scale is linear.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.colors import LogNorm, Normalize
    from matplotlib.figure import Figure
    from matplotlib.ticker import LogLocator, NullLocator, ScalarFormatter

    height, width = panels[0][1].shape[:2]
    inches, columns = 3.2, columns or len(panels)
    rows = math.ceil(len(panels) / columns)
    size = (inches * columns, rows * (inches * height / width + 0.6) + 0.35)
    figure = Figure(figsize=size, layout="constrained", dpi=110)
    FigureCanvasAgg(figure)
    figure.suptitle(title, fontsize=11)
    for k, (caption, values, logarithmic) in enumerate(panels):
        axes = figure.add_subplot(rows, columns, k + 1)
        axes.set_title(caption, fontsize=9)
        axes.set_axis_off()
        if values.ndim == 3:
            axes.imshow(display(values), interpolation="nearest")
            continue
        norm = LogNorm(max(values.min(), 1), max(values.max(), 2)) if logarithmic else Normalize(0, error_top)
        mapped = axes.imshow(values, cmap="magma", norm=norm, interpolation="nearest")
        bar = axes.inset_axes(
            (0.03, -0.07, 0.94, 0.035)
        )  # takes no room from its panel, so all panels are equally large
        figure.colorbar(mapped, cax=bar, orientation="horizontal")
        bar.tick_params(labelsize=7)
        if logarithmic:
            bar.xaxis.set_major_locator(LogLocator(base=2))
            bar.xaxis.set_major_formatter(ScalarFormatter())
            bar.xaxis.set_minor_locator(NullLocator())
    if isinstance(target, Path):
        with atomic.whole(target) as temporary:
            figure.savefig(temporary, format=file_format)
    else:
        figure.savefig(target, format=file_format)

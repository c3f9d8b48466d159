"""Convergence plots as SVG that takes its text colour from the page around it."""

from __future__ import annotations

import html
import io
from collections.abc import Sequence
from typing import Any

from tracer.study.records import Row

INK = "#010203"
"""Colour that stands for the text colour of the page and is replaced by it."""


def convergence(rows: Sequence[Row], scene: str) -> str:
    """Return the error of every method on a scene over samples and over seconds, both axes logarithmic."""
    import matplotlib
    from matplotlib.backends.backend_svg import FigureCanvasSVG
    from matplotlib.figure import Figure

    style: dict[Any, Any] = {
        "svg.fonttype": "none",
        "svg.hashsalt": scene,
        "font.family": "sans-serif",
        "text.color": INK,
        "axes.labelcolor": INK,
        "axes.edgecolor": INK,
        "xtick.color": INK,
        "ytick.color": INK,
    }
    with matplotlib.rc_context(style):
        figure = Figure(figsize=(9.2, 3.6), layout="constrained")
        FigureCanvasSVG(figure)
        left, right = figure.subplots(1, 2, sharey=True)
        for k, method in enumerate(dict.fromkeys(row.method for row in rows)):
            method_rows = [row for row in rows if row.method == method]
            for axes, quantity in ((left, "spp"), (right, "seconds")):
                points = sorted((getattr(row, quantity), row.scores.relative_mse) for row in method_rows)
                colour, marker = f"C{k}", "osD^vPX*"[k % 8]
                axes.plot(*zip(*points, strict=True), marker=marker, color=colour, ms=5, lw=1.4, label=method)
        for axes, label in ((left, "samples per pixel"), (right, "seconds")):
            axes.set(xscale="log", yscale="log", xlabel=label)
            axes.grid(True, which="both", color=INK, alpha=0.12, lw=0.6)
            axes.set_facecolor("none")
        tidy(left.xaxis, [float(row.budget.split()[0]) for row in rows if row.budget.endswith("spp")])
        tidy(right.xaxis)
        left.set_ylabel("relMSE")
        legend = figure.legend(*left.get_legend_handles_labels(), loc="outside lower center", ncols=3, frameon=False)
        legend.set_in_layout(True)
        figure.patch.set_alpha(0)
        text = io.StringIO()
        figure.savefig(text, format="svg", metadata=dict.fromkeys(("Creator", "Date", "Format", "Type")))
    drawing = text.getvalue()
    drawing = drawing[drawing.index("<svg") :].replace(INK, "currentColor")
    name = html.escape(scene)
    label = f'role="img" aria-label="relMSE of every method on {name} over samples per pixel and over seconds"'
    return drawing.replace("<svg", f"<svg {label}", 1)


def tidy(axis: Any, places: Sequence[float] = ()) -> None:
    """Label an axis with plain numbers at ``places``, or else at 1, 2, 5, 10 and so on, without minor labels."""
    from matplotlib.ticker import FixedLocator, LogLocator, NullFormatter, NullLocator, ScalarFormatter

    axis.set_major_locator(FixedLocator(sorted(set(places))) if places else LogLocator(subs=(1.0, 2.0, 5.0)))
    axis.set_major_formatter(ScalarFormatter())
    axis.set_minor_formatter(NullFormatter())
    if places:
        axis.set_minor_locator(NullLocator())

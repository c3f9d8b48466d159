"""Plots of convergence as SVG that takes its colours from the page around it."""

from __future__ import annotations

from collections.abc import Sequence

from tracer.study.page.svg import LogAxis, drawing, line, marker, series, text
from tracer.study.records import Row

WIDTH, HEIGHT = 440, 270
LEFT, RIGHT, TOP, BOTTOM = 62, 12, 22, 40
"""Margins around the field of a plot, which hold its labels."""
QUANTITIES = {"spp": "samples per pixel", "seconds": "seconds"}
"""Fields of a row that the error is drawn over, and what they are called."""


def convergence(rows: Sequence[Row], scene: str, methods: Sequence[str]) -> list[str]:
    """Return the error of every method on a scene over samples, and over seconds; all axes are logarithmic.

    ``methods``: the names of all methods of the study, in the order of their colours.
    """
    return [plot(rows, scene, methods, quantity) for quantity in QUANTITIES]


def plot(rows: Sequence[Row], scene: str, methods: Sequence[str], quantity: str) -> str:
    """Return the error of every method over one quantity of a row."""
    across = LogAxis.around([getattr(row, quantity) for row in rows], LEFT, WIDTH - RIGHT)
    upwards = LogAxis.around([row.scores.relative_mse for row in rows], HEIGHT - BOTTOM, TOP)
    parts = [text(LEFT, 14, "relMSE", "start"), text((LEFT + WIDTH - RIGHT) / 2, HEIGHT - 6, QUANTITIES[quantity])]
    budgets = {float(row.budget.split()[0]) for row in rows if row.budget.endswith(f" {quantity}")}
    for tick in sorted(budgets) or across.ticks():
        parts.append(line(across.place(tick), TOP, across.place(tick), HEIGHT - BOTTOM, "grid"))
        parts.append(text(across.place(tick), HEIGHT - BOTTOM + 16, f"{tick:g}"))
    for tick in upwards.ticks():
        parts.append(line(LEFT, upwards.place(tick), WIDTH - RIGHT, upwards.place(tick), "grid"))
        parts.append(text(LEFT - 6, upwards.place(tick) + 4, f"{tick:.3g}", "end"))
    for index, method in enumerate(methods):
        points = sorted((getattr(row, quantity), row.scores.relative_mse) for row in rows if row.method == method)
        places = [(across.place(x), upwards.place(y)) for x, y in points]
        path = " ".join(f"{x:g},{y:g}" for x, y in places)
        parts.append(f'<g class="{series(index)}"><polyline points="{path}" class="curve"/>')
        parts += [marker(index, x, y) for x, y in places]
        parts.append("</g>")
    return drawing(WIDTH, HEIGHT, f"relMSE of every method on {scene} over {QUANTITIES[quantity]}", parts)

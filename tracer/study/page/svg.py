"""Small drawings as SVG text: a logarithmic axis, markers, and the frame of a drawing."""

from __future__ import annotations

import html
import math
from collections.abc import Iterable
from dataclasses import dataclass

STYLES = 8
"""Number of colours, and of markers, before they are combined anew."""
TICKS = (
    (1.0,),
    (1.0, 2.0, 5.0),
    (1.0, 1.5, 2.0, 3.0, 5.0, 7.0),
    (1.0, 1.2, 1.4, 1.6, 1.8, 2.0, 2.5, 3.0, 4.0, 6.0, 8.0, 9.0),
)
"""Places of labels within a decade, from few to many."""
ENOUGH_TICKS = 4
"""Number of labels with which an axis can be read."""
MARKERS = (
    "M{x},{y}m-3.6,0a3.6,3.6 0 1,0 7.2,0a3.6,3.6 0 1,0 -7.2,0z",
    "M{x},{y}m-3.3,-3.3h6.6v6.6h-6.6z",
    "M{x},{y}m0,-4.4l4.2,7.4h-8.4z",
    "M{x},{y}m0,-4.6l4.2,4.6l-4.2,4.6l-4.2,-4.6z",
    "M{x},{y}m0,4.4l4.2,-7.4h-8.4z",
    "M{x},{y}m-4.4,-1.3h3.1v-3.1h2.6v3.1h3.1v2.6h-3.1v3.1h-2.6v-3.1h-3.1z",
    "M{x},{y}m-4.4,0l7.4,-4.2v8.4z",
    "M{x},{y}m4.4,0l-7.4,-4.2v8.4z",
)
"""Paths around (x, y), about eight units across."""


@dataclass(frozen=True)
class LogAxis:
    """A logarithmic axis from the value ``low`` at the place ``start`` to ``high`` at ``end``."""

    low: float
    high: float
    start: float
    end: float

    @classmethod
    def around(cls, values: Iterable[float], start: float, end: float) -> LogAxis:
        """Return the axis that holds all positive finite values, with a little room beyond them."""
        logarithms = [math.log(value) for value in values if 0 < value < math.inf] or [0.0]
        low, high = min(logarithms), max(logarithms)
        room = max(0.05 * (high - low), 0.05)
        return cls(math.exp(low - room), math.exp(high + room), start, end)

    def place(self, value: float) -> float:
        """Return where a value lies; values beyond the ends lie at the ends."""
        value = min(max(value, self.low), self.high)
        part = math.log(value / self.low) / math.log(self.high / self.low)
        return round(self.start + part * (self.end - self.start), 1)

    def ticks(self) -> list[float]:
        """Return round values along the axis, enough to read it."""
        first, last = math.floor(math.log10(self.low)), math.floor(math.log10(self.high))
        ticks: list[float] = []
        for places in TICKS:
            ticks = [place * 10.0**k for k in range(first, last + 1) for place in places]
            ticks = [tick for tick in ticks if self.low <= tick <= self.high]
            if len(ticks) >= ENOUGH_TICKS:
                break
        return ticks


def marker(index: int, x: float, y: float) -> str:
    """Return the marker of the method with this index as a path; its colour is that of the text around it."""
    path = MARKERS[(index + index // STYLES) % STYLES].format(x=round(x, 1), y=round(y, 1))
    return f'<path d="{path}" fill="currentColor"/>'


def series(index: int) -> str:
    """Return the class that gives a method its colour."""
    return f"series{index % STYLES}"


def text(x: float, y: float, words: str, anchor: str = "middle", kind: str = "") -> str:
    """Return a line of text; ``anchor``: what of it lies at ``x``, "start", "middle" or "end"."""
    style = f' class="{kind}"' if kind else ""
    return f'<text x="{x:g}" y="{y:g}" text-anchor="{anchor}"{style}>{html.escape(words)}</text>'


def line(x1: float, y1: float, x2: float, y2: float, kind: str = "") -> str:
    """Return a straight line."""
    style = f' class="{kind}"' if kind else ""
    return f'<line x1="{x1:g}" y1="{y1:g}" x2="{x2:g}" y2="{y2:g}"{style}/>'


def drawing(width: float, height: float, label: str, parts: Iterable[str]) -> str:
    """Return a drawing with ``label`` as its text alternative."""
    name = html.escape(label, quote=True)
    return f'<svg viewBox="0 0 {width:g} {height:g}" class="plot" role="img" aria-label="{name}">{"".join(parts)}</svg>'

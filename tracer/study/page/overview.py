"""The overview of a study as SVG: the gain of every method on every scene, with its interval."""

from __future__ import annotations

import html
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from tracer.study.gains import Interval
from tracer.study.page.svg import LogAxis, drawing, line, marker, series, text
from tracer.study.tables import bounds

WIDTH = 480
RIGHT, TOP, BOTTOM = 14, 26, 24
"""Margins around the field of the drawing, which hold its labels."""
METHOD_HEIGHT, SCENE_ROOM = 9, 8
"""Height of the line of a method, and of the room between two scenes."""
LETTER = 7.4
"""About the width of a letter."""
MOST_LETTERS = 24
"""Most letters of a scene's name that are shown."""
MEAN = "geometric mean"
MEASURES = {"gain_samples": "equal samples", "gain_time": "equal time"}
"""Gains that have a drawing, and what they are called."""


@dataclass(frozen=True)
class Overview:
    """The drawings of a budget, one for each of MEASURES."""

    budget: str
    drawings: list[str]


def overviews(record: dict[str, Any]) -> list[Overview]:
    """Return the overview of every budget, that of the largest first; ``record``: what ``results.json`` has."""
    made = []
    for budget in reversed(list(dict.fromkeys(row["budget"] for row in record["rows"]))):
        rows = [row for row in record["rows"] if row["budget"] == budget]
        overall = [mean for mean in record["means"] if mean["budget"] == budget]
        drawings = []
        for field, name in MEASURES.items():
            gains = {(row["scene"], row["method"]): interval(row[field]) for row in rows}
            gains |= {(MEAN, mean["method"]): interval(mean[field]) for mean in overall}
            scenes = [*dict.fromkeys(row["scene"] for row in rows), MEAN]
            drawings.append(draw(record, scenes, gains, f"{name}, {budget}"))
        made.append(Overview(budget, drawings))
    return made


def interval(values: dict[str, float | None] | None) -> Interval | None:
    """Return an interval from plain values, which have None in a file where a bound is NaN."""
    if values is None:
        return None
    return Interval(**{name: math.nan if value is None else value for name, value in values.items()})


def compared(record: dict[str, Any]) -> dict[str, int]:
    """Return the number of each method but the baseline within the plan, which its colour and marker follow."""
    names = [method["name"] for method in record["study"]["methods"]]
    return {name: index for index, name in enumerate(names) if name != record["baseline"]}


def draw(
    record: dict[str, Any], scenes: Sequence[str], gains: dict[tuple[str, str], Interval | None], caption: str
) -> str:
    """Return a line per scene and method: a dot at the gain, and a stroke along its interval."""
    methods = compared(record)
    known = {key: gain for key, gain in gains.items() if key[1] in methods and gain and 0 < gain.mean < math.inf}
    ends = [end for gain in known.values() for end in (gain.low, gain.mean, gain.high) if not math.isnan(end)]
    left = 10 + LETTER * min(MOST_LETTERS, max(map(len, scenes)))
    axis = LogAxis.around([1.0, *ends], left, WIDTH - RIGHT)
    scene_height = max(METHOD_HEIGHT * len(methods) + SCENE_ROOM, 18)
    bottom = TOP + scene_height * len(scenes)
    parts = [text((left + WIDTH - RIGHT) / 2, 14, f"gain at {caption}", kind="strong")]
    for k, scene in enumerate(scenes):
        top = TOP + k * scene_height
        if k % 2 == 0:
            parts.append(f'<rect x="0" y="{top}" width="{WIDTH}" height="{scene_height}" class="band"/>')
        name = scene if len(scene) <= MOST_LETTERS else scene[: MOST_LETTERS - 1] + "…"
        parts.append(text(left - 6, top + scene_height / 2 + 4, name, "end", "strong" if scene == MEAN else ""))
    for tick in axis.ticks():
        place = axis.place(tick)
        parts.append(line(place, TOP, place, bottom, "one" if tick == 1 else "grid"))
        parts.append(text(place, bottom + 15, f"{tick:.3g}", kind="strong" if tick == 1 else ""))
    for k, scene in enumerate(scenes):
        for m, (method, index) in enumerate(methods.items()):
            if (scene, method) in known:
                y = TOP + k * scene_height + scene_height / 2 + METHOD_HEIGHT * (m - (len(methods) - 1) / 2)
                parts.append(gain_line(index, f"{scene}, {method}", known[scene, method], axis, y))
    return drawing(WIDTH, bottom + BOTTOM, alternative(record, known, caption), parts)


def gain_line(index: int, name: str, gain: Interval, axis: LogAxis, y: float) -> str:
    """Return the dot and the stroke of a gain of method ``index``, with its numbers as a note under the pointer."""
    stroke = "" if math.isnan(gain.low) else line(axis.place(gain.low), y, axis.place(gain.high), y, "interval")
    note = html.escape(f"{name}: {bounds(gain)}")
    return f'<g class="{series(index)}"><title>{note}</title>{stroke}{marker(index, axis.place(gain.mean), y)}</g>'


def alternative(record: dict[str, Any], known: dict[tuple[str, str], Interval], caption: str) -> str:
    """Return in words what the drawing shows: the mean gain of each method, and its range over scenes."""
    sentences = []
    for method in compared(record):
        means = [gain.mean for (scene, name), gain in known.items() if name == method and scene != MEAN]
        if means:
            overall = f"{bounds(known[MEAN, method])} in the mean, " if (MEAN, method) in known else ""
            sentences.append(f"{method}: {overall}{min(means):.2f} to {max(means):.2f} over scenes.")
    return f"Gain over {record['baseline']} at {caption}, on a logarithmic axis. " + " ".join(sentences)

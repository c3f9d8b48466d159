"""Tables of a comparison: rows of plain values, as text, Markdown or JSON."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tracer.study.compare import BASELINE, Interval, Measurement, interval
from tracer.study.record import markdown_table


@dataclass(frozen=True)
class Row:
    """One method on one scene at one budget, over all seeds."""

    scene: str
    spp: int
    method: str
    mse: float
    relative_mse: float
    psnr: float
    ssim: float
    samples: int
    seconds: float
    gain_samples: Interval
    """Relative MSE of uniform over that of the method, per sample used."""
    gain_time: Interval
    """The same per second: the error is taken to fall as one over the time."""


def rows(measurements: Sequence[Measurement]) -> list[Row]:
    """Return a row per scene, budget and method, in the order in which they were measured."""
    groups: dict[tuple[str, int, str], list[Measurement]] = {}
    for one in measurements:
        groups.setdefault((one.scene, one.spp, one.method), []).append(one)
    return [summarise(group, groups[scene, spp, BASELINE]) for (scene, spp, _), group in groups.items()]


def summarise(group: Sequence[Measurement], baseline: Sequence[Measurement]) -> Row:
    """Return the row of one method; ``baseline`` has the same seeds in the same order."""

    def mean(name: str) -> float:
        return float(np.mean([getattr(one, name) for one in group]))

    pairs = list(zip(baseline, group, strict=True))
    by_samples = [ratio(u.relative_mse * u.samples, m.relative_mse * m.samples) for u, m in pairs]
    by_time = [ratio(u.relative_mse * u.seconds, m.relative_mse * m.seconds) for u, m in pairs]
    first = group[0]
    return Row(
        first.scene,
        first.spp,
        first.method,
        mean("mse"),
        mean("relative_mse"),
        mean("psnr"),
        mean("ssim"),
        round(mean("samples")),
        mean("seconds"),
        interval(by_samples),
        interval(by_time),
    )


def ratio(baseline: float, error: float) -> float:
    """Return baseline / error, 1 where neither method errs at all."""
    tiny = 1e-30
    return (baseline + tiny) / (error + tiny)


def overall(table: Sequence[Row]) -> list[tuple[int, str, Interval, Interval]]:
    """Return the geometric means of both gains over scenes, per budget and method, with intervals over scenes."""
    groups: dict[tuple[int, str], list[Row]] = {}
    for row in table:
        groups.setdefault((row.spp, row.method), []).append(row)
    return [
        (spp, method, interval([r.gain_samples.mean for r in group]), interval([r.gain_time.mean for r in group]))
        for (spp, method), group in groups.items()
    ]


SCORES = ("relMSE", "MSE", "PSNR", "SSIM")
HEADINGS = ("scene", "spp", "method", *SCORES, "samples", "seconds", "gain, samples", "gain, time")


def cells(row: Row) -> list[str]:
    """Return a row as text."""
    return [
        row.scene,
        str(row.spp),
        row.method,
        f"{row.relative_mse:.3g}",
        f"{row.mse:.3g}",
        f"{row.psnr:.2f}",
        f"{row.ssim:.4f}",
        f"{row.samples / 1e6:.2f} M",
        f"{row.seconds:.2f}",
        bounds(row.gain_samples),
        bounds(row.gain_time),
    ]


def bounds(value: Interval, digits: int = 2) -> str:
    """Return an interval as text."""
    mean, low, high = (f"{number:.{digits}f}" for number in (value.mean, value.low, value.high))
    return mean if np.isnan(value.low) else f"{mean} [{low}, {high}]"


def markdown(table: Sequence[Row]) -> str:
    """Return the gains by scene, their means, and the whole table as Markdown."""
    gains = [markdown_gains(table, spp) for spp in dict.fromkeys(row.spp for row in table)]
    return "\n".join([*gains, markdown_table(HEADINGS, [cells(row) for row in table])])


def markdown_gains(table: Sequence[Row], spp: int) -> str:
    """Return the gains at one budget as Markdown: a line a scene, a column a method, and the means over scenes."""
    table = [row for row in table if row.spp == spp]
    methods = [method for method in dict.fromkeys(row.method for row in table) if method != BASELINE]
    found = {(row.scene, row.method): row.gain_samples for row in table}
    scenes = list(dict.fromkeys(row.scene for row in table))
    lines = [[scene, *(bounds(found[scene, method]) for method in methods)] for scene in scenes]
    means = {method: (samples, seconds) for _, method, samples, seconds in overall(table)}
    for caption, which in (("equal samples", 0), ("equal time", 1)):
        values = (f"**{bounds(means[method][which])}**" for method in methods)
        lines.append([f"**geometric mean, {caption}**", *values])
    return markdown_table([f"{spp} spp, relMSE of uniform over that of", *methods], lines)

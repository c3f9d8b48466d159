"""Tables of a study as text: the rows cell by cell, and whole tables in Markdown."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from tracer.study.clock import clock_warning
from tracer.study.denoised import denoised_over_noisy
from tracer.study.gains import Interval
from tracer.study.plan import Plan
from tracer.study.records import Mean, Row
from tracer.study.results import Results

HEADINGS = (
    "scene",
    "budget",
    "method",
    "relMSE",
    "trimmed",
    "MSE",
    "PSNR",
    "SSIM",
    "FLIP",
    "bias",
    "spp",
    "seconds",
    "drawing",
    "gain, samples",
    "gain, trimmed",
    "gain, time",
    "of oracle, samples",
    "of oracle, time",
)
"""Headings of the table of all rows, in the order of ``cells``."""
CLOSE_MARK = "°"
"""Marks numbers of cells that are too close to the reference."""
UNPAIRED_MARK = "*"
"""Marks a gain at equal time if some of its times were not measured next to the baseline's."""


def bounds(value: Interval | None, digits: int = 2) -> str:
    """Return a value and its interval as text, for example "1.50 [1.40, 1.60]"; a dash for None."""
    if value is None:
        return "–"
    mean, low, high = (f"{number:.{digits}f}" for number in (value.mean, value.low, value.high))
    return mean if np.isnan(value.low) else f"{mean} [{low}, {high}]"


def percent(value: float | None, digits: int = 0) -> str:
    """Return a share as text in percent; a dash for None."""
    return "–" if value is None else f"{100 * value:.{digits}f} %"


def cells(row: Row) -> list[str]:
    """Return a row as text, one cell per heading."""
    scores = row.scores
    close = CLOSE_MARK if row.too_close else ""
    return [
        row.scene,
        row.budget,
        row.method,
        f"{scores.relative_mse:.3g}{close}",
        f"{scores.relative_mse_trimmed:.3g}",
        f"{scores.mse:.3g}",
        f"{scores.psnr:.2f}",
        f"{scores.ssim:.4f}",
        f"{scores.flip:.4f}",
        percent(scores.bias, 2),
        f"{row.spp:.4g}",
        f"{row.seconds:.2f}",
        percent(row.drawing),
        bounds(row.gain_samples) + close,
        bounds(row.gain_trimmed),
        bounds(row.gain_time) + ("" if row.paired else UNPAIRED_MARK),
        percent(row.oracle_share),
        percent(row.oracle_time_share),
    ]


def own_cells(row: Row) -> list[str]:
    """Return a person's own metrics of a row as text, in the order of ``row.own``."""
    return [f"{value:.4g}" for value in row.own.values()]


def measured(plan: Plan) -> str:
    """Return the name of the error that the gains of a study compare."""
    relative = all(method.objective == "relative" for method in plan.methods)
    return "relMSE" if relative else "error (each method's own)"


def markdown_table(headings: Sequence[str], lines: Sequence[Sequence[str]], right_aligned: bool = False) -> str:
    """Return a Markdown table; ``right_aligned``: whether all columns but the first are aligned to the right."""
    head, *rows = ("| " + " | ".join(texts) + " |" for texts in (headings, *lines))
    rule = "| --- |" + " ---: |" * (len(headings) - 1) if right_aligned else "|" + "---|" * len(headings)
    return "\n".join([head, rule, *rows]) + "\n"


def markdown(results: Results) -> str:
    """Return the tables of a study: gains and seconds of every budget, references, failures, and all rows."""
    rows, means = results.tables()
    warning = clock_warning(results)
    parts = [] if warning is None else [f"{warning}\n"]
    for budget in dict.fromkeys(row.budget for row in rows):
        parts += [f"## Gains, {budget}\n", gains(results, rows, means, budget)]
        parts += [f"## Gains at equal time, {budget}\n", gains_at_equal_time(results, rows, means, budget)]
        if (denoised := denoising(results, budget)) is not None:
            parts += [f"## Denoised over noisy, {budget}\n", denoised]
        parts += [f"## Seconds, {budget}\n", seconds([row for row in rows if row.budget == budget])]
    if rows and rows[0].own:
        parts += ["## Own metrics\n", own_metrics(rows)]
    parts += ["## References\n", references(results)]
    if results.failures:
        parts += ["## Failed\n", failed(results)]
    parts += ["## All\n", markdown_table(HEADINGS, [cells(row) for row in rows]), legend(results)]
    return "\n".join(parts)


def own_metrics(rows: Sequence[Row]) -> str:
    """Return the means of a person's own metrics: a line per scene, budget and method, and a column per metric."""
    headings = ["scene", "budget", "method", *rows[0].own]
    lines = [[row.scene, row.budget, row.method, *own_cells(row)] for row in rows]
    return markdown_table(headings, lines)


def gains(results: Results, rows: Sequence[Row], means: Sequence[Mean], budget: str) -> str:
    """Return the gains at one budget: a line per scene and mean, a column per method, and the limit of each scene."""
    baseline, methods = results.plan.compared_with, compared_methods(results)
    lines = lines_of_scenes(results, rows, budget, lambda row: cells(row)[HEADINGS.index("gain, samples")])
    lines = [[*line, f"{facts.limit:.2f}"] for line, facts in zip(lines, results.scenes, strict=True)]
    overall = {mean.method: mean for mean in means if mean.budget == budget}
    captions = {"gain_samples": "equal samples", "gain_trimmed": "equal samples, trimmed", "gain_time": "equal time"}
    for field, caption in captions.items():
        values = [mean_text(overall.get(method), field, len(results.scenes)) for method in methods]
        lines.append([f"**geometric mean, {caption}**", *(f"**{value}**" for value in values), ""])
    for field, caption in (("oracle_share", "samples"), ("oracle_time_share", "time")):
        shares = [getattr(overall[method], field) if method in overall else None for method in methods]
        if any(share is not None for share in shares):
            caption = f"**share of what an oracle gains, equal {caption}**"
            lines.append([caption, *(f"**{percent(share)}**" for share in shares), ""])
    return markdown_table(
        [f"{budget}, {measured(results.plan)} of {baseline} over that of", *methods, "1 + CV²"], lines
    )


def compared_methods(results: Results) -> list[str]:
    """Return the names of all methods but the baseline."""
    return [method.name for method in results.plan.methods if method.name != results.plan.compared_with]


def lines_of_scenes(
    results: Results, rows: Sequence[Row], budget: str, text_of: Callable[[Row], str]
) -> list[list[str]]:
    """Return a line per scene: its name, and for each method that is compared the text of its row at a budget."""
    row_of = {(row.scene, row.method): row for row in rows if row.budget == budget}
    lines = []
    for facts in results.scenes:
        scene_rows = [row_of.get((facts.name, method)) for method in compared_methods(results)]
        lines.append([facts.name, *(text_of(row) if row else "failed" for row in scene_rows)])
    return lines


def gains_at_equal_time(results: Results, rows: Sequence[Row], means: Sequence[Mean], budget: str) -> str:
    """Return the gains at equal time: a line per scene and for the mean, a column per method."""
    methods, lines = compared_methods(results), lines_of_scenes(results, rows, budget, time_gain_text)
    overall = {mean.method: mean for mean in means if mean.budget == budget}
    texts = [
        ", ".join(
            mean_text(overall.get(method), field, len(results.scenes)) for field in ("gain_time", "gain_trimmed_time")
        )
        for method in methods
    ]
    lines.append(["**geometric mean**", *(f"**{text}**" for text in texts)])
    return markdown_table([f"{budget}, {measured(results.plan)}, then trimmed", *methods], lines)


def time_gain_text(row: Row) -> str:
    """Return the gains of a row at equal time as text, in its error and in the trimmed one."""
    return f"{bounds(row.gain_time)}, {bounds(row.gain_trimmed_time)}" + ("" if row.paired else UNPAIRED_MARK)


def denoising(results: Results, budget: str) -> str | None:
    """Return the errors of denoised pictures over those of noisy ones at a budget; None if nothing is denoised."""
    headings, values = denoised_over_noisy(results, budget)
    if not headings:
        return None
    lines = [[line, *(bounds(value) for value in intervals)] for line, intervals in values.items()]
    lines[-1] = [f"**{text}**" for text in lines[-1]]
    return markdown_table([budget, *headings], lines)


def mean_text(mean: Mean | None, field: str, scenes: int) -> str:
    """Return a mean over scenes as text, with the number of its scenes if it is less than ``scenes``."""
    if mean is None:
        return "–"
    return bounds(getattr(mean, field)) + ("" if mean.scenes == scenes else f" ({mean.scenes} of {scenes} scenes)")


def seconds(rows: Sequence[Row]) -> str:
    """Return seconds at one budget: a line per scene, a column per method; in brackets the share not spent drawing."""
    methods = list(dict.fromkeys(row.method for row in rows))
    row_of = {(row.scene, row.method): row for row in rows}
    lines = []
    for scene in dict.fromkeys(row.scene for row in rows):
        scene_rows = [row_of.get((scene, method)) for method in methods]
        lines.append([scene, *(duration(row) if row else "failed" for row in scene_rows)])
    return markdown_table(["seconds (share in which nothing is drawn)", *methods], lines)


def duration(row: Row) -> str:
    """Return the seconds of a row as text, with the share not spent drawing if there is any."""
    idle = 1 - row.drawing
    return f"{row.seconds:.2f}" + (f" ({percent(idle)})" if idle > 0 else "")


def references(results: Results) -> str:
    """Return the table of references: their samples, their own error, and whether their halves agree."""
    lines = [
        [
            facts.name,
            f"{facts.width} x {facts.height}",
            str(facts.reference_spp),
            f"{facts.reference_relative_mse:.2g}",
            f"{facts.reference_mse:.2g}",
            "yes" if facts.halves_agree else f"NO (p = {facts.disagreement:.1g})",
        ]
        for facts in results.scenes
    ]
    return markdown_table(["scene", "pixels", "spp", "relMSE of it", "MSE of it", "halves agree"], lines)


def failed(results: Results) -> str:
    """Return the table of cells that could not be rendered, and why."""
    lines = [
        [failure.scene, failure.method, failure.budget, str(failure.seed), failure.message]
        for failure in results.failures
    ]
    return markdown_table(["scene", "method", "budget", "seed", "why"], lines)


def legend(results: Results) -> str:
    """Return the meaning of the columns and marks, as text below the table."""
    return (
        "relMSE: squared error over the reference's squared luminance + 0.01, mean over pixels; trimmed: without the "
        "0.1 % of the pixels that err most. PSNR and SSIM: as a screen shows it. FLIP: HDR-FLIP at the reference's "
        "exposures. bias: mean signed error over the mean of the reference. drawing: share of the seconds in which "
        f"samples were drawn. gain: relMSE of {results.plan.compared_with} over that of the method (MSE for a method "
        "whose objective is absolute, squared error on the screen for display), ratio of means "
        "over seeds, with its 95 % bootstrap interval over seeds (expanded percentiles; with fewer than five "
        "seeds it is too narrow); at equal time the error of the baseline is taken to "
        "fall with its time at the rate that its budgets show. of oracle: log(gain) over log(limit), which is what "
        "an oracle gained that had measured every pixel beforehand, or 1 + CV² of the variance of samples where the "
        "study has no oracle; only where it is above 1.1. "
        "denoised over noisy: ratio of mean errors over seeds, so less than 1 where denoising helps. "
        "From MSE and relMSE that of the reference, known from its halves, is subtracted. "
        f"{CLOSE_MARK}: the error is less than ten times that of the reference (RMS). "
        f"{UNPAIRED_MARK}: some times were not measured next to the baseline's.\n"
    )

"""The demonstration: a bundled scene, adaptive and uniform, with as many samples and in as much time; a reference."""

from __future__ import annotations

from dataclasses import dataclass
from importlib.resources import as_file, files
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tracer.api import render
from tracer.core import backend
from tracer.core.quantities import mean_count
from tracer.image.metrics import Scores, all_scores
from tracer.io.atomic import write_text
from tracer.progress import ProgressCallback, StepCallback
from tracer.result import Result
from tracer.study.methods import Setting
from tracer.study.panels import Panel, relative_error, write_panels
from tracer.study.reference import make_reference
from tracer.study.tables import markdown_table
from tracer.study.verdict import less

SCENE = "spheres_and_rods"
"""Name of the bundled scene."""
CRITERION = "fused"
"""Criterion of the adaptive picture."""
AS_LONG = "uniform, as long"
"""Name of the uniform picture that takes as much time as the adaptive one."""
SPP = 64
"""Samples per pixel of the uniform and the adaptive picture, on average."""
REFERENCE_SPP = 2048
"""Least samples per pixel of the reference."""
WARM_UP_SPP = 4
"""Samples per pixel of the renderings that compile the kernels."""
HEADINGS = ("method", "relMSE", "PSNR", "SSIM", "FLIP", "samples", "seconds")
"""Headings of the table, in the order of ``DemoRow.cells``."""


@dataclass(frozen=True)
class DemoRow:
    """A line of the table: a method, its scores, and the samples and seconds that it took."""

    method: str
    scores: Scores
    samples: int
    seconds: float

    def cells(self) -> list[str]:
        """Return the line as text, one cell per heading."""
        scores, samples = self.scores, f"{self.samples / 1e6:.2f} M"
        errors = [f"{scores.relative_mse:.3g}", f"{scores.psnr:.2f}", f"{scores.ssim:.4f}", f"{scores.flip:.4f}"]
        return [self.method, *errors, samples, f"{self.seconds:.2f}"]


def told(method: str, progress: StepCallback | None) -> ProgressCallback | None:
    """Return the callback with which a rendering reports to ``progress``; None without ``progress``."""
    return progress and (lambda state: progress(f"{SCENE}: {method}", state.done, state.total))


def run_demo(picture: Path, table: Path, progress: StepCallback | None = None) -> list[DemoRow]:
    """Write a picture and a table to these files, and return the lines of the table: uniform, as long, adaptive.

    Raises KeyboardInterrupt if ``progress`` stops it.
    """
    backend.activate()
    with as_file(files("tracer.scenes") / f"{SCENE}.xml") as scene:

        def report_reference(done: int, total: int) -> bool | None:
            return progress(f"{SCENE}: reference", done, total) if progress else None

        def draw(method: str, criterion: str, spp: int) -> Result:
            result = render(scene, spp=spp, criterion=criterion, progress=told(method, progress))
            if not result.report.complete:
                raise KeyboardInterrupt
            return result

        truth = make_reference(Setting(scene), REFERENCE_SPP, report_reference).image
        for criterion in ("uniform", CRITERION):  # compiles the kernels, whose time is not compared
            draw("compiling", criterion, WARM_UP_SPP)
        uniform, adaptive = (draw(criterion, criterion, SPP) for criterion in ("uniform", CRITERION))
        longer = draw(AS_LONG, "uniform", spp_in(adaptive.seconds, uniform))
    lines = [
        DemoRow(method, all_scores(result.image, truth), int(result.samples.sum()), result.seconds)
        for method, result in (("uniform", uniform), (AS_LONG, longer), (CRITERION, adaptive))
    ]
    write_picture(picture, lines, (uniform, longer, adaptive), truth)
    write_text(table, f"{markdown_table(HEADINGS, [line.cells() for line in lines])}\n{in_words(lines)}\n")
    return lines


def spp_in(seconds: float, uniform: Result) -> int:
    """Return the samples per pixel that uniform sampling draws in ``seconds``, at the pace of a picture of its own."""
    return max(1, round(float(uniform.samples.mean()) * seconds / uniform.seconds))


def in_words(lines: list[DemoRow]) -> str:
    """Return in a sentence what the adaptive picture has won, in samples and in time, and what it has lost."""
    uniform, longer, adaptive = (line.scores for line in lines)
    worse = [
        name
        for name, difference in (("SSIM", longer.ssim - adaptive.ssim), ("FLIP", adaptive.flip - longer.flip))
        if difference > 0
    ]
    doubt = f"; by {' and '.join(worse)} the uniform picture of the same time is better" if worse else ""
    return (
        f"Against uniform sampling, the adaptive picture has {less(uniform.relative_mse / adaptive.relative_mse)} "
        f"squared relative error (relMSE) with as many samples (in {lines[2].seconds:.1f} s instead of "
        f"{lines[0].seconds:.1f} s), and {less(longer.relative_mse / adaptive.relative_mse)} in the same time{doubt}."
    )


def write_picture(picture: Path, lines: list[DemoRow], results: tuple[Result, ...], truth: NDArray) -> None:
    """Write the pictures side by side, their errors below them, and the samples per pixel of the last."""
    errors = [relative_error(result.image, truth) for result in results]
    error_top = float(np.quantile(errors[0], 0.99))
    names = ("uniform", "uniform, in the time of adaptive", "adaptive")
    shown: list[Panel] = [
        (f"{name}: {mean_count(result.samples.mean())} spp, {result.seconds:.1f} s", result.image, False)
        for name, result in zip(names, results, strict=True)
    ]
    shown.append(("adaptive: samples per pixel", results[-1].samples, True))
    shown += [
        (f"relative error: relMSE {line.scores.relative_mse:.2e}", error, False)
        for line, error in zip(lines, errors, strict=True)
    ]
    shown.append((f"reference, {REFERENCE_SPP} spp", truth, False))
    write_panels(picture, shown, f"{SCENE}, spp: samples per pixel on average", error_top, columns=len(shown) // 2)

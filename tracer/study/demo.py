"""The demonstration: a bundled scene rendered uniformly and adaptively with as many samples, and a reference."""

from __future__ import annotations

from dataclasses import dataclass
from importlib.resources import as_file, files
from pathlib import Path

from tracer.api import render
from tracer.core import backend
from tracer.image.metrics import Scores, all_scores
from tracer.io.atomic import write_text
from tracer.progress import ProgressCallback, StepCallback
from tracer.study.methods import Setting
from tracer.study.panels import Panel, relative_error, write_panels
from tracer.study.reference import make_reference
from tracer.study.tables import markdown_table

SCENE = "spheres_and_rods"
"""Name of the bundled scene."""
CRITERION = "fused"
"""Criterion of the adaptive picture."""
SPP = 64
"""Samples per pixel of both pictures, on average."""
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
    """Write a picture and a table to these files, and return the lines of the table.

    Raises KeyboardInterrupt if ``progress`` stops it.
    """
    backend.activate()
    with as_file(files("tracer.scenes") / f"{SCENE}.xml") as scene:

        def report_reference(done: int, total: int) -> bool | None:
            return progress(f"{SCENE}: reference", done, total) if progress else None

        truth = make_reference(Setting(scene), REFERENCE_SPP, report_reference).image
        results = {}
        for method in ("uniform", CRITERION):
            render(scene, spp=WARM_UP_SPP, criterion=method)  # compiles the kernels, whose time is not compared
            results[method] = render(scene, spp=SPP, criterion=method, progress=told(method, progress))
            if not results[method].report.complete:
                raise KeyboardInterrupt
    lines = [
        DemoRow(method, all_scores(result.image, truth), int(result.samples.sum()), result.seconds)
        for method, result in results.items()
    ]
    uniform, adaptive = results.values()
    errors = [relative_error(result.image, truth) for result in results.values()]
    error_top = float(sorted(errors[0].ravel())[int(0.99 * errors[0].size)])
    panels: list[Panel] = [
        (f"uniform, {SPP} samples per pixel", uniform.image, False),
        (f"adaptive, {SPP} samples per pixel on average", adaptive.image, False),
        ("samples per pixel", adaptive.samples, True),
        (f"relative error, uniform: relMSE {lines[0].scores.relative_mse:.2e}", errors[0], False),
        (f"relative error, adaptive: relMSE {lines[1].scores.relative_mse:.2e}", errors[1], False),
    ]
    write_panels(picture, panels, SCENE, error_top)
    write_text(table, markdown_table(HEADINGS, [line.cells() for line in lines]))
    return lines

"""The demonstration: one bundled scene, uniform and adaptive at the same number of samples, against a reference."""

from __future__ import annotations

from importlib.resources import as_file, files
from pathlib import Path

from tracer import backend
from tracer.files import write_text
from tracer.loop import ProgressCallback, render
from tracer.study.compare import BASELINE, judge
from tracer.study.picture import Panel, relative_error, write_panels
from tracer.study.run import Comparison, StepCallback, make_reference
from tracer.study.table import Row, markdown, rows

SCENE = "spheres_and_rods"
CRITERION = "fused"
SPP = 64
REFERENCE_SPP = 1024
WARM_UP_SPP = 4


def told(method: str, progress: StepCallback | None) -> ProgressCallback | None:
    """Return the callback of a render that passes its progress on."""
    return progress and (lambda now: progress(f"{SCENE}: {method}", now.done, now.total))


def run_demo(picture: Path, table: Path, progress: StepCallback | None = None) -> list[Row]:
    """Write ``picture`` and ``table`` and return the table. Raises KeyboardInterrupt if ``progress`` stops it."""
    backend.activate()
    with as_file(files("tracer.scenes") / f"{SCENE}.xml") as scene:
        truth = make_reference(Comparison(reference_spp=REFERENCE_SPP), scene, SCENE, progress)
        results = {}
        for method in (BASELINE, CRITERION):
            render(scene, spp=WARM_UP_SPP, criterion=method)  # compiles the kernels, which is not what is compared
            results[method] = render(scene, spp=SPP, criterion=method, progress=told(method, progress))
            if not results[method].report.complete:
                raise KeyboardInterrupt
    measurements = [
        judge(SCENE, method, SPP, 0, result.image, truth.image, int(result.samples.sum()), result.seconds)
        for method, result in results.items()
    ]
    uniform, adaptive = results[BASELINE], results[CRITERION]
    errors = {method: relative_error(result.image, truth.image) for method, result in results.items()}
    top = float(sorted(errors[BASELINE].ravel())[int(0.99 * errors[BASELINE].size)])
    panels: list[Panel] = [
        (f"uniform, {SPP} samples per pixel", uniform.image, False),
        (f"adaptive, {SPP} samples per pixel on average", adaptive.image, False),
        ("samples per pixel", adaptive.samples, True),
        (f"relative error, uniform: relMSE {measurements[0].relative_mse:.2e}", errors[BASELINE], False),
        (f"relative error, adaptive: relMSE {measurements[1].relative_mse:.2e}", errors[CRITERION], False),
    ]
    write_panels(picture, panels, SCENE, top)
    summary = rows(measurements)
    write_text(table, markdown(summary))
    return summary

"""A comparison over scenes: references, measurements, tables and pictures."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import asdict, dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tracer import backend, score
from tracer.errors import SettingsError
from tracer.loop import Progress
from tracer.scene import Size, open_scene
from tracer.settings import make_settings
from tracer.study.compare import BASELINE, STOCK_SAMPLERS, Measurement, measure, open_methods
from tracer.study.picture import Panel, relative_error, write_panels
from tracer.study.record import record_files, write_record
from tracer.study.reference import FACTOR, Reference, reference
from tracer.study.table import Row, markdown, rows

StepCallback = Callable[[str, int, int], bool | None]
"""Called with what is under way and how much of how much is done; return False to stop."""


@dataclass(frozen=True)
class Comparison:
    """What to compare."""

    spps: list[int] = field(default_factory=lambda: [64])
    seeds: int = 5
    first_seed: int = 0
    criteria: list[str] = field(default_factory=lambda: ["fused"])
    objective: str = "relative"
    integrator: str | None = None
    sensor: int = 0
    size: int | None = None
    reference_spp: int | None = None

    def check(self, scenes: Sequence[Path]) -> None:
        """Raise an error for a setting or scene that cannot be used, before anything is rendered."""
        for spp in self.spps:
            for criterion in self.criteria:
                make_settings(spp=spp, criterion=criterion, objective=self.objective)
        if self.reference_spp is not None and self.reference_spp <= max(self.spps):
            raise SettingsError(
                f"reference_spp ({self.reference_spp}) must be well above the largest spp ({max(self.spps)})."
            )
        check_names(scenes)
        backend.activate()
        for scene in scenes:
            with ExitStack() as stack:
                open_methods(stack, scene, self.criteria, self.integrator, self.sensor, self.size, self.objective)
                height, width = stack.enter_context(open_scene(scene, self.sensor, self.integrator, self.size)).size
            if min(height, width) < score.SSIM_WINDOW:
                raise SettingsError(
                    f"'{scene}' is {width} x {height} pixels; structural similarity needs at least "
                    f"{score.SSIM_WINDOW} a side, use a larger --size."
                )

    def files(self, scenes: Sequence[Path]) -> tuple[str, ...]:
        """Return the names of the files that the comparison writes."""
        return (*record_files("compare"), *(f"{scene_name(scene)}.png" for scene in scenes))

    @property
    def samples_of_reference(self) -> int:
        """Samples per pixel of the reference."""
        return self.reference_spp or FACTOR * max(self.spps)


def check_names(scenes: Sequence[Path]) -> None:
    """Raise SettingsError if two scenes have one name."""
    names = [scene_name(scene) for scene in scenes]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise SettingsError(f"Two scenes are named '{twice}'; rename one, results are kept by name.")


def check_scenes(scenes: Sequence[Path], size: Size = None) -> None:
    """Raise an error for a scene that does not open, before anything is rendered."""
    for scene in scenes:
        with open_scene(scene, size=size):
            pass


def scene_name(path: Path) -> str:
    """Return what a scene is called: its file, or its folder where the file is just ``scene.xml``."""
    return path.resolve().parent.name if path.stem == "scene" else path.stem


def run_comparison(
    comparison: Comparison, scenes: Sequence[Path], output: Path | None, progress: StepCallback | None = None
) -> list[Row]:
    """Measure every scene and return the table. Into ``output``, if given, after every scene: ``compare.json``,
    ``compare.md`` and a picture ``SCENE.png``. Raises KeyboardInterrupt if ``progress`` stops it.
    """
    measurements: list[Measurement] = []
    for scene in scenes:
        name = scene_name(scene)
        truth = make_reference(comparison, scene, name, progress)
        measured, images = measure_scene(comparison, scene, name, truth, progress)
        measurements += measured
        if output is not None:
            write_tables(output, comparison, measurements)
            write_picture(output / f"{name}.png", name, comparison, images, truth)
    return rows(measurements)


def measure_scene(
    comparison: Comparison, scene: Path, name: str, truth: Reference, progress: StepCallback | None
) -> tuple[list[Measurement], dict[str, NDArray[np.float32]]]:
    """Return the measurements of a scene, and the first picture of every method and budget as "METHOD SPP"."""
    images: dict[str, NDArray[np.float32]] = {}
    methods = len({BASELINE, *comparison.criteria}) + len(STOCK_SAMPLERS)
    total = methods * len(comparison.spps) * comparison.seeds
    count = 0

    def done(one: Measurement, image: NDArray[np.float32]) -> bool | None:
        nonlocal count
        count += 1
        images.setdefault(f"{one.method} {one.spp}", image)
        return None if progress is None else progress(f"{name}: {one.method}, {one.spp} spp", count, total)

    measurements = measure(
        scene,
        name,
        truth.image,
        comparison.spps,
        range(comparison.first_seed, comparison.first_seed + comparison.seeds),
        comparison.criteria,
        integrator=comparison.integrator,
        sensor=comparison.sensor,
        size=comparison.size,
        objective=comparison.objective,
        done=done,
    )
    return measurements, images


def make_reference(comparison: Comparison, scene: Path, name: str, progress: StepCallback | None) -> Reference:
    """Return the reference of a scene, rendered now or before."""

    def passed(now: Progress) -> bool | None:
        return None if progress is None else progress(f"{name}: reference", now.done, now.total)

    return reference(
        scene,
        comparison.samples_of_reference,
        integrator=comparison.integrator,
        sensor=comparison.sensor,
        size=comparison.size,
        progress=passed,
    )


def write_tables(folder: Path, comparison: Comparison, measurements: Sequence[Measurement]) -> None:
    """Write all numbers as JSON and the table as Markdown."""
    table = rows(measurements)
    numbers = {
        "comparison": asdict(comparison),
        "measurements": [asdict(one) for one in measurements],
        "table": [asdict(row) for row in table],
    }
    first, last = comparison.first_seed, comparison.first_seed + comparison.seeds - 1
    write_record(folder, "compare", numbers, markdown(table), f"seeds {first} to {last}")


def write_picture(
    path: Path, name: str, comparison: Comparison, images: dict[str, NDArray[np.float32]], truth: Reference
) -> None:
    """Write uniform and adaptive side by side, with the error of each and the reference."""
    spp = comparison.spps[0]
    adaptive = next((name for name in comparison.criteria if name != BASELINE), BASELINE)
    uniform_image, adaptive_image = images[f"{BASELINE} {spp}"], images[f"{adaptive} {spp}"]
    errors = [relative_error(image, truth.image[..., : image.shape[-1]]) for image in (uniform_image, adaptive_image)]
    top = float(np.quantile(errors[0], 0.99))
    panels: list[Panel] = [
        (BASELINE, uniform_image, False),
        (adaptive, adaptive_image, False),
        (f"relative error, {BASELINE}", errors[0], False),
        (f"relative error, {adaptive}", errors[1], False),
        (f"reference, {truth.spp} spp", truth.image, False),
    ]
    write_panels(path, panels, f"{name}, {spp} spp", error_top=top)

"""Run a study: check it, then scene by scene render what is missing, make a reference, score, and write everything."""

from __future__ import annotations

import datetime
import os
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from tracer.core import backend
from tracer.core.protocols import DaskClient
from tracer.image.metrics import Scores, relative_mse
from tracer.progress import StepCallback
from tracer.study import cells, oracle, render_cells
from tracer.study.cells import Cell, RenderCost
from tracer.study.check import check_study, count_scenes, one_at_a_time, prepare_output
from tracer.study.methods import TimedPicture
from tracer.study.own_metrics import Metric, check_metrics, metrics_of, values_of
from tracer.study.page.build import require_page_packages, write_page
from tracer.study.page.scene import ScenePictures, Shown
from tracer.study.plan import Plan, Scene
from tracer.study.records import CLOSE, Failure, Measurement, SceneFacts
from tracer.study.reference import Reference, make_reference
from tracer.study.results import Results
from tracer.study.score_cache import ScoreBook
from tracer.study.write import PAGE, write_results

OBJECTIVE = "relative"
"""Objective whose error the limit of a scene is of; the gain of a method is of the method's own objective."""
PAGE_SECONDS = 60.0
"""Least seconds from one writing of the page to the next, as it takes a second or two per scene."""
LEAST_LEFT = 0.1
"""Least part of a measured squared error that remains when the reference's error is subtracted."""
MARGIN = 1.2
"""Factor on the samples that a reference still needs, judged by its error so far."""


def run_study(
    plan: Plan,
    output: Path,
    progress: StepCallback | None = None,
    overwrite: bool = False,
    cluster: int | str | DaskClient | None = None,
    metrics: Mapping[str, Metric] | None = None,
) -> Results:
    """Measure all that a plan asks for, write it to the folder ``output`` after every scene, and return it.

    Cells that an earlier run of the same study left there are not rendered again, unless ``overwrite``, which replaces
    each as soon as its new picture is made, and removes another study. Raises SettingsError or MissingPackageError
    before the first ray, and KeyboardInterrupt if ``progress`` stops it: all finished cells are kept. ``cluster``:
    workers that render the cells, as in ``tracer.render``; references are rendered by this process.

    ``metrics``: functions of your own, by name, beside those in the files that the plan names, from a picture and its
    reference, both (H, W, 3) float64 in linear sRGB, to a number. Each gets a column in ``results.csv``, an entry in
    ``results.json``, and in ``results.md`` a table of means over seeds; in Python, ``Row.own`` and ``Measurement.own``
    have the values. They are computed anew whenever the study is run, of kept pictures too, so that a study that is
    finished can be given another metric.

    Example::

        from pathlib import Path

        from tracer.study.plan import make_plan
        from tracer.study.run import run_study


        def worst(picture, reference):
            return abs(picture - reference).max()


        methods = [{"name": name, "criterion": name} for name in ("uniform", "fused")]
        scenes = [{"path": "scene.xml"}]
        plan = make_plan({"name": "mine", "spp": [16], "seeds": 2, "scenes": scenes, "methods": methods})
        results = run_study(plan, Path("mine"), metrics={"worst": worst})
        rows, means = results.tables()
        {(row.scene, row.method): row.own["worst"] for row in rows}
    """
    own_metrics = metrics_of(plan) | dict(metrics or {})
    check_metrics(own_metrics)
    require_page_packages()
    backend.activate()
    scenes = plan.find_scenes()
    check_study(plan, scenes)
    with one_at_a_time(output):
        prepare_output(plan, output, overwrite)
        if cluster is None:
            return Study(plan, scenes, output, overwrite, progress, metrics=own_metrics).run()
        from tracer.cluster.connection import open_connection
        from tracer.study import render_cells_remote

        with open_connection(cluster) as connection:
            render_scene = partial(render_cells_remote.render_cells, connection=connection)
            return Study(plan, scenes, output, overwrite, progress, render_scene, own_metrics).run()


class Study:
    """A study that is running."""

    def __init__(
        self,
        plan: Plan,
        scenes: Sequence[Scene],
        output: Path,
        overwrite: bool,
        progress: StepCallback | None,
        render_scene: Callable[..., list[Failure]] = render_cells.render_cells,
        metrics: Mapping[str, Metric] | None = None,
    ) -> None:
        self.metrics = metrics or {}
        self.render_scene = render_scene
        self.plan, self.scenes, self.output, self.progress = plan, scenes, output, progress
        self.run_id = f"{datetime.datetime.now(datetime.UTC):%Y-%m-%dT%H:%M:%S}-{os.getpid()}"
        self.results = Results(plan)
        self.pictures: list[ScenePictures] = []
        self.blocks = {scene.name: cells.cells_of(plan, scene) for scene in scenes}
        self.book = ScoreBook(output / cells.FOLDER / "scores.json")
        self.overwrite = overwrite
        self.total = 0
        self.done = 0
        self.text = ""
        self.page_written = time.monotonic()
        self.scenes_before = max(1, count_scenes(output))

    def run(self) -> Results:
        """Render and measure scene after scene, and return the results."""
        blocks_to_render = {name: self.blocks_to_render(blocks) for name, blocks in self.blocks.items()}
        self.total = count_cells(blocks_to_render)
        self.results.kept = count_cells(self.blocks) - self.total
        try:
            for scene in self.scenes:
                if blocks := blocks_to_render[scene.name]:
                    self.results.failures += self.render_scene(
                        self.plan, scene, blocks, self.output, self.run_id, self.report_cell
                    )
                try:
                    self.measure(scene, self.cells_to_measure(scene))
                except Exception as error:  # the other scenes can still be measured
                    self.results.failures.append(
                        Failure(scene.name, "reference", "all", 0, render_cells.one_line(error))
                    )
                self.results.finished = scene is self.scenes[-1]
                self.write(time.monotonic() - self.page_written > PAGE_SECONDS)
        finally:
            self.write(page=True)
        return self.results

    def blocks_to_render(self, blocks: Sequence[Sequence[Cell]]) -> list[list[Cell]]:
        """Return the cells of each block that are not kept, or all if they are to be replaced; no empty block."""
        wanted = (
            [cell for cell in block if self.overwrite or not cells.is_kept(cell, self.output)] for block in blocks
        )
        return [block for block in wanted if block]

    def cells_to_measure(self, scene: Scene) -> list[Cell]:
        """Return the cells of a scene without those that failed, of which an older picture may be there."""
        failed = {(entry.scene, entry.method, entry.budget, entry.seed) for entry in self.results.failures}
        scene_cells = [cell for block in self.blocks[scene.name] for cell in block]
        return [cell for cell in scene_cells if (cell.scene, cell.method, cell.budget.label, cell.seed) not in failed]

    def write(self, page: bool) -> None:
        """Write the results so far, unless the folder holds those of more scenes from an earlier run."""
        if not (self.results.finished or len(self.results.scenes) >= self.scenes_before):
            return
        write_results(self.output, self.results)
        if page:
            write_page(self.output / PAGE, self.results, self.pictures)
            self.page_written = time.monotonic()

    def tell(self, text: str, done: int, total: int) -> None:
        """Report progress to the caller. Raises KeyboardInterrupt if the callback asks to stop."""
        if self.progress is not None and self.progress(text, done, total) is False:
            raise KeyboardInterrupt

    def report_cell(self, cell: Cell | None, text: str) -> None:
        """Report a cell that is done, or, if ``cell`` is None, that one is being rendered."""
        self.done += cell is not None
        self.text = text or self.text
        self.tell(f"{self.text} ({self.done} of {self.total})", self.done, self.total)

    def measure(self, scene: Scene, scene_cells: Sequence[Cell]) -> None:
        """Score the pictures of a scene against a reference that is good enough for them."""
        readable = [entry for cell in scene_cells if (entry := self.read(cell)) is not None]
        usable = [entry for entry in readable if self.is_finite(*entry[:2])]
        if not usable:
            return
        reference = self.good_reference(scene, [picture.image for _, picture, _ in usable])
        facts = describe_scene(scene.name, reference)
        measured = []
        for k, (cell, picture, took) in enumerate(usable):
            self.tell(f"{scene.name}: scores", k, len(usable))
            scores = self.book.scores(picture.image, reference)
            too_close = CLOSE**2 * scores.relative_mse < facts.reference_relative_mse
            own = values_of(self.metrics, picture.image, reference.image)
            measured.append(Measurement(cell, took, without_error_of(reference, scores), too_close, own))
        self.book.save()
        self.results.scenes.append(facts)
        self.results.measurements += measured
        self.pictures.append(choose_pictures(self.plan, reference, measured, [picture for _, picture, _ in usable]))

    def read(self, cell: Cell) -> tuple[Cell, TimedPicture, RenderCost] | None:
        """Return a cell with its picture, or None if it has no picture.

        A damaged file is removed, so that the next run makes it again, and counts as a failure.
        """
        if not cells.is_kept(cell, self.output):
            return None
        try:
            return cell, *cells.load(cell, self.output)
        except Exception as error:  # reading a damaged file may raise anything
            cell.path(self.output).unlink()
            self.results.failures.append(render_cells.failure(cell, error))
            return None

    def is_finite(self, cell: Cell, picture: TimedPicture) -> bool:
        """Return whether all pixels of a picture are finite; if not, the cell counts as a failure."""
        bad_count = np.count_nonzero(~np.isfinite(picture.image).all(axis=-1))
        if bad_count:
            message = f"{bad_count} pixels of the picture are not finite"
            self.results.failures.append(Failure(cell.scene, cell.method, cell.budget.label, cell.seed, message))
        return not bad_count

    def good_reference(self, scene: Scene, images: Sequence[Any]) -> Reference:
        """Return a reference with a tenth of the least error (RMS) of ``images``, or the best that the plan allows."""
        spp = min(self.plan.reference_spp, 4 * int(max([64, *self.plan.spp])))
        while True:
            reference = self.reference(scene, spp)
            smallest = min(relative_mse(image, reference.image) for image in images)
            ratio = reference.relative_mse / max(CLOSE**2 * smallest, 1e-30)
            if ratio <= 1 or reference.spp >= self.plan.reference_spp:
                return reference
            spp = min(self.plan.reference_spp, round(reference.spp * ratio * MARGIN))

    def reference(self, scene: Scene, spp: int) -> Reference:
        """Return a reference of at least ``spp`` samples per pixel, reporting progress."""

        def report_progress(done: int, total: int) -> None:
            self.tell(f"{scene.name}: reference, {done} of {total} spp", done, total)

        return make_reference(scene.setting, spp, report_progress)


def count_cells(blocks: Mapping[str, Sequence[Sequence[Cell]]]) -> int:
    """Return the number of cells in blocks of cells by scene."""
    return sum(len(block) for scene_blocks in blocks.values() for block in scene_blocks)


def without_error_of(reference: Reference, scores: Scores) -> Scores:
    """Return scores with the squared errors against the truth: the reference's, which is independent, is subtracted.

    At least the part LEAST_LEFT of each squared error remains.
    """

    def subtract(measured: float, reference_error: float) -> float:
        return max(measured - reference_error, LEAST_LEFT * measured)

    return replace(
        scores,
        mse=subtract(scores.mse, reference.mse),
        relative_mse=subtract(scores.relative_mse, reference.relative_mse),
    )


def describe_scene(name: str, reference: Reference) -> SceneFacts:
    """Return the size of a scene, the samples and error of its reference, and the scene's limit."""
    height, width = reference.image.shape[:2]
    return SceneFacts(
        name=name,
        width=width,
        height=height,
        reference_spp=reference.spp,
        reference_mse=reference.mse,
        reference_relative_mse=reference.relative_mse,
        halves_agree=reference.halves_agree,
        disagreement=reference.disagreement,
        limit=oracle.limit(reference.variance, reference.image, OBJECTIVE),
    )


def choose_pictures(
    plan: Plan, reference: Reference, measured: Sequence[Measurement], pictures: Sequence[TimedPicture]
) -> ScenePictures:
    """Return the pictures of the first seed at the largest budget, one in samples if there is any, for the page."""
    budget = max(
        {entry.cell.budget for entry in measured}, key=lambda candidate: (candidate.kind == "spp", candidate.amount)
    )
    seed = min(entry.cell.seed for entry in measured if entry.cell.budget == budget)
    shown = {
        entry.cell.method: Shown(entry.cell.method, picture.image, picture.counts, entry.scores.relative_mse)
        for entry, picture in zip(measured, pictures, strict=True)
        if entry.cell.budget == budget and entry.cell.seed == seed
    }
    names = [plan.compared_with, *(method.name for method in plan.methods if method.name != plan.compared_with)]
    scene = measured[0].cell.scene
    return ScenePictures(scene, budget.label, seed, reference.image, [shown[name] for name in names if name in shown])

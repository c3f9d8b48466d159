"""Run a study: check it, then scene by scene render what is missing, make a reference, score, and write everything."""

from __future__ import annotations

import datetime
import os
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from tracer.core import backend
from tracer.image import metrics
from tracer.image.metrics import Scores
from tracer.progress import StepCallback
from tracer.study import cells, oracle, render_cells
from tracer.study.cells import Cell, Took
from tracer.study.check import check_study, count_scenes, one_at_a_time, prepare_output
from tracer.study.methods import Shot
from tracer.study.page.build import require_template_engine, write_page
from tracer.study.page.scene import ScenePictures, Shown
from tracer.study.plan import Plan, Scene
from tracer.study.records import CLOSE, Failure, Measurement, SceneFacts
from tracer.study.reference import Reference, make_reference
from tracer.study.results import Results
from tracer.study.score_cache import ScoreBook
from tracer.study.write import PAGE, write_results

OBJECTIVE = "relative"
"""Which error the limit of a scene is of; gains are of each method's own."""
PAGE_SECONDS = 60.0
"""Least time between two pages: they take a second or two a scene."""
LEAST_LEFT = 0.1
"""Part of a measured squared error that is never taken for the reference's."""
MARGIN = 1.2
"""Samples of a reference beyond those that its error so far asks for."""


def run_study(
    plan: Plan, output: Path, progress: StepCallback | None = None, overwrite: bool = False, cluster: Any = None
) -> Results:
    """Measure everything and return it; ``output`` is written anew as scenes are done.

    What is there from an earlier run of the same study is not rendered again, unless ``overwrite``. Raises
    SettingsError or MissingPackageError before the first ray, and KeyboardInterrupt if ``progress`` stops it: all
    finished cells are kept. ``cluster``: let workers render the cells, see ``tracer.render``; references are rendered
    here.
    """
    require_template_engine()
    backend.activate()
    scenes = plan.find_scenes()
    check_study(plan, scenes)
    with one_at_a_time(output):
        prepare_output(plan, output, overwrite)
        if cluster is None:
            return Study(plan, scenes, output, progress).run()
        from tracer.cluster.connection import open_connection
        from tracer.study import render_cells_remote

        with open_connection(cluster) as connection:
            return Study(
                plan, scenes, output, progress, partial(render_cells_remote.shoot, connection=connection)
            ).run()


class Study:
    """One study under way."""

    def __init__(
        self,
        plan: Plan,
        scenes: Sequence[Scene],
        output: Path,
        progress: StepCallback | None,
        shoot_scene: Callable[..., list[Failure]] = render_cells.shoot,
    ) -> None:
        self.shoot_scene = shoot_scene
        self.plan, self.scenes, self.output, self.progress = plan, scenes, output, progress
        self.run_id = f"{datetime.datetime.now(datetime.UTC):%Y-%m-%dT%H:%M:%S}-{os.getpid()}"
        self.results = Results(plan)
        self.pictures: list[ScenePictures] = []
        self.blocks = {scene.name: cells.cells_of(plan, scene) for scene in scenes}
        self.book = ScoreBook(output / cells.FOLDER / "scores.json")
        self.missing = 0
        self.done = 0
        self.text = ""
        self.page_written = time.monotonic()
        self.scenes_before = max(1, count_scenes(output))

    def run(self) -> Results:
        """Do scene after scene."""
        every = [cell for blocks in self.blocks.values() for block in blocks for cell in block]
        self.missing = sum(not cells.is_kept(cell, self.output) for cell in every)
        self.results.kept = len(every) - self.missing
        try:
            for scene in self.scenes:
                blocks = self.blocks[scene.name]
                failures = self.shoot_scene(self.plan, scene, blocks, self.output, self.run_id, self.shot)
                self.results.failures += failures
                try:
                    self.measure(scene, [cell for block in blocks for cell in block])
                except Exception as error:  # the other scenes can still be measured
                    self.results.failures.append(
                        Failure(scene.name, "reference", "all", 0, render_cells.one_line(error))
                    )
                self.results.finished = scene is self.scenes[-1]
                self.write(time.monotonic() - self.page_written > PAGE_SECONDS)
        finally:
            self.write(page=True)
        return self.results

    def write(self, page: bool) -> None:
        """Write what there is; results of more scenes, from an earlier run, stay until there are as many again."""
        if not (self.results.finished or len(self.results.scenes) >= self.scenes_before):
            return
        write_results(self.output, self.results)
        if page:
            write_page(self.output / PAGE, self.results, self.pictures)
            self.page_written = time.monotonic()

    def tell(self, text: str, done: int, total: int) -> None:
        """Tell the caller of progress. Raises KeyboardInterrupt if it wants to stop."""
        if self.progress is not None and self.progress(text, done, total) is False:
            raise KeyboardInterrupt

    def shot(self, cell: Cell | None, text: str) -> None:
        """Tell of a cell that is done, or under way."""
        self.done += cell is not None
        self.text = text or self.text
        self.tell(f"{self.text} ({self.done} of {self.missing})", self.done, self.missing)

    def measure(self, scene: Scene, wanted: Sequence[Cell]) -> None:
        """Score what was rendered of a scene against a reference that is good enough for it."""
        there = [one for cell in wanted if (one := self.read(cell)) is not None]
        found = [one for one in there if self.is_finite(*one[:2])]
        if not found:
            return
        reference = self.good_reference(scene, [shot.image for _, shot, _ in found])
        facts = describe_scene(scene.name, reference)
        measured = []
        for k, (cell, shot, took) in enumerate(found):
            self.tell(f"{scene.name}: scores", k, len(found))
            scores = self.book.scores(cell, shot.image, reference)
            close = CLOSE**2 * scores.relative_mse < facts.reference_relative_mse
            measured.append(Measurement(cell, took, without_error_of(reference, scores), close))
        self.book.save()
        self.results.scenes.append(facts)
        self.results.measurements += measured
        self.pictures.append(choose_pictures(self.plan, reference, measured, [shot for _, shot, _ in found]))

    def read(self, cell: Cell) -> tuple[Cell, Shot, Took] | None:
        """Return the picture of a cell, None if there is none; one that is damaged is removed, to be made again."""
        if not cells.is_kept(cell, self.output):
            return None
        try:
            return cell, *cells.load(cell, self.output)
        except Exception as error:  # whatever damage does to a file; it is among the failures that are told
            cell.path(self.output).unlink()
            self.results.failures.append(render_cells.failure(cell, error))
            return None

    def is_finite(self, cell: Cell, shot: Shot) -> bool:
        """Return whether a picture can be scored; if not, that is a failure."""
        bad = np.count_nonzero(~np.isfinite(shot.image).all(axis=-1))
        if bad:
            message = f"{bad} pixels of the picture are not finite"
            self.results.failures.append(Failure(cell.scene, cell.method, cell.budget.label, cell.seed, message))
        return not bad

    def good_reference(self, scene: Scene, images: Sequence[Any]) -> Reference:
        """Return a reference whose error is at most a tenth of the smallest error, or as good as the plan allows."""
        spp = min(self.plan.reference_spp, 4 * int(max([64, *self.plan.spp])))
        while True:
            reference = self.reference(scene, spp)
            smallest = min(metrics.relative_mse(image, reference.image) for image in images)
            ratio = reference.relative_mse / max(CLOSE**2 * smallest, 1e-30)
            if ratio <= 1 or reference.spp >= self.plan.reference_spp:
                return reference
            spp = min(self.plan.reference_spp, round(reference.spp * ratio * MARGIN))

    def reference(self, scene: Scene, spp: int) -> Reference:
        """Return the reference of a scene, telling of progress."""

        def passed(done: int, total: int) -> None:
            self.tell(f"{scene.name}: reference, {done} of {total} spp", done, total)

        return make_reference(scene.setting, spp, passed)


def without_error_of(reference: Reference, scores: Scores) -> Scores:
    """Return scores whose squared errors are those against the truth: less that of the reference, which is independent.

    Where next to nothing would be left, LEAST_LEFT of it stays.
    """

    def left(measured: float, own: float) -> float:
        return max(measured - own, LEAST_LEFT * measured)

    return replace(
        scores,
        mse=left(scores.mse, reference.mse),
        relative_mse=left(scores.relative_mse, reference.relative_mse),
    )


def describe_scene(name: str, reference: Reference) -> SceneFacts:
    """Return what a reference says of a scene and of itself."""
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
    plan: Plan, reference: Reference, measured: Sequence[Measurement], shots: Sequence[Shot]
) -> ScenePictures:
    """Return what the page shows of a scene: the first seed at the largest budget, in samples if there is one."""
    budget = max({one.cell.budget for one in measured}, key=lambda one: (one.kind == "spp", one.amount))
    seed = min(one.cell.seed for one in measured if one.cell.budget == budget)
    shown = {
        one.cell.method: Shown(one.cell.method, shot.image, shot.counts, one.scores.relative_mse)
        for one, shot in zip(measured, shots, strict=True)
        if one.cell.budget == budget and one.cell.seed == seed
    }
    names = [plan.compared_with, *(method.name for method in plan.methods if method.name != plan.compared_with)]
    name = measured[0].cell.scene
    return ScenePictures(name, budget.label, seed, reference.image, [shown[one] for one in names if one in shown])

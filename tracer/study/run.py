"""Run a study: check it, then scene by scene render what is missing, make a reference, score, and write everything."""

from __future__ import annotations

import datetime
import json
import os
import shutil
import time
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import mitsuba as mi
import numpy as np

from tracer import backend, files, score
from tracer.errors import OutputError, TracerError
from tracer.load_error import load_error
from tracer.source import LOAD_ERRORS, load
from tracer.study import cells, oracle, shoot
from tracer.study.cells import Cell, Took
from tracer.study.methods import Shot
from tracer.study.page.build import write_page
from tracer.study.page.scene import ScenePictures, Shown
from tracer.study.plan import Plan, Scene
from tracer.study.reference import Reference, make_reference
from tracer.study.results import CLOSE, Failure, Measurement, Results, SceneFacts
from tracer.study.scores import ScoreBook
from tracer.study.write import PAGE, RESULT_FILES, write_results

StepCallback = Callable[[str, int, int], bool | None]
"""Called with what is under way and how much of how much is done; return False to stop."""

OBJECTIVE = "relative"
"""Which error gains and limits are of."""
PAGE_SECONDS = 60.0
"""Least time between two pages: they take a second or two a scene."""
MARGIN = 1.2
"""Samples of a reference beyond those that its error so far asks for."""


def run_study(plan: Plan, output: Path, progress: StepCallback | None = None, overwrite: bool = False) -> Results:
    """Measure everything and return it; ``output`` is written anew as scenes are done.

    What is there from an earlier run of the same study is not rendered again, unless ``overwrite``. Raises
    SettingsError before the first ray, and KeyboardInterrupt if ``progress`` stops it: all finished cells are kept.
    """
    backend.activate()
    scenes = plan.find_scenes()
    check_study(plan, scenes)
    prepare_output(plan, output, overwrite)
    return Study(plan, scenes, output, progress).run()


def check_study(plan: Plan, scenes: Sequence[Scene]) -> None:
    """Raise an error, with its line, for a sampler or scene that cannot be used."""
    stock = [(k, method) for k, method in enumerate(plan.methods) if method.sampler is not None]
    for k, method in stock:
        try:
            mi.load_dict({"type": method.sampler})
        except LOAD_ERRORS as error:
            said = str(load_error(f"sampler '{method.sampler}'", error))
            raise plan.origin.fault(said, ("methods", k, "sampler"), method.sampler) from None
    for scene in scenes:
        try:
            with ExitStack() as stack:
                if stock:
                    load(scene.setting.source, sampler=stock[0][1].sampler)
                height, width = scene.setting.open(stack).size
        except TracerError as error:
            raise plan.origin.fault(str(error), culprit(plan, scene, error)) from None
        if min(height, width) < score.SSIM_WINDOW:
            message = (
                f"'{scene.name}' is {width} x {height} pixels; structural similarity needs at least "
                f"{score.SSIM_WINDOW} a side, use a larger size"
            )
            raise plan.origin.fault(message, (*scene.location, "size"))


def culprit(plan: Plan, scene: Scene, error: TracerError) -> tuple[str | int, ...]:
    """Return the place in the plan that an error of a scene comes from."""
    entry = plan.scenes[int(scene.location[1])]
    for name in ("integrator", "sensor", "size"):
        if name in entry.model_fields_set and name in str(error).lower():
            return *scene.location, name
    return *scene.location, "path" if entry.path else "bundled"


def prepare_output(plan: Plan, output: Path, overwrite: bool) -> None:
    """Make the folder ready. Raises an error if it cannot be written, or holds the results of another study."""
    if not output.exists():
        files.check_folder(output.parent)
        output.mkdir()
    files.check_folder(output)
    if overwrite:
        shutil.rmtree(output / cells.FOLDER, ignore_errors=True)
        for name in RESULT_FILES:
            (output / name).unlink(missing_ok=True)
    marks = [path for path in (output / RESULT_FILES[0], output / cells.FOLDER / "study.json") if path.exists()]
    for path in marks:
        try:
            there = json.loads(path.read_text())["study"]["name"]
        except (ValueError, KeyError, TypeError, UnicodeDecodeError):
            raise OutputError(f"'{path}' is not from a study; choose another folder.") from None
        if there != plan.name:
            message = (
                f"'{output}' holds the study '{there}', not '{plan.name}'; choose another folder, "
                "or --overwrite to replace what is there"
            )
            raise plan.origin.fault(message, ("name",))
    (output / cells.FOLDER).mkdir(exist_ok=True)
    files.write_text(output / cells.FOLDER / "study.json", json.dumps({"study": {"name": plan.name}}))


class Study:
    """One study under way."""

    def __init__(self, plan: Plan, scenes: Sequence[Scene], output: Path, progress: StepCallback | None) -> None:
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
        self.on_page = 0

    def run(self) -> Results:
        """Do scene after scene."""
        every = [cell for blocks in self.blocks.values() for block in blocks for cell in block]
        self.missing = sum(not cells.is_kept(cell, self.output) for cell in every)
        self.results.kept = len(every) - self.missing
        try:
            for scene in self.scenes:
                blocks = self.blocks[scene.name]
                failures = shoot.shoot(self.plan, scene, blocks, self.output, self.run_id, self.shot)
                self.results.failures += failures
                self.measure(scene, [cell for block in blocks for cell in block])
                self.results.finished = scene is self.scenes[-1]
                write_results(self.output, self.results)
                if time.monotonic() - self.page_written > PAGE_SECONDS:
                    self.write_page()
        finally:
            self.write_page()
        return self.results

    def write_page(self) -> None:
        """Write the page of all scenes so far."""
        if len(self.pictures) > self.on_page:
            write_page(self.output / PAGE, self.results, self.pictures)
            self.page_written, self.on_page = time.monotonic(), len(self.pictures)

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
        found = [(cell, *cells.load(cell, self.output)) for cell in wanted if cells.is_kept(cell, self.output)]
        finite = [one for one in found if np.isfinite(one[1].image).all()]
        for cell, shot, _ in found:
            bad = np.count_nonzero(~np.isfinite(shot.image).all(axis=-1))
            if bad:
                message = f"{bad} pixels of the picture are not finite"
                self.results.failures.append(Failure(cell.scene, cell.method, cell.budget.label, cell.seed, message))
        if not finite:
            return
        reference = self.good_reference(scene, [shot.image for _, shot, _ in finite])
        height, width = reference.image.shape[:2]
        facts = SceneFacts(
            name=scene.name,
            width=width,
            height=height,
            reference_spp=reference.spp,
            reference_mse=reference.mse,
            reference_relative_mse=reference.relative_mse,
            halves_agree=reference.halves_agree,
            disagreement=reference.disagreement,
            limit=oracle.limit(reference.variance, reference.image, OBJECTIVE),
        )
        self.results.scenes.append(facts)
        for k, (cell, shot, took) in enumerate(finite):
            self.tell(f"{scene.name}: scores", k, len(finite))
            scores = self.book.scores(cell, shot.image, reference)
            close = CLOSE**2 * scores.relative_mse < facts.reference_relative_mse
            self.results.measurements.append(Measurement(cell, took, scores, close))
        self.book.save()
        self.pictures.append(self.choose_pictures(facts.name, reference, finite))

    def choose_pictures(
        self, name: str, reference: Reference, found: Sequence[tuple[Cell, Shot, Took]]
    ) -> ScenePictures:
        """Return what the page shows of a scene: the first seed at the largest budget, in samples if there is one."""
        there = {cell.budget for cell, _, _ in found}
        budget = max(there, key=lambda one: (one.kind == "spp", one.amount))
        seed = min(cell.seed for cell, _, _ in found if cell.budget == budget)
        shots = {cell.method: shot for cell, shot, _ in found if cell.budget == budget and cell.seed == seed}
        names = [method.name for method in self.plan.methods if method.name in shots]
        names.sort(key=lambda method: method != self.plan.compared_with)
        shown = [
            Shown(method, shots[method].image, shots[method].counts, score.relative_mse(shots[method].image, truth))
            for truth in [reference.image]
            for method in names
        ]
        return ScenePictures(name, budget.label, seed, reference.image, shown)

    def good_reference(self, scene: Scene, images: Sequence[Any]) -> Reference:
        """Return a reference whose error is at most a tenth of the smallest error, or as good as the plan allows."""
        spp = min(self.plan.reference_spp, 4 * int(max([64, *self.plan.spp])))
        while True:
            reference = self.reference(scene, spp)
            smallest = min(score.relative_mse(image, reference.image) for image in images)
            ratio = reference.relative_mse / max(CLOSE**2 * smallest, 1e-30)
            if ratio <= 1 or reference.spp >= self.plan.reference_spp:
                return reference
            spp = min(self.plan.reference_spp, round(reference.spp * ratio * MARGIN))

    def reference(self, scene: Scene, spp: int) -> Reference:
        """Return the reference of a scene, telling of progress."""

        def passed(done: int, total: int) -> None:
            self.tell(f"{scene.name}: reference, {done} of {total} spp", done, total)

        return make_reference(scene.setting, spp, passed)

"""Checks of a study before its first ray: its samplers, its scenes, and the folder that its results go into."""

from __future__ import annotations

import hashlib
import json
import shutil
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path

import filelock
import mitsuba as mi

from tracer.core.wording import option
from tracer.errors import OutputError, TracerError
from tracer.image import metrics
from tracer.io import atomic
from tracer.scene.load import LOAD_ERRORS
from tracer.scene.load_errors import load_error
from tracer.study import cells
from tracer.study.methods import Studio
from tracer.study.plan import Plan, Scene
from tracer.study.reference import prepare_cache
from tracer.study.write import RESULT_FILES


def check_study(plan: Plan, scenes: Sequence[Scene]) -> None:
    """Raise SettingsError, with the line in the plan, for a sampler or scene that cannot be used."""
    stock = [(k, method) for k, method in enumerate(plan.methods) if method.sampler is not None]
    for k, method in stock:
        try:
            if not isinstance(mi.load_dict({"type": method.sampler}), mi.Sampler):
                raise plan.origin.fault(f"'{method.sampler}' is not a sampler", ("methods", k, "sampler"))
        except LOAD_ERRORS as error:
            explanation = str(load_error(f"sampler '{method.sampler}'", error, "sampler"))
            raise plan.origin.fault(explanation, ("methods", k, "sampler"), method.sampler) from None
    for scene in scenes:
        try:
            with ExitStack() as stack:
                samplers = [method.sampler for _, method in stock[:1] if method.sampler is not None]
                height, width = Studio(stack, scene.setting, samplers).view.size
        except TracerError as error:
            raise plan.origin.fault(str(error), culprit(plan, scene, error)) from None
        if min(height, width) < metrics.SSIM_WINDOW:
            message = (
                f"'{scene.name}' is {width} x {height} pixels; structural similarity needs at least "
                f"{metrics.SSIM_WINDOW} a side, use a larger size"
            )
            raise plan.origin.fault(message, (*scene.location, "size"))


def culprit(plan: Plan, scene: Scene, error: TracerError) -> tuple[str | int, ...]:
    """Return where the setting stands in the plan that most likely causes an error of a scene."""
    entry = plan.scenes[int(scene.location[1])]
    for name in ("integrator", "sensor", "size"):
        if name in entry.model_fields_set and name in str(error).lower():
            return *scene.location, name
    return *scene.location, "path" if entry.path else "bundled"


def prepare_output(plan: Plan, output: Path, overwrite: bool) -> None:
    """Make the folder ready for the study. Raises an error if it holds another study, or files that no study wrote.

    ``overwrite`` removes another study. Pictures of the same study stay until those that replace them are there.
    """
    mark = output / cells.FOLDER / "study.json"
    require_own_folder(output, mark)
    try:
        require_same_study(plan, output, mark)
    except TracerError:
        if not overwrite:
            raise
        remove_study(output, mark)
    if not mark.exists():
        mark.parent.mkdir(exist_ok=True)
        atomic.write_text(mark, json.dumps({"study": {"name": plan.name}}))


def require_same_study(plan: Plan, output: Path, mark: Path) -> None:
    """Raise an error if the results in a folder, or ``mark``, are of another study or damaged."""
    for study_name in filter(None, [study_in(output / RESULT_FILES[0]), study_in(mark)]):
        if study_name != plan.name:
            message = (
                f"'{output}' holds the study '{study_name}', not '{plan.name}'; choose another folder, "
                f"or {option('overwrite')} to replace what is there"
            )
            raise plan.origin.fault(message, ("name",))


def remove_study(output: Path, mark: Path) -> None:
    """Remove the results in a folder, and its pictures if there is ``mark``."""
    if mark.exists():
        shutil.rmtree(mark.parent)
    for name in RESULT_FILES:
        (output / name).unlink(missing_ok=True)


def require_own_folder(output: Path, mark: Path) -> None:
    """Raise OutputError if a folder has files, other than hidden ones, and neither ``mark`` nor results of a study."""
    names = sorted(path.name for path in output.iterdir() if not path.name.startswith("."))
    if names and not mark.exists() and study_in(output / RESULT_FILES[0]) is None:
        raise OutputError(
            f"'{output}' has files that are not from a study, such as '{names[0]}'; choose a new or an empty folder."
        )


@contextmanager
def one_at_a_time(output: Path) -> Iterator[None]:
    """Create the folder if it is missing, and keep other processes out while the block runs. Raises OutputError."""
    if output.is_file():
        raise OutputError(f"'{output}' is a file; choose a folder.")
    if not output.exists():
        atomic.check_folder(output.parent)
        output.mkdir()
    atomic.check_folder(output)
    digest = hashlib.sha256(str(output.resolve()).encode()).hexdigest()[:24]
    try:
        with filelock.FileLock(prepare_cache() / f"{digest}.lock", timeout=0):
            yield
    except filelock.Timeout:
        raise OutputError(f"Another study is at work in '{output}'; wait for it, or choose another folder.") from None


def study_in(path: Path) -> str | None:
    """Return the name of the study that wrote a file of results; None if there is no file. Raises OutputError."""
    try:
        return str(json.loads(path.read_text())["study"]["name"])
    except FileNotFoundError:
        return None
    except (OSError, ValueError, KeyError, TypeError):
        raise OutputError(f"'{path}' is not from a study; choose another folder.") from None


def count_scenes(output: Path) -> int:
    """Return the number of scenes in the results that a folder holds; 0 if it holds none."""
    try:
        return len(json.loads((output / RESULT_FILES[0]).read_text())["scenes"])
    except (OSError, ValueError, KeyError, TypeError):  # missing or damaged: there is nothing to keep
        return 0

"""``python -m benchmarks NAME -o FOLDER``, from a checkout: measure tracer, and write the results."""

from __future__ import annotations

import importlib
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from tracer.cli import in_one_sentence, options
from tracer.cli.app import after_check
from tracer.cli.guard import guarded
from tracer.errors import SceneError, SettingsError

ABOUT = {
    "bias": "How far the mean of adaptive pictures is off. 15 minutes.",
    "cluster": "Workers against one process, a model of more. 10 minutes.",
    "decisions": "Pictures of how it decides, and what that gains. 5 minutes.",
    "guiding": "What the best choice of lights would gain. 15 minutes.",
    "paper": "The paper's rules for rays of patches. 30 minutes.",
    "production": "Noise targets, limits of time, checkpoints. 30 minutes.",
    "radiosity": "Guided rays against even ones and paths. 40 minutes.",
    "time": "Seconds of every part, beside plain mi.render. 60 minutes.",
    "viewpoint": "Measures of views, searches, large files. 20 minutes.",
}
"""For each benchmark, by its name, what it measures and how long it takes on two cores."""
Output = Annotated[Path, typer.Option("--output", "-o", help="Folder to write to.", show_default=False)]
Public = Annotated[Path, typer.Argument(help="Folder with the folders meshes and molecules.", show_default=False)]
Scenes = Annotated[Path, typer.Argument(help="Folder with folders that have a scene.xml.", show_default=False)]
Resume = Annotated[bool, typer.Option("--resume", help="Keep what was measured before it was stopped.")]


class Reports(TyperGroup):
    """A group of commands in which the name of an unknown command is reported in one sentence."""

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """Return the command of a name. Raises SettingsError for an unknown name."""
        if cmd_name not in self.commands:
            raise SettingsError(f"There is no benchmark '{cmd_name}'; there are: {', '.join(self.commands)}.")
        return super().get_command(ctx, cmd_name)


app = typer.Typer(
    cls=Reports,
    help="Measure tracer, and write tables, figures and numbers to a folder. The minutes are those of two cores.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    add_completion=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)


def perform(name: str, output: Path, overwrite: bool, quiet: bool, *arguments: Any, variant: str | None = None) -> None:
    """Run a benchmark with a progress bar, and write its report.

    ``arguments`` are those of its function ``report`` after the folder and the progress callback. Raises TracerError.
    """
    from tracer.cli.progress import steps
    from tracer.core import backend
    from tracer.io.atomic import prepare_folder

    backend.activate(variant)
    report = importlib.import_module(f"benchmarks.{name}.report")
    prepare_folder(output, overwrite, report.FILES)
    with steps(quiet) as progress:
        report.report(output, progress, *arguments)
    if not quiet:
        typer.echo(f"{output / 'results.md'} has everything.")


def command(name: str) -> Callable[..., None]:
    """Return the command of a benchmark that needs nothing but a folder to write to."""

    def benchmark(output: Output, overwrite: options.Overwrite = False, quiet: options.Quiet = False) -> None:
        perform(name, output, overwrite, quiet)

    return benchmark


def viewpoint(
    public: Public,
    output: Output,
    overwrite: options.Overwrite = False,
    resume: Resume = False,
    quiet: options.Quiet = False,
) -> None:
    """Measure views of the meshes and molecules in a folder."""
    for folder in ("meshes", "molecules"):
        if not (public / folder).is_dir():
            raise SceneError(f"There is no folder '{public / folder}'; name the folder that has it.")
    check_resume(output, resume)
    perform("viewpoint", output, overwrite or resume, quiet, public, resume)


def guiding(
    scenes: Scenes,
    output: Output,
    overwrite: options.Overwrite = False,
    resume: Resume = False,
    quiet: options.Quiet = False,
) -> None:
    """Find out where the noise of the bundled scenes and of those in a folder comes from."""
    check_scenes(scenes)
    check_resume(output, resume)
    perform("guiding", output, overwrite or resume, quiet, scenes, resume)


def time(
    scenes: Scenes,
    output: Output,
    overwrite: options.Overwrite = False,
    resume: Resume = False,
    variant: Annotated[str | None, typer.Option(help="Mitsuba variant. (llvm_ad_rgb)")] = None,
    quiet: options.Quiet = False,
) -> None:
    """Time pictures of the bundled scenes and of those in a folder."""
    check_scenes(scenes)
    check_resume(output, resume)
    perform("time", output, overwrite or resume, quiet, scenes, resume, variant=variant)


def paper(
    output: Output, overwrite: options.Overwrite = False, resume: Resume = False, quiet: options.Quiet = False
) -> None:
    """Measure the paper's rules for rays of patches."""
    check_resume(output, resume)
    perform("paper", output, overwrite or resume, quiet, resume)


def radiosity(
    output: Output, overwrite: options.Overwrite = False, resume: Resume = False, quiet: options.Quiet = False
) -> None:
    """Measure radiosity."""
    check_resume(output, resume)
    perform("radiosity", output, overwrite or resume, quiet, resume)


def check_resume(output: Path, resume: bool) -> None:
    """Raise SettingsError if there is nothing to go on with."""
    if resume and not (output / "results.json").exists():
        raise SettingsError(f"There is no '{output / 'results.json'}' to go on with.")


def check_scenes(folder: Path) -> None:
    """Raise SceneError if a folder has no folder of a scene."""
    if not any(folder.glob("*/scene.xml")):
        raise SceneError(f"There is no scene '{folder}/NAME/scene.xml'; name the folder with the folders of scenes.")


OF_THEIR_OWN: dict[str, Callable[..., None]] = {
    "guiding": guiding,
    "paper": paper,
    "radiosity": radiosity,
    "time": time,
    "viewpoint": viewpoint,
}
"""Commands that are given a folder to read, or can go on."""

for name, about in ABOUT.items():
    app.command(name, help=about)(after_check(OF_THEIR_OWN.get(name) or command(name)))


if __name__ == "__main__":
    guarded(lambda: in_one_sentence(app))

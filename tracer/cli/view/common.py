"""The options that all commands ``view ...`` share, and the context in which their reports are made."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from tracer.cli import options

if TYPE_CHECKING:
    from tracer.viewpoint.reports.context import ViewContext

Three = tuple[float, float, float]
Measure = Annotated[
    str, typer.Option("--measure", "-m", help="Measure by which views are compared; see tracer view measure.")
]
Level = Annotated[int, typer.Option(help="Number of viewpoints: 10 * 4^level + 2.", min=0, max=5)]


@dataclass(frozen=True)
class ViewOptions:
    """The options of all commands: what is looked at, from where and how, and where the results go."""

    source: Annotated[
        Path,
        typer.Argument(
            help="Scene (XML), mesh (PLY, OBJ, STL, OFF, glTF, 3MF) or molecule (XYZ, CIF, mmCIF, PDB, CML).",
            show_default=False,
        ),
    ]
    output: Annotated[Path, typer.Option("--output", "-o", help="Folder for pictures, cameras, tables.")]
    surfaces: Annotated[
        str | None,
        typer.Option(help="What counts as a surface: face, shape or bsdf. Of a molecule: its atoms. (face)"),
    ] = None
    side: Annotated[int, typer.Option(help="Rays along each side of a view.", min=8, max=4096)] = 256
    random: Annotated[
        int | None,
        typer.Option(
            help="The fast way: this many random rays a view instead; entropy has a standard error.", min=10, max=10**8
        ),
    ] = None
    background: Annotated[bool, typer.Option(help="Whether the background counts as a surface in entropy.")] = True
    distance: Annotated[float | None, typer.Option(help="Distance from the centre. (6 radii)")] = None
    centre: Annotated[Three | None, typer.Option(help="What to look at. (the middle of everything)")] = None
    up: Annotated[Three | None, typer.Option(help="Upward direction. (as the scene's camera; y for meshes)")] = None
    orthographic: Annotated[
        bool | None,
        typer.Option(
            "--orthographic/--perspective", help="Parallel rays, or rays from a point. (parallel for molecules)"
        ),
    ] = None
    repeat: Annotated[
        tuple[int, int, int] | None, typer.Option(help="Repeat the cell of a crystal this many times.")
    ] = None
    cut: Annotated[float | None, typer.Option(help="Cut a ball of this radius out of a crystal, in Angstrom.")] = None
    atom_radius: Annotated[float | None, typer.Option(help="Radius of atoms in Angstrom. (by element)")] = None
    spp: Annotated[
        int,
        typer.Option(
            help="Render the pictures, with this many samples per pixel. (0: lit from the eye)", min=0, max=65536
        ),
    ] = 0
    overwrite: options.Overwrite = False
    quiet: options.Quiet = False


def with_view_options(*left_out: str) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Give a command every field of ``ViewOptions`` as an option, except the fields named in ``left_out``.

    The command receives a ``ViewOptions`` as its first argument, in which the fields left out have their defaults.
    """

    def decorate(command: Callable[..., None]) -> Callable[..., None]:
        own_parameters = list(inspect.signature(command, eval_str=True).parameters.values())[1:]
        fields = inspect.signature(ViewOptions, eval_str=True).parameters.values()
        shared = [field for field in fields if field.name not in left_out]

        @functools.wraps(command)
        def run(**values: Any) -> None:
            command(ViewOptions(**{field.name: values.pop(field.name) for field in shared}), **values)

        parameters = [
            parameter.replace(kind=inspect.Parameter.KEYWORD_ONLY)
            for parameter in (*shared[:2], *own_parameters, *shared[2:])
        ]
        run.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
        run.__annotations__ = {parameter.name: parameter.annotation for parameter in parameters}
        return run

    return decorate


@contextmanager
def view_context(view: ViewOptions, results: tuple[str, ...]) -> Iterator[ViewContext]:
    """Check the options, open the source, and yield the context of a report, while a progress bar is shown.

    ``results``: names of the files that will be written. Raises SettingsError, SceneError or OutputError.
    """
    import numpy as np

    from tracer.cli.progress import steps
    from tracer.core import backend
    from tracer.errors import SettingsError
    from tracer.io.atomic import prepare_folder

    if view.distance is not None and not 0 < view.distance < float("inf"):
        raise SettingsError(f"The distance must be positive, not {view.distance:g}.")
    if not np.all(np.isfinite([*(view.centre or ()), *(view.up or ())])):
        raise SettingsError("A place or direction must be three finite numbers.")
    if view.up is not None and not 1e-100 < max(map(abs, view.up)) < 1e100:
        raise SettingsError("The upward vector must have a direction and a sensible length; give 0 0 1, for example.")
    backend.activate()
    from tracer.viewpoint.direction_measure import stand
    from tracer.viewpoint.item_buffer import Rays
    from tracer.viewpoint.rendered import require_light
    from tracer.viewpoint.reports.context import ViewContext
    from tracer.viewpoint.source import Crystal, open_source

    opened = open_source(view.source, view.surfaces, Crystal(view.repeat, view.cut, view.atom_radius))
    if view.spp:
        require_light(opened.subject)
    folder_is_new = not view.output.exists()
    prepare_folder(view.output, view.overwrite, results)
    parallel = opened.orthographic if view.orthographic is None else view.orthographic
    centre: Any = None if view.centre is None else np.array(view.centre) - opened.origin
    standpoint = stand(opened.subject, view.distance, centre, view.up or opened.up, parallel)
    try:
        with steps(view.quiet) as progress:
            rays = Rays(random=view.random) if view.random else Rays(side=view.side)
            yield ViewContext(opened, standpoint, rays, view.background, view.output, progress, view.spp)
    finally:
        if folder_is_new and view.output.is_dir() and not any(view.output.iterdir()):
            view.output.rmdir()  # the command failed before it wrote anything

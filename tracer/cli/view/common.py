"""Options that all commands ``view ...`` share, and the context that they set up."""

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
Measure = Annotated[str, typer.Option("--measure", "-m", help="By which a view is good; see tracer view measure.")]
Level = Annotated[int, typer.Option(help="Viewpoints: 10 * 4^level + 2.", min=0, max=5)]


@dataclass(frozen=True)
class ViewOptions:
    """What is looked at, from where and how, and where the results go."""

    source: Annotated[
        Path,
        typer.Argument(
            help="Scene (XML), mesh (PLY, OBJ) or molecule (XYZ, CIF, mmCIF, PDB, CML).", show_default=False
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
            help="The fast way: so many random rays a view instead, with a standard error.", min=10, max=10**8
        ),
    ] = None
    background: Annotated[bool, typer.Option(help="Whether the background counts as a surface in entropy.")] = True
    distance: Annotated[float | None, typer.Option(help="From the centre. [6 radii]")] = None
    centre: Annotated[Three | None, typer.Option(help="What to look at. (the middle of everything)")] = None
    up: Annotated[Three | None, typer.Option(help="What is upwards. [as the scene's camera; y for meshes]")] = None
    orthographic: Annotated[
        bool | None,
        typer.Option("--orthographic/--perspective", help="Parallel rays, or not. (parallel for molecules)"),
    ] = None
    repeat: Annotated[tuple[int, int, int] | None, typer.Option(help="Repeat the cell of a crystal.")] = None
    cut: Annotated[float | None, typer.Option(help="Cut a ball of this radius out of a crystal, in Angstrom.")] = None
    atom_radius: Annotated[float | None, typer.Option(help="Radius of atoms in Angstrom. (by element)")] = None
    spp: Annotated[
        int,
        typer.Option(help="Render the pictures, with so many samples per pixel. (lit from the eye)", min=0, max=65536),
    ] = 0
    overwrite: options.Overwrite = False
    quiet: options.Quiet = False


def with_view_options(*left_out: str) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Give a command the fields of ``ViewOptions`` as options, but for those ``left_out``.

    The command takes them together as its first argument; they keep their defaults where they are left out.
    """

    def decorate(command: Callable[..., None]) -> Callable[..., None]:
        own = list(inspect.signature(command, eval_str=True).parameters.values())[1:]
        fields = inspect.signature(ViewOptions, eval_str=True).parameters.values()
        shared = [field for field in fields if field.name not in left_out]

        @functools.wraps(command)
        def run(**values: Any) -> None:
            command(ViewOptions(**{field.name: values.pop(field.name) for field in shared}), **values)

        parameters = [
            parameter.replace(kind=inspect.Parameter.KEYWORD_ONLY) for parameter in (*shared[:2], *own, *shared[2:])
        ]
        run.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
        run.__annotations__ = {parameter.name: parameter.annotation for parameter in parameters}
        return run

    return decorate


@contextmanager
def view_context(chosen: ViewOptions, results: tuple[str, ...]) -> Iterator[ViewContext]:
    """Check the output, open the source, and yield where everything is laid out, with a progress bar.

    ``results``: names of the files that will be written.
    """
    import numpy as np

    from tracer.cli.progress import steps
    from tracer.core import backend
    from tracer.errors import SettingsError
    from tracer.io.atomic import prepare_folder

    if chosen.distance is not None and not 0 < chosen.distance < float("inf"):
        raise SettingsError(f"The distance must be positive, not {chosen.distance:g}.")
    if not np.all(np.isfinite([*(chosen.centre or ()), *(chosen.up or ())])):
        raise SettingsError("A place or direction is three finite numbers.")
    if chosen.up is not None and not 1e-100 < max(map(abs, chosen.up)) < 1e100:
        raise SettingsError("What is upwards must have a direction and a sensible length; give 0 0 1, for example.")
    backend.activate()
    from tracer.viewpoint.direction_measure import stand
    from tracer.viewpoint.item_buffer import Rays
    from tracer.viewpoint.rendered import require_light
    from tracer.viewpoint.reports.context import ViewContext
    from tracer.viewpoint.source import Crystal, open_source

    opened = open_source(chosen.source, chosen.surfaces, Crystal(chosen.repeat, chosen.cut, chosen.atom_radius))
    if chosen.spp:
        require_light(opened.subject)
    new = not chosen.output.exists()
    prepare_folder(chosen.output, chosen.overwrite, results)
    parallel = opened.orthographic if chosen.orthographic is None else chosen.orthographic
    middle: Any = None if chosen.centre is None else np.array(chosen.centre)
    place = stand(opened.subject, chosen.distance, middle, chosen.up or opened.up, parallel)
    try:
        with steps(chosen.quiet) as told:
            rays = Rays(random=chosen.random) if chosen.random else Rays(side=chosen.side)
            yield ViewContext(opened, place, rays, chosen.background, chosen.output, told, chosen.spp)
    finally:
        if new and chosen.output.is_dir() and not any(chosen.output.iterdir()):
            chosen.output.rmdir()  # nothing came of it

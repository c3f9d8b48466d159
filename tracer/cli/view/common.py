"""The options that all commands ``view ...`` share, and the context in which their reports are made."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, cast, get_args

import typer

from tracer.cli import options
from tracer.cli.options import Panel, advanced, basic

if TYPE_CHECKING:
    from tracer.viewpoint.atom_source import Shown
    from tracer.viewpoint.direction_measure import Stand
    from tracer.viewpoint.opened import Opened
    from tracer.viewpoint.reports.context import ViewContext
    from tracer.viewpoint.room import Room
    from tracer.viewpoint.source import Counted

Three = tuple[float, float, float]
MEASURES = options.names_in("viewpoint/measures", "measure")
"""Names of all measures, for help."""
Measure = Annotated[
    str, basic("What is compared, a name below. (entropy)", name="--measure", short="-m", metavar="NAME")
]


def level(default: int) -> Any:
    """Return the option for the number of viewpoints."""
    return advanced(f"Viewpoints: 10 * 4^level + 2. ({default})", Panel.STAND, metavar="N", min=0, max=5)


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
    output: Annotated[
        Path, basic("Folder for pictures, cameras, tables.", name="--output", short="-o", metavar="FOLDER")
    ]
    surfaces: Annotated[
        str | None, basic("face, shape, bsdf, or an attribute. (face)", Panel.SURFACES, metavar="NAME")
    ] = None
    group: Annotated[
        list[str] | None,
        advanced("Shapes that are one surface, such as 'chair*'; may be repeated.", Panel.SURFACES, metavar="NAMES"),
    ] = None
    weight: Annotated[
        list[str] | None,
        basic("How much they count: lamp*=5; may be repeated.", Panel.SURFACES, metavar="NAME=X"),
    ] = None
    by_light: Annotated[
        bool, basic("As well as the scene's own light shows them.", Panel.SURFACES, name="--by-light")
    ] = False
    side: Annotated[
        int, advanced("Rays along each side of a view. (256)", Panel.STAND, metavar="N", min=8, max=4096)
    ] = 256
    random: Annotated[
        int | None,
        advanced(
            "The fast way: so many random rays a view; entropy then has a standard error.",
            Panel.STAND,
            metavar="N",
            min=10,
            max=10**8,
        ),
    ] = None
    background: Annotated[
        bool,
        advanced(
            "Whether the background is one, in entropy. (it is)", Panel.SURFACES, name="--background/--no-background"
        ),
    ] = True
    distance: Annotated[float | None, advanced("Distance from the centre. (6 radii)", Panel.STAND, metavar="X")] = None
    centre: Annotated[
        Three | None, advanced("What to look at. (the middle of everything)", Panel.STAND, metavar="X Y Z")
    ] = None
    up: Annotated[
        Three | None,
        advanced("Upward direction. (as the scene's camera; y for meshes)", Panel.STAND, metavar="X Y Z"),
    ] = None
    orthographic: Annotated[
        bool | None,
        advanced(
            "Parallel rays, or rays from a point. (parallel for molecules)",
            Panel.STAND,
            name="--orthographic/--perspective",
        ),
    ] = None
    repeat: Annotated[
        tuple[int, int, int] | None,
        advanced("Repeat the cell of a crystal so many times.", Panel.ATOMS, metavar="A B C"),
    ] = None
    cut: Annotated[
        float | None, advanced("Radius of a ball to cut out of a crystal, in Angstrom.", Panel.ATOMS, metavar="X")
    ] = None
    style: Annotated[
        str | None, basic("ball-and-stick or space-filling. (ball-and-stick)", Panel.ATOMS, metavar="NAME")
    ] = None
    atom_radius: Annotated[
        float | None, advanced("Radius of atoms in Angstrom. (by element and style)", Panel.ATOMS, metavar="X")
    ] = None
    count_bonds: Annotated[
        bool,
        advanced(
            "Bonds are surfaces, as atoms are. (they hide what is behind them, and count as background)",
            Panel.ATOMS,
            name="--count-bonds",
        ),
    ] = False
    model: Annotated[
        str | None, advanced("Number of a model in a PDB or mmCIF file. (the first)", Panel.ATOMS, metavar="N")
    ] = None
    assembly: Annotated[
        str | None,
        advanced("Biological assembly in a PDB or mmCIF file. (atoms as in the file)", Panel.ATOMS, metavar="NAME"),
    ] = None
    inside: Annotated[
        bool | None,
        basic("As in a room, or from all around.", Panel.STAND, name="--inside/--outside"),
    ] = None
    spp: Annotated[
        int, advanced("Render the pictures, with so many samples. (0: lit from the eye)", metavar="N", min=0, max=65536)
    ] = 0
    overwrite: options.Overwrite = False
    quiet: options.Quiet = False
    help_all: options.HelpAll = False


def with_view_options(*left_out: str) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Give a command every field of ``ViewOptions`` as an option, except the fields named in ``left_out``.

    The command receives a ``ViewOptions`` as its first argument, in which the fields left out have their defaults.
    """

    def decorate(command: Callable[..., None]) -> Callable[..., None]:
        own_parameters = list(inspect.signature(command, eval_str=True).parameters.values())[1:]
        all_options = inspect.signature(ViewOptions, eval_str=True).parameters.values()
        shared = [field for field in all_options if field.name not in left_out]

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


def counted_of(view: ViewOptions) -> Counted:
    """Return what counts as a surface, and how much. Raises SettingsError."""
    from tracer.viewpoint.source import Counted
    from tracer.viewpoint.weights import weights_from_text

    return Counted(view.surfaces, tuple(view.group or ()), weights_from_text(view.weight or ()), view.by_light)


def shown_of(view: ViewOptions) -> Shown:
    """Return which atoms are looked at, and how they are shown. Raises SettingsError."""
    from tracer.errors import SettingsError
    from tracer.viewpoint.atom_source import Shown
    from tracer.viewpoint.biomolecules import Part
    from tracer.viewpoint.molecules import Style

    if view.style is not None and view.style not in get_args(Style):
        raise SettingsError(f"Unknown style '{view.style}'; choose one of {', '.join(get_args(Style))}.")
    style = cast("Style | None", view.style)
    part = Part(view.model, view.assembly)
    return Shown(view.repeat, view.cut, view.atom_radius, style, view.count_bonds, part)


@contextmanager
def view_context(
    view: ViewOptions,
    results: tuple[str, ...],
    other: Path | None = None,
    may_be_inside: bool = False,
    from_outside: bool = False,
) -> Iterator[ViewContext]:
    """Check the options, open the source, and yield the context of a report, while a progress bar is shown.

    ``results``: names of the files that will be written. ``other``: the molecule from whose surface the source is seen.
    ``may_be_inside``: whether a room is looked at from inside. ``from_outside``: whether a person is told that a room
    is looked at from outside. Raises SettingsError, SceneError or OutputError.
    """
    import numpy as np

    from tracer.cli.progress import steps
    from tracer.core import backend
    from tracer.io.atomic import prepare_folder

    require_sensible(view)
    with steps(view.quiet) as progress:
        progress.begin("Starting Mitsuba")
        backend.activate()
        from tracer.viewpoint.direction_measure import stand
        from tracer.viewpoint.item_buffer import Rays
        from tracer.viewpoint.rendered import require_light
        from tracer.viewpoint.reports.context import ViewContext
        from tracer.viewpoint.source import open_pair_of_files, open_source

        progress.begin(f"Opening {view.source.name}")
        pair = None
        if other is None:
            opened = open_source(view.source, counted_of(view), shown_of(view))
        else:
            require_unset(view, "side", "random", "distance", "centre", "orthographic", "inside")
            opened, pair = open_pair_of_files(view.source, other, counted_of(view), shown_of(view))
        if view.spp:
            require_light(opened.subject)
        parallel = opened.orthographic if view.orthographic is None else view.orthographic
        centre: Any = None if view.centre is None else np.array(view.centre) - opened.origin
        standpoint = stand(opened.subject, view.distance, centre, view.up or opened.up, parallel)
        room = room_of(view, opened, standpoint) if may_be_inside and pair is None else None
        folder_is_new = not view.output.exists()
        prepare_folder(view.output, view.overwrite, results)
        progress.clear()
        if from_outside and not view.quiet:
            tell_of_room(view, opened)
        for remark in () if view.quiet else opened.remarks:
            typer.echo(remark)
        try:
            rays = Rays(random=view.random) if view.random else Rays(side=view.side)
            yield ViewContext(opened, standpoint, rays, view.background, view.output, progress, view.spp, room, pair)
        finally:
            if folder_is_new and view.output.is_dir() and not any(view.output.iterdir()):
                view.output.rmdir()  # the command failed before it wrote anything


def require_unset(view: ViewOptions, *names: str) -> None:
    """Raise SettingsError if an option is set that means nothing for views from the surface of a molecule."""
    from tracer.errors import SettingsError

    defaults = {field.name: field.default for field in fields(view)}
    for name in names:
        if getattr(view, name) != defaults[name]:
            raise SettingsError(f"From the surface of a molecule all directions are seen: leave out --{name}.")


def require_sensible(view: ViewOptions) -> None:
    """Raise SettingsError for places, distances and directions that make no sense."""
    import numpy as np

    from tracer.errors import SettingsError

    if view.distance is not None and not 0 < view.distance < float("inf"):
        raise SettingsError(f"The distance must be positive, not {view.distance:g}.")
    if not np.all(np.isfinite([*(view.centre or ()), *(view.up or ())])):
        raise SettingsError("A place or direction must be three finite numbers.")
    if view.up is not None and not 1e-100 < max(map(abs, view.up)) < 1e100:
        raise SettingsError("The upward vector must have a direction and a sensible length; give 0 0 1, for example.")


def room_of(view: ViewOptions, opened: Opened, standpoint: Stand) -> Room | None:
    """Return the room that is looked at from inside, if any, and tell the person of it.

    Raises SceneError if there is none and inside was asked for, SettingsError for options that contradict it.
    """
    from tracer.errors import SceneError, SettingsError
    from tracer.viewpoint.room import find_room

    outside = stands_outside(view)
    if view.inside is False or (view.inside is None and (outside or opened.orthographic)):
        return None
    if view.inside and outside:
        raise SettingsError("Inside, distance, centre and orthographic rays mean nothing: leave them out.")
    room = find_room(opened.subject, standpoint.up, force=view.inside is True)
    if view.inside and room is None:
        raise SceneError("There is no place inside where a person could stand: no floor, or nothing all around.")
    if room is not None and view.random:
        raise SettingsError("A room is looked at from inside by a grid of rays: leave out --random, or give --outside.")
    if room is not None and not view.quiet:
        typer.echo(
            f"The scene is a room: views are searched inside it, from {len(room.places)} places where a person could "
            "stand; --outside looks at it from outside."
        )
    return room


def stands_outside(view: ViewOptions) -> bool:
    """Return whether the options say where to stand, as is done from outside alone."""
    return view.distance is not None or view.centre is not None or view.orthographic is not None


def tell_of_room(view: ViewOptions, opened: Opened) -> None:
    """Tell the person that a room is looked at from outside, by a command that cannot do else."""
    from tracer.viewpoint.room import has_camera_inside

    if not stands_outside(view) and not opened.orthographic and has_camera_inside(opened.subject):
        typer.echo("The scene is a room, and is looked at from outside here; view best and view tour look from inside.")

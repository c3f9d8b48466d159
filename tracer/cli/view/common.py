"""Options that all commands ``view ...`` share, and the desk that they set up."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from tracer.viewpoint.reports.context import Desk

Three = tuple[float, float, float]
Source = Annotated[
    Path,
    typer.Argument(help="Scene (XML), mesh (PLY, OBJ) or molecule (XYZ, CIF, mmCIF, PDB, CML).", show_default=False),
]
Output = Annotated[Path, typer.Option("--output", "-o", help="Folder for pictures, cameras, tables.")]
Surfaces = Annotated[
    str | None, typer.Option(help="What counts as a surface: face, shape or bsdf. Of a molecule: its atoms. (face)")
]
Side = Annotated[int, typer.Option(help="Rays along each side of a view.", min=8, max=4096)]
Random = Annotated[
    int | None,
    typer.Option(help="The fast way: so many random rays a view instead, with a standard error.", min=10, max=10**8),
]
Background = Annotated[bool, typer.Option(help="Whether the background counts as a surface in entropy.")]
Distance = Annotated[float | None, typer.Option(help="From the centre. [6 radii]")]
Centre = Annotated[Three | None, typer.Option(help="What to look at. (the middle of everything)")]
Up = Annotated[Three | None, typer.Option(help="What is upwards. [as the scene's camera; y for meshes]")]
Orthographic = Annotated[
    bool | None, typer.Option("--orthographic/--perspective", help="Parallel rays, or not. (parallel for molecules)")
]
Repeat = Annotated[tuple[int, int, int] | None, typer.Option(help="Repeat the cell of a crystal.")]
Cut = Annotated[float | None, typer.Option(help="Cut a ball of this radius out of a crystal, in Angstrom.")]
AtomRadius = Annotated[float | None, typer.Option(help="Radius of atoms in Angstrom. (by element)")]
Measure = Annotated[str, typer.Option("--measure", "-m", help="By which a view is good; see tracer view measure.")]
Samples = Annotated[
    int, typer.Option(help="Render the pictures, with so many samples per pixel. (lit from the eye)", min=0, max=65536)
]
Level = Annotated[int, typer.Option(help="Viewpoints: 10 * 4^level + 2.", min=0, max=5)]


@contextmanager
def desk(
    source: Path,
    output: Path,
    results: tuple[str, ...],
    *,
    surfaces: str | None,
    side: int,
    background: bool,
    distance: float | None,
    centre: Three | None,
    up: Three | None,
    orthographic: bool | None,
    repeat: tuple[int, int, int] | None,
    cut: float | None,
    atom_radius: float | None,
    overwrite: bool,
    quiet: bool,
    spp: int = 0,
    random: int | None = None,
) -> Iterator[Desk]:
    """Check the output, open the source, and yield where everything is laid out, with a progress bar."""
    import numpy as np

    from tracer.cli.progress import steps
    from tracer.core import backend
    from tracer.errors import SettingsError
    from tracer.io.atomic import prepare_folder

    if distance is not None and not 0 < distance < float("inf"):
        raise SettingsError(f"The distance must be positive, not {distance:g}.")
    if not np.all(np.isfinite([*(centre or ()), *(up or ())])):
        raise SettingsError("A place or direction is three finite numbers.")
    if up is not None and not 1e-100 < max(map(abs, up)) < 1e100:
        raise SettingsError("What is upwards must have a direction and a sensible length; give 0 0 1, for example.")
    backend.activate()
    from tracer.viewpoint.direction_measure import stand
    from tracer.viewpoint.item_buffer import Rays
    from tracer.viewpoint.rendered import require_light
    from tracer.viewpoint.reports.context import Desk
    from tracer.viewpoint.source import Crystal, open_source

    opened = open_source(source, surfaces, Crystal(repeat, cut, atom_radius))
    if spp:
        require_light(opened.subject)
    new = not output.exists()
    prepare_folder(output, overwrite, results)
    parallel = opened.orthographic if orthographic is None else orthographic
    middle: Any = None if centre is None else np.array(centre)
    place = stand(opened.subject, distance, middle, up or opened.up, parallel)
    try:
        with steps(quiet) as told:
            rays = Rays(random=random) if random else Rays(side=side)
            yield Desk(opened, place, rays, background, output, told, spp)
    finally:
        if new and output.is_dir() and not any(output.iterdir()):
            output.rmdir()  # nothing came of it

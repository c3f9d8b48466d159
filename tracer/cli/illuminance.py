"""Illuminance and patches of a scene that is solved: which files are wanted, what they hold, and a table."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

if TYPE_CHECKING:
    from tracer.radiosity.false_colours import Scale
    from tracer.radiosity.photometry import LitSurface
    from tracer.session.request import Request

MOST_ROWS = 24
"""Largest number of surfaces in a table on the terminal; files have all."""
HEADINGS = ("surface", "material", "area", "mean lx", "least", "greatest", "uniformity")
"""Headings of the table on the terminal."""


@dataclass(frozen=True)
class Wishes:
    """What a person wants to know of the light of a scene, beside its picture."""

    illuminance: list[Path]
    """Files of illuminance."""
    export: list[Path]
    """Files of patches."""
    logarithmic: bool
    """Whether the scale of false colours is logarithmic."""
    ends: str | None
    """Ends of the scale of false colours in lux, such as ``0,500``; None: those that suit the picture."""
    efficacy: float | None
    """Lumens in a unit of the scene's light; None: 683, as it is in watts."""

    @property
    def scale(self) -> Scale:
        """The scale of false colours. Raises SettingsError for ends that it cannot have."""
        from tracer.radiosity.false_colours import scale_of

        return scale_of(self.logarithmic, self.ends)

    def check(self, output: Path | None, overwrite: bool) -> None:
        """Raise SettingsError for wishes that cannot be met, and OutputError for a file that cannot be written.

        ``output``: the picture, if it is wanted.
        """
        from tracer.errors import SettingsError
        from tracer.io import atomic
        from tracer.radiosity import export, illuminance_files
        from tracer.radiosity.photometry import check_efficacy

        files = [path for path in (output, *self.illuminance, *self.export) if path is not None]
        if not files:
            raise SettingsError("There is nothing to write; name a file with -o, --illuminance or --export.")
        if twice := next((path for path in files if files.count(path) > 1), None):
            raise SettingsError(f"'{twice}' cannot hold two things; name another file for one of them.")
        if self.efficacy is not None:
            check_efficacy(self.efficacy)
            if not self.illuminance and not self.export:
                raise SettingsError("--efficacy makes lux of light; add --illuminance or --export, or leave it out.")
        option = "--logarithmic" if self.logarithmic else "--range" if self.ends is not None else ""
        if option and not any(path.suffix.lower() == ".png" for path in self.illuminance):
            raise SettingsError(f"{option} is the scale of false colours; add --illuminance with a .png file.")
        _ = self.scale  # refuses what cannot be
        for path in self.illuminance:
            atomic.check_output(path, overwrite, illuminance_files.SUFFIXES)
        for path in self.export:
            export.check_export(atomic.check_output(path, overwrite, export.SUFFIXES))


def write(wishes: Wishes, integrator: Any, request: Request, quiet: bool) -> bool:
    """Write the files, and print a table of illuminance; return whether all samples of a picture were drawn.

    ``integrator``: ``radiosity``, which has solved the scene. ``request``: that of the picture.
    """
    from tracer.radiosity import export, illuminance_files
    from tracer.radiosity.photometry import EFFICACY, illuminance, lit_surfaces

    efficacy = EFFICACY if wishes.efficacy is None else wishes.efficacy
    patches, solution = integrator.patches, integrator.solution
    lux = illuminance(solution.irradiance, efficacy)
    for path in wishes.export:
        export.write_patches(path, patches, solution.radiosity, solution.irradiance, lux)
    if not wishes.illuminance:
        return True
    surfaces = lit_surfaces(patches, lux)
    if not quiet:
        print_table(surfaces)
    pictures = [path for path in wishes.illuminance if path.suffix.lower() != illuminance_files.TABLE]
    for path in wishes.illuminance:
        if path not in pictures:
            illuminance_files.write_table(path, surfaces)
    return not pictures or write_pictures(pictures, wishes.scale, efficacy, integrator, request, quiet)


def write_pictures(
    paths: list[Path], scale: Scale, efficacy: float, integrator: Any, request: Request, quiet: bool
) -> bool:
    """Draw the illuminance that the camera sees, and write it; return whether all of its samples were drawn."""
    from tracer.cli.progress import watch
    from tracer.radiosity import illuminance_files
    from tracer.radiosity.photometry import illuminance
    from tracer.result import metadata
    from tracer.session.render import render_request

    integrator.quantity = "irradiance"
    with watch("Illuminance", quiet) as progress:
        result = render_request(replace(request, features=True, progress=progress))
    assert result.seen is not None
    lit = result.seen.shapes > 0
    lux = illuminance(result.rgb, efficacy)
    about = {**metadata(result, request.scene.scene_hash), "efficacy": efficacy}
    for path in paths:
        illuminance_files.write_picture(path, lux, lit, scale, result.window, about)
    return result.report.complete


def print_table(surfaces: list[LitSurface]) -> None:
    """Print the illuminance of the largest surfaces."""
    from tracer.cli.show import simple_table

    lines = []
    for surface in surfaces[:MOST_ROWS]:
        numbers = (surface.area, surface.mean, surface.least, surface.greatest)
        cells = [f"{number:.4g}" for number in numbers]
        lines.append([surface.name, surface.material, *cells, f"{surface.uniformity:.2f}"])
    simple_table(HEADINGS, lines)
    if len(surfaces) > MOST_ROWS:
        typer.echo(f"These are the {MOST_ROWS} largest of {len(surfaces)} surfaces; --illuminance FILE.csv has all.")

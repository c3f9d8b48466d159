"""Command ``radiosity``."""

from __future__ import annotations

from dataclasses import replace
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any

import typer

from tracer.cli import options

TOLERABLE = 1e-3
"""Share of the energy by which rays may be off before a person is told."""


class Method(StrEnum):
    """How the radiosity of patches is solved."""

    gathering = "gathering"
    shooting = "shooting"


class Spread(StrEnum):
    """How the rays of a patch are spread over its hemisphere."""

    guided = "guided"
    evenly = "evenly"
    randomly = "randomly"
    paper = "paper"
    paper_right = "paper_right"


class Shown(StrEnum):
    """What the picture shows."""

    gather = "gather"
    smooth = "smooth"
    patches = "patches"


def radiosity(
    scene: Annotated[Path, typer.Argument(help="Mitsuba scene file (XML), or a mesh.", show_default=False)],
    output: Annotated[Path | None, typer.Option("--output", "-o", help="Picture to write: .exr or .png.")] = None,
    illuminance: Annotated[
        list[Path] | None,
        typer.Option(help="Illuminance in lux: .png (false colours), .exr or .csv (by surface); may be repeated."),
    ] = None,
    logarithmic: Annotated[bool, typer.Option("--logarithmic", help="Make the scale of false colours so.")] = False,
    ends: Annotated[
        str | None,
        typer.Option("--range", metavar="LEAST,MOST", help="Ends of the scale in lux, to compare pictures: 0,500."),
    ] = None,
    efficacy: Annotated[
        float | None,
        typer.Option(help="Lumens in a unit of light: 1 for scenes in lumens. (683)", show_default=False),
    ] = None,
    export: Annotated[
        list[Path] | None,
        typer.Option(help="Patches to write: .vtu (ParaView) or .glb (glTF); may be repeated."),
    ] = None,
    patch: Annotated[float | None, typer.Option(help="Longest edge of a patch. (a 40th of the extent)")] = None,
    rays: Annotated[int, typer.Option(help="Rays that every patch gathers with.", min=1, max=1 << 20)] = 256,
    residual: Annotated[float, typer.Option(help="Share of the power the last round may change.")] = 1e-5,
    method: Annotated[Method, typer.Option(help="How radiosity is solved.")] = Method.gathering,
    show: Annotated[
        Shown, typer.Option(help="Light gathered anew, or patches smoothed or as they are.")
    ] = Shown.gather,
    spread: Annotated[
        Spread | None,
        typer.Option(help="How rays are spread. (guided for gathering, evenly for shooting)", show_default=False),
    ] = None,
    threshold: Annotated[float | None, typer.Option(help="Faces seen above which --spread paper splits. (2.5)")] = None,
    depth: Annotated[int | None, typer.Option(help="How many times --spread paper splits, 0 to 4. (1)")] = None,
    strict: Annotated[bool, typer.Option("--strict", help="Refuse materials that are not diffuse, and media.")] = False,
    spp: Annotated[int, typer.Option(help="Mean samples per pixel.", min=1, max=1 << 24)] = 64,
    seed: Annotated[int, typer.Option(help="Seed of the samples.", min=0)] = 0,
    sensor: options.Sensor = 0,
    size: options.Width = None,
    layers: options.Layers = None,
    overwrite: options.Overwrite = False,
    quiet: options.Quiet = False,
) -> None:
    """Solve the radiosity of a scene of diffuse surfaces, and show it with its camera.

    Illuminance is 683 lm/W times the luminance of the irradiance, whose red,
    green and blue, in W/m^2, are amounts of the sRGB primaries.

    Example: tracer radiosity room.xml -o room.exr --illuminance lux.png --export patches.vtu
    """
    from tracer.cli import illuminance as lighting
    from tracer.cli import signals
    from tracer.cli.progress import steps, watch
    from tracer.core import backend
    from tracer.errors import SceneError, SettingsError
    from tracer.io import atomic
    from tracer.io.exr import chosen_layers
    from tracer.radiosity.remarks import other_than_diffuse, remarks, with_media
    from tracer.scene.loaded import load_scene
    from tracer.session.render import render_request
    from tracer.session.request import PictureFile, Request

    if output is not None:
        atomic.check_output(output, overwrite)
    wishes = lighting.Wishes(illuminance or [], export or [], logarithmic, ends, efficacy)
    wishes.check(output, overwrite)
    layer_choice = chosen_layers(layers)
    if patch is not None and not 0 < patch < float("inf"):
        raise SettingsError(f"The edge of a patch is a length above 0, not {patch:g}.")
    if not 0 < residual < 1:
        raise SettingsError(f"The residual is a share between 0 and 1, not {residual:g}.")
    backend.activate()
    import mitsuba as mi

    from tracer.radiosity.spread import chosen_spread
    from tracer.viewpoint.showcase import is_mesh_file, showcase

    default_spread = Spread.evenly if method is Method.shooting else Spread.guided
    chosen_spread((spread or default_spread).value, method.value, threshold, depth)  # refuses what cannot be

    loaded_scene = showcase(scene) if is_mesh_file(scene) else load_scene(scene)
    loaded = loaded_scene.scene
    if strict and (not_diffuse := other_than_diffuse(loaded)):
        raise SceneError(f"Parts of '{scene}' are not diffuse: {', '.join(not_diffuse)}; leave out --strict.")
    if strict and (media := with_media(loaded)):
        raise SceneError(f"Radiosity leaves out the media of '{scene}': {', '.join(media)}; leave out --strict.")
    parameters: dict[str, Any] = {"size": patch or 0.0, "rays": rays, "residual": residual, "seed": seed}
    given = {"spread": spread and spread.value, "threshold": threshold, "depth": depth}
    parameters |= {"method": method.value, "show": show.value}
    parameters |= {name: value for name, value in given.items() if value is not None}
    integrator = mi.load_dict({"type": "radiosity", **parameters})
    with steps(quiet) as bar:

        def on_step(text: str, done: int, total: int) -> None:
            if not bar(text, done, total):
                raise KeyboardInterrupt

        integrator.prepare_scene(loaded, on_step)
    for sentence in [] if quiet else remarks(loaded):
        typer.echo(sentence, err=True)
    request = Request(loaded_scene, {"spp": spp, "seed": seed}, sensor=sensor, integrator=integrator, size=size)
    complete = True
    if output is not None:
        with watch("Rendering", quiet) as progress:
            picture = PictureFile(output, overwrite, layer_choice)
            complete = render_request(replace(request, progress=progress, picture=picture)).report.complete
    if complete:
        complete = lighting.write(wishes, integrator, request, quiet)
    if not quiet:
        solution = integrator.solution
        written = [str(path) for path in (output, *wishes.illuminance, *wishes.export) if path is not None]
        typer.echo(
            f"{len(integrator.patches)} patches, {100 * solution.guided:.0f} % of them guided, "
            f"{solution.rays / 1e6:.1f} million rays, {solution.rounds} rounds, "
            f"residual {solution.residual:.1e}; {', '.join(written)}"
        )
        if abs(getattr(solution, "energy", 1.0) - 1) > TOLERABLE:
            typer.echo(f"The rays of a patch carry {100 * solution.energy:.1f} % of its energy: the result is biased.")
    if not complete:
        raise typer.Exit(signals.exit_code())

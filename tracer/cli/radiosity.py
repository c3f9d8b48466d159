"""Command ``radiosity``."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any

import typer

from tracer.cli import options
from tracer.cli.options import Panel, advanced, basic


class Shown(StrEnum):
    """What the picture shows."""

    gather = "gather"
    smooth = "smooth"
    patches = "patches"


def radiosity(
    scene: Annotated[Path, typer.Argument(help="Mitsuba scene file (XML), or a mesh.", show_default=False)],
    output: Annotated[Path | None, basic("Picture, .exr or .png.", name="--output", short="-o", metavar="FILE")] = None,
    overwrite: options.Overwrite = False,
    size: options.Width = None,
    spp: Annotated[int, basic("Mean samples per pixel. (64)", metavar="N", min=1, max=1 << 24)] = 64,
    seed: Annotated[int, advanced("Seed of the samples. (0)", metavar="N", min=0)] = 0,
    sensor: Annotated[int, advanced("Number of the scene's sensor, from 0. (0)", metavar="N")] = 0,
    layers: Annotated[
        str | None, advanced("rgb: an EXR without layers. (all)", name="--layers", metavar="all|rgb")
    ] = None,
    strict: Annotated[bool, advanced("Refuse materials that are not diffuse, and media.", name="--strict")] = False,
    quiet: options.Quiet = False,
    help_all: options.HelpAll = False,
    illuminance: Annotated[
        list[Path] | None,
        basic("In lux: .png (false colours), .exr or .csv; may be repeated.", Panel.LUX, metavar="FILE"),
    ] = None,
    logarithmic: Annotated[
        bool, advanced("Make the scale of false colours logarithmic.", Panel.LUX, name="--logarithmic")
    ] = False,
    ends: Annotated[
        str | None,
        advanced("Ends of that scale in lux, such as 0,500.", Panel.LUX, name="--range", metavar="LEAST,MOST"),
    ] = None,
    efficacy: Annotated[
        float | None, advanced("Lumens in a unit of light: 1 for scenes in lumens. (683)", Panel.LUX, metavar="X")
    ] = None,
    export: Annotated[
        list[Path] | None,
        basic("Patches: .vtu (ParaView) or .glb (glTF); may be repeated.", Panel.LUX, metavar="FILE"),
    ] = None,
    patch: Annotated[
        float | None, basic("Longest edge of a patch. (a 40th of the extent)", Panel.SOLUTION, metavar="LENGTH")
    ] = None,
    rays: Annotated[int, basic("Rays of every patch. (256)", Panel.SOLUTION, metavar="N", min=1, max=1 << 20)] = 256,
    residual: Annotated[
        float, advanced("Share of the power that the last round may change. (1e-5)", Panel.SOLUTION, metavar="X")
    ] = 1e-5,
    method: Annotated[str, basic("gathering or shooting. (gathering)", Panel.SOLUTION, metavar="NAME")] = "gathering",
    show: Annotated[
        Shown,
        basic("gather (light gathered anew), smooth or patches. (gather)", Panel.SOLUTION, metavar="NAME"),
    ] = Shown.gather,
    spread: Annotated[
        str | None,
        basic("How rays are spread, a name below.", Panel.SOLUTION, metavar="NAME"),
    ] = None,
    threshold: Annotated[
        float | None, advanced("Faces seen above which --spread paper splits. (2.5)", Panel.SOLUTION, metavar="X")
    ] = None,
    depth: Annotated[
        int | None, advanced("How many times --spread paper splits, 0 to 4. (1)", Panel.SOLUTION, metavar="N")
    ] = None,
) -> None:
    """Solve the radiosity of a scene of diffuse surfaces, and show it with its camera.

    Illuminance is 683 lm/W times the luminance of the irradiance, whose red,
    green and blue, in W/m^2, are amounts of the sRGB primaries.

    Example: tracer radiosity room.xml -o room.exr --illuminance lux.png --export patches.vtu
    """
    from tracer.cli import illuminance as lighting
    from tracer.cli import signals
    from tracer.cli.progress import steps, watch
    from tracer.errors import SettingsError
    from tracer.io import atomic
    from tracer.io.exr import chosen_layers

    if output is not None:
        atomic.check_output(output, overwrite)
    wishes = lighting.Wishes(illuminance or [], export or [], logarithmic, ends, efficacy)
    wishes.check(output, overwrite)
    layer_choice = chosen_layers(layers)
    if patch is not None and not 0 < patch < float("inf"):
        raise SettingsError(f"The edge of a patch is a length above 0, not {patch:g}.")
    if not 0 < residual < 1:
        raise SettingsError(f"The residual is a share between 0 and 1, not {residual:g}.")
    parameters: dict[str, Any] = {"size": patch or 0.0, "rays": rays, "residual": residual, "seed": seed}
    given = {"spread": spread, "threshold": threshold, "depth": depth}
    parameters |= {"method": method, "show": show.value}
    parameters |= {name: value for name, value in given.items() if value is not None}
    with steps(quiet) as bar:
        bar.begin("Starting Mitsuba")
        from tracer.session.render import render_request
        from tracer.session.request import PictureFile, Request

        loaded_scene, integrator = opened(scene, parameters, strict, bar.begin)

        def on_step(text: str, done: int, total: int) -> None:
            if not bar(text, done, total):
                raise KeyboardInterrupt

        integrator.prepare_scene(loaded_scene.scene, on_step)
        from tracer.radiosity.remarks import bias_remarks, remarks
    for sentence in [] if quiet else remarks(loaded_scene.scene):
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
        for sentence in bias_remarks(solution.energy, integrator.rules):
            typer.echo(sentence)
    if not complete:
        raise typer.Exit(signals.exit_code())


def opened(path: Path, parameters: dict[str, Any], strict: bool, stage: Callable[[str], None]) -> tuple[Any, Any]:
    """Return a scene, and the integrator that is to solve it.

    ``parameters``: of the integrator. ``strict``: whether what radiosity cannot show is refused. ``stage`` hears what
    is being done. Raises SettingsError for parameters that cannot be, and SceneError.
    """
    from tracer.core import backend
    from tracer.errors import SceneError

    backend.activate()
    import mitsuba as mi

    from tracer.radiosity.remarks import other_than_diffuse, with_media
    from tracer.radiosity.spread import chosen_spread, usual_spread
    from tracer.scene.loaded import load_scene
    from tracer.viewpoint.showcase import is_mesh_file, showcase

    method, spread = parameters["method"], parameters.get("spread")
    chosen_spread(spread or usual_spread(method), method, parameters.get("threshold"), parameters.get("depth"))
    stage(f"Opening {path.name}")
    loaded_scene = showcase(path) if is_mesh_file(path) else load_scene(path)
    scene = loaded_scene.scene
    if strict and (not_diffuse := other_than_diffuse(scene)):
        raise SceneError(f"Parts of '{path}' are not diffuse: {', '.join(not_diffuse)}; leave out --strict.")
    if strict and (media := with_media(scene)):
        raise SceneError(f"Radiosity leaves out the media of '{path}': {', '.join(media)}; leave out --strict.")
    return loaded_scene, mi.load_dict({"type": "radiosity", **parameters})

"""Command ``radiosity``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from tracer.cli import options


def radiosity(
    scene: options.SceneFile,
    output: Annotated[Path, typer.Option("--output", "-o", help="Picture to write: .exr or .png.")],
    patch: Annotated[float | None, typer.Option(help="Longest edge of a patch. [a 40th of the extent]")] = None,
    rays: Annotated[int, typer.Option(help="Rays that every patch gathers with.", min=1, max=1 << 20)] = 256,
    residual: Annotated[float, typer.Option(help="Share of the power the last round may change.")] = 1e-5,
    patches: Annotated[bool, typer.Option("--patches", help="Show the patches, without a final gather.")] = False,
    strict: Annotated[bool, typer.Option("--strict", help="Refuse materials that are not diffuse.")] = False,
    spp: Annotated[int, typer.Option(help="Mean samples per pixel.", min=1, max=1 << 24)] = 64,
    seed: Annotated[int, typer.Option(help="Seed of the samples.", min=0)] = 0,
    sensor: options.Sensor = 0,
    size: options.Width = None,
    overwrite: options.Overwrite = False,
    quiet: options.Quiet = False,
) -> None:
    """Solve the radiosity of a scene of diffuse meshes, and show it with its camera.

    Example: tracer radiosity scene.xml -o out.exr
    """
    from tracer import backend, files
    from tracer.cli.progress import steps, watch
    from tracer.errors import SceneError, SettingsError
    from tracer.loop import render
    from tracer.metadata import metadata
    from tracer.source import fingerprint, load

    files.check_output(output, overwrite)
    if patch is not None and not 0 < patch < float("inf"):
        raise SettingsError(f"The edge of a patch must be longer than 0, not {patch:g}.")
    if not 0 < residual < 1:
        raise SettingsError(f"The residual is a share between 0 and 1, not {residual:g}.")
    backend.activate()
    import mitsuba as mi

    scene_hash = fingerprint(scene)
    loaded = load(scene)
    if loaded.class_name() != "Scene":
        raise SceneError(f"'{scene}' holds a {loaded.class_name()}, not a scene; wrap it in <scene>.")
    chosen = {"size": patch or 0.0, "rays": rays, "residual": residual, "seed": seed, "final_gather": not patches}
    integrator = mi.load_dict({"type": "radiosity", **chosen})
    with steps(quiet) as step:

        def told(text: str, done: int, total: int) -> None:
            if not step(text, done, total):
                raise KeyboardInterrupt

        integrator.solve_for(loaded, told)
    others = integrator.patches.not_diffuse
    if others and strict:
        raise SceneError(f"These shapes of '{scene}' are not diffuse: {', '.join(others)}; leave out --strict.")
    if others and not quiet:
        typer.echo(f"Not diffuse, and shown by the diffuse part alone: {', '.join(others)}", err=True)
    with watch("Rendering", quiet) as progress:
        result = render(loaded, integrator=integrator, sensor=sensor, size=size, spp=spp, seed=seed, progress=progress)
    files.write_result(output, result, metadata(result, scene_hash))
    if not quiet:
        found = integrator.solution
        typer.echo(
            f"{len(integrator.patches)} patches, {found.rays / 1e6:.1f} million rays, {found.rounds} rounds, "
            f"residual {found.residual:.1e}; {output}"
        )
    if not result.report.complete:
        raise typer.Exit(130)

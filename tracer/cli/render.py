"""Command ``render``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from tracer.cli import options


def render(
    scene: options.SceneFile,
    output: Annotated[Path, typer.Option("--output", "-o", help="Picture to write: .exr (all layers) or .png.")],
    spp: Annotated[int, typer.Option(help="Mean samples per pixel.")] = 64,
    seed: options.Seed = 0,
    criterion: options.Criterion = "fused",
    objective: options.Objective = "relative",
    integrator: options.Integrator = None,
    sensor: options.Sensor = 0,
    size: options.Width = None,
    pilot_spp: Annotated[int | None, typer.Option(help="Rays per pixel that look first.")] = None,
    min_spp: Annotated[int | None, typer.Option(help="Least samples of any pixel.")] = None,
    max_spp: Annotated[int | None, typer.Option(help="Most samples of any pixel.")] = None,
    block: Annotated[int, typer.Option(help="Side of the blocks over which ID complexity is measured.")] = 1,
    overwrite: options.Overwrite = False,
    quiet: options.Quiet = False,
) -> None:
    """Render a scene adaptively. Ctrl-C stops after the current pass and keeps what there is, marked as such.

    Example: tracer render scene.xml -o out.exr --spp 64
    """
    from tracer import files
    from tracer.cli.progress import watch

    files.check_output(output, overwrite)
    settings: dict[str, Any] = {"spp": spp, "seed": seed, "criterion": criterion, "objective": objective}
    optional = {"pilot_spp": pilot_spp, "min_spp": min_spp, "max_spp": max_spp}
    settings |= {"block": block} | {name: value for name, value in optional.items() if value is not None}

    from tracer.loop import render as render_scene
    from tracer.metadata import metadata
    from tracer.settings import make_settings
    from tracer.source import fingerprint

    make_settings(**settings)
    with watch("Rendering", quiet) as progress:
        result = render_scene(scene, integrator=integrator, sensor=sensor, size=size, progress=progress, **settings)
    files.write_result(output, result, metadata(result, fingerprint(scene)))
    if not quiet:
        summary = (
            f"{output}: {result.image.shape[1]} x {result.image.shape[0]}, "
            f"{result.samples.min()} to {result.samples.max()} samples per pixel, {result.seconds:.1f} s"
        )
        typer.echo("\n".join([summary, *result.report.notes]))
    if not result.report.complete:
        raise typer.Exit(130)

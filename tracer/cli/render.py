"""Command ``render``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from tracer.cli import options


def render(
    scene: options.SceneFile,
    output: Annotated[Path, typer.Option("--output", "-o", help="Picture to write: .exr (all layers) or .png.")],
    spp: Annotated[int | None, typer.Option(help="Mean samples per pixel. [64]")] = None,
    seed: Annotated[int | None, typer.Option(help="Seed of the samples. [0]")] = None,
    criterion: Annotated[str | None, typer.Option(help="Where it is worth it: fused, variance, ... [fused]")] = None,
    objective: Annotated[str | None, typer.Option(help="Which error is to be small. [relative]")] = None,
    exposure: Annotated[float | None, typer.Option(help="Stops by which the picture will be brightened. [0]")] = None,
    integrator: options.Integrator = None,
    sensor: options.Sensor = 0,
    size: options.Width = None,
    pilot_spp: Annotated[int | None, typer.Option(help="Rays per pixel that look first.")] = None,
    min_spp: Annotated[int | None, typer.Option(help="Least samples of any pixel.")] = None,
    max_spp: Annotated[int | None, typer.Option(help="Most samples of any pixel.")] = None,
    cost: Annotated[str | None, typer.Option(help="What a sample costs: none (all the same), or rays. [none]")] = None,
    importance: Annotated[
        str | None, typer.Option(help="Image that multiplies the importance: mask or weight.")
    ] = None,
    shape_weight: Annotated[
        list[str] | None, typer.Option(help="ID=FACTOR: importance of what a shape covers; may be repeated.")
    ] = None,
    block: Annotated[int | None, typer.Option(help="Side of the blocks of ID complexity. [1]")] = None,
    unbiased: Annotated[
        bool | None, typer.Option("--unbiased", help="Keep the samples that decide out of the picture.")
    ] = None,
    overwrite: options.Overwrite = False,
    quiet: options.Quiet = False,
) -> None:
    """Render a scene adaptively. Ctrl-C stops after the current pass and keeps what there is, marked as such.

    Example: tracer render scene.xml -o out.exr --spp 64
    """
    from tracer import files

    files.check_output(output, overwrite)
    given = {
        "spp": spp,
        "seed": seed,
        "criterion": criterion,
        "objective": objective,
        "exposure": exposure,
        "pilot_spp": pilot_spp,
        "min_spp": min_spp,
        "max_spp": max_spp,
        "cost": cost,
        "importance": importance,
        "shape_weights": ",".join(shape_weight) if shape_weight else None,
        "block": block,
        "unbiased": unbiased,
    }
    settings: dict[str, Any] = {name: value for name, value in given.items() if value is not None}

    from tracer import backend
    from tracer.cli.progress import watch
    from tracer.loop import render as render_scene
    from tracer.metadata import metadata
    from tracer.settings import check_settings
    from tracer.source import fingerprint

    check_settings(**settings)
    backend.activate()
    scene_hash = fingerprint(scene)  # of what is rendered, even if the file is edited meanwhile
    with watch("Rendering", quiet) as progress:
        result = render_scene(scene, integrator=integrator, sensor=sensor, size=size, progress=progress, **settings)
    files.write_result(output, result, metadata(result, scene_hash))
    summary = (
        f"{output}: {result.image.shape[1]} x {result.image.shape[0]}, "
        f"{result.samples.min()} to {result.samples.max()} samples per pixel, {result.seconds:.1f} s"
    )
    if not quiet:
        typer.echo("\n".join([summary, *result.report.notes]))
    if not result.report.complete:
        raise typer.Exit(130)

"""Command ``render``."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated, Any

import typer

from tracer.cli import options
from tracer.cli.options import Panel

OWN = ("config", "shape_weight", "quiet", "as_json")
"""Parameters of the command line alone; all others are fields or settings of a job and have the same names there."""


def render(
    context: typer.Context,
    scene: options.SceneFile,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="Picture to write: .exr (all layers) or .png.")
    ] = None,
    config: Annotated[Path | None, typer.Option(help="TOML file with options by name; the command line wins.")] = None,
    spp: Annotated[int | None, typer.Option(help="Mean samples per pixel. [64]", rich_help_panel=Panel.STOP)] = None,
    noise: Annotated[
        float | None, typer.Option(help="Stop when the error is below; see above.", rich_help_panel=Panel.STOP)
    ] = None,
    noise_share: Annotated[
        float | None, typer.Option(help="Share of the pixels that --noise is for. [0.95]", rich_help_panel=Panel.STOP)
    ] = None,
    time: Annotated[
        float | None, typer.Option(help="Seconds until the end, start-up included.", rich_help_panel=Panel.STOP)
    ] = None,
    checkpoint: Annotated[
        Path | None, typer.Option(help="File to keep the state in.", rich_help_panel=Panel.STOP)
    ] = None,
    checkpoint_every: Annotated[
        float | None, typer.Option(help="Seconds between two writes of it. [60]", rich_help_panel=Panel.STOP)
    ] = None,
    resume: Annotated[
        bool | None, typer.Option("--resume", help="Go on from the checkpoint, if any.", rich_help_panel=Panel.STOP)
    ] = None,
    integrator: options.Integrator = None,
    sensor: Annotated[
        list[str] | None, typer.Option(help="Number of a sensor, from 0; may be repeated; or all. [0]")
    ] = None,
    size: options.Width = None,
    crop: Annotated[str | None, typer.Option(help="x,y,width,height: only that part of the picture.")] = None,
    define: Annotated[list[str] | None, typer.Option("--define", "-D", help="name=value of a $parameter.")] = None,
    frames: Annotated[
        str | None, typer.Option(help='"1-24" or "1-24:2": #### in file names, and $frame, are the number.')
    ] = None,
    variant: Annotated[str | None, typer.Option(help="Mitsuba variant. (llvm_ad_rgb)")] = None,
    seed: Annotated[int | None, typer.Option(help="Seed of the samples. [0]", rich_help_panel=Panel.WHERE)] = None,
    criterion: Annotated[
        str | None,
        typer.Option(
            help="What finds importance: fused, variance, ... (fused)",
            rich_help_panel=Panel.WHERE,
            autocompletion=options.criteria_names,
        ),
    ] = None,
    objective: Annotated[
        str | None,
        typer.Option(
            help="Which error is to be small. (relative)",
            rich_help_panel=Panel.WHERE,
            autocompletion=options.objective_names,
        ),
    ] = None,
    exposure: Annotated[
        float | None,
        typer.Option(help="Stops by which the picture will be brightened. [0]", rich_help_panel=Panel.WHERE),
    ] = None,
    importance: Annotated[
        str | None,
        typer.Option(help="Image, mask or weights, to multiply the importance by.", rich_help_panel=Panel.WHERE),
    ] = None,
    shape_weight: Annotated[
        list[str] | None,
        typer.Option(
            help="NAME=FACTOR: importance of what a shape covers; may be repeated.", rich_help_panel=Panel.WHERE
        ),
    ] = None,
    pilot_spp: Annotated[
        int | None,
        typer.Option(help="Samples that look first, and pilot rays, per pixel.", rich_help_panel=Panel.WHERE),
    ] = None,
    min_spp: Annotated[
        int | None, typer.Option(help="Least samples of any pixel.", rich_help_panel=Panel.WHERE)
    ] = None,
    max_spp: Annotated[int | None, typer.Option(help="Most samples of any pixel.", rich_help_panel=Panel.WHERE)] = None,
    cost: Annotated[
        str | None,
        typer.Option(help="Cost of a sample: by its rays, or none for equal. (none)", rich_help_panel=Panel.WHERE),
    ] = None,
    block: Annotated[
        int | None, typer.Option(help="Side of the blocks of ID complexity. [1]", rich_help_panel=Panel.WHERE)
    ] = None,
    unbiased: Annotated[
        bool | None,
        typer.Option("--unbiased", help="Leave samples that decide out of the picture.", rich_help_panel=Panel.WHERE),
    ] = None,
    guide: Annotated[
        bool | None,
        typer.Option(
            "--guide/--no-guide", help="Learn which lights matter. (where it may pay)", rich_help_panel=Panel.WHERE
        ),
    ] = None,
    memory: Annotated[float | None, typer.Option(help="Most memory to use, in GiB.")] = None,
    workers: options.Workers = None,
    part: Annotated[
        str | None, typer.Option(help='"3/8": the third of eight parts, for merge.', rich_help_panel=Panel.WHO)
    ] = None,
    scheduler: options.Scheduler = None,
    live: Annotated[Path | None, typer.Option(help="PNG that shows the picture while it renders.")] = None,
    tev: Annotated[str | None, typer.Option(help="host:port of a tev viewer that shows it, too.")] = None,
    features: Annotated[
        bool | None, typer.Option("--features", help="Write albedo, normal, depth and numbers of shapes, too.")
    ] = None,
    denoise: Annotated[
        bool | None, typer.Option("--denoise", help="Take out the noise (Open Image Denoise); keep it as a layer.")
    ] = None,
    layers: options.Layers = None,
    overwrite: options.Overwrite = False,
    quiet: options.Quiet = False,
    as_json: options.AsJson = False,
) -> None:
    """Render a scene adaptively, until --spp, --noise or --time is reached, whichever comes first.

    --noise 0.05 means: 95 of 100 pixels (--noise-share) are estimated to be
    off by at most 5 % of their brightness, or with --objective display by
    0.05 of what a screen shows. Ctrl-C and SIGTERM stop after the current
    pass and keep what there is: picture, marked as such, and checkpoint.

    Example: tracer render scene.xml -o out.exr --noise 0.05 --time 600 --checkpoint out.ckpt
    """
    given = {name: value for name, value in options.given(context).items() if name not in OWN}
    if shape_weight:
        given["shape_weights"] = ",".join(shape_weight)

    from tracer.cli import signals
    from tracer.cli.progress import watch
    from tracer.cli.startup import STARTED
    from tracer.errors import WriteError
    from tracer.jobs.job import make_job
    from tracer.jobs.run import perform

    job = make_job(given, config)
    any_unwritten = False

    def tell(sentence: str) -> None:
        if not quiet:
            typer.echo(sentence, err=True)

    with watch("Rendering", quiet or as_json) as progress:
        for picture, result in perform(job, progress, STARTED, tell):
            progress.clear()
            report = result.report
            if as_json:
                typer.echo(json.dumps({"output": picture.name, **summary(result)}))
            elif not quiet:
                notes = [note for note in report.notes if note not in report.unwritten]
                typer.echo("\n".join([f"{picture.name}: {in_words(result)}", *notes]))
            for message in report.unwritten:
                typer.echo(f"tracer: {message}", err=True)
            any_unwritten = any_unwritten or bool(report.unwritten)
            if not report.complete:
                raise typer.Exit(signals.exit_code())
    if any_unwritten:
        raise typer.Exit(WriteError.exit_code)


def summary(result: Any) -> dict[str, Any]:
    """Return size, time and report of a picture as plain values."""
    height, width = result.image.shape[:2]
    return {"width": width, "height": height, "seconds": result.seconds, **result.report.as_dict()}


def in_words(result: Any) -> str:
    """Return a line about a picture: size, samples, time and noise."""
    from tracer.core.quantities import mean_count, percent

    report = result.report
    height, width = result.image.shape[:2]
    text = f"{width} x {height}, {result.samples.min()} to {result.samples.max()} samples per pixel"
    text += f" ({mean_count(result.samples.mean())} on average), {result.seconds:.1f} s"
    if report.converged is not None:
        text += f"; {percent(report.converged, 1)} % converged"
        text += f" ({100 * report.settings.noise_share:g} % within {report.noise:.3g})"
    if report.pixels_at_most:
        text += f"; {report.pixels_at_most} pixels have the most samples"
    return text

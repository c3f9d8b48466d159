"""Command ``render``."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated, Any

import typer

from tracer.cli import options
from tracer.cli.options import Panel, advanced

OWN = ("config", "shape_weight", "quiet", "as_json", "help_all")
"""Parameters of the command line alone; all others are fields or settings of a job and have the same names there."""


def render(
    context: typer.Context,
    scene: options.SceneFile,
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", help="Picture, .exr or .png. (scene.exr)", metavar="FILE"),
    ] = None,
    overwrite: options.Overwrite = False,
    size: options.Width = None,
    denoise: Annotated[
        bool | None, typer.Option("--denoise", help="Take out the noise with Open Image Denoise.")
    ] = None,
    layers: options.Layers = None,
    features: Annotated[
        bool | None, advanced("Write albedo, normal, depth and numbers of shapes, too.", name="--features")
    ] = None,
    config: Annotated[
        Path | None, advanced("TOML file with options by name; the command line wins.", metavar="FILE")
    ] = None,
    integrator: Annotated[str | None, advanced("Plugin instead of the scene's integrator.", metavar="NAME")] = None,
    sensor: Annotated[
        list[str] | None, advanced("Number of a sensor, from 0; may be repeated; or all. [0]", metavar="N")
    ] = None,
    crop: Annotated[str | None, advanced("Only that part of the picture.", metavar="X,Y,WIDTH,HEIGHT")] = None,
    define: Annotated[
        list[str] | None, advanced("Value of a $parameter.", name="--define", short="-D", metavar="NAME=VALUE")
    ] = None,
    frames: Annotated[
        str | None,
        advanced('"1-24" or "1-24:2": #### in file names, and $frame, are the number.', metavar="RANGE"),
    ] = None,
    variant: Annotated[str | None, advanced("Mitsuba variant. (llvm_ad_rgb)", metavar="NAME")] = None,
    memory: Annotated[float | None, advanced("Most memory to use, in GiB.", metavar="GIB")] = None,
    live: Annotated[Path | None, advanced("PNG that shows the picture while it renders.", metavar="FILE")] = None,
    tev: Annotated[str | None, advanced("A tev viewer that shows it, too.", metavar="HOST:PORT")] = None,
    quiet: options.Quiet = False,
    as_json: Annotated[bool, advanced("Print one JSON object a picture, for machines.", name="--json")] = False,
    help_all: options.HelpAll = False,
    spp: Annotated[
        int | None,
        typer.Option(help="Mean samples per pixel. (the scene's, or 64)", metavar="N", rich_help_panel=Panel.STOP),
    ] = None,
    noise: Annotated[
        float | None,
        typer.Option(help="Error below which it stops, see above.", metavar="X", rich_help_panel=Panel.STOP),
    ] = None,
    noise_share: Annotated[
        float | None, advanced("Share of the pixels that --noise is for. [0.95]", Panel.STOP, metavar="X")
    ] = None,
    time: Annotated[
        float | None,
        typer.Option(help="Time until the end, start-up included.", metavar="SECONDS", rich_help_panel=Panel.STOP),
    ] = None,
    checkpoint: Annotated[
        Path | None, typer.Option(help="File to keep the state in.", metavar="FILE", rich_help_panel=Panel.STOP)
    ] = None,
    checkpoint_every: Annotated[
        float | None, advanced("Time between two writes of it. [60]", Panel.STOP, metavar="SECONDS")
    ] = None,
    resume: Annotated[
        bool | None, typer.Option("--resume", help="Go on from the checkpoint, if any.", rich_help_panel=Panel.STOP)
    ] = None,
    criterion: Annotated[
        str | None,
        typer.Option(
            help="A name below, or your own Python file. (fused)",
            metavar="NAME",
            rich_help_panel=Panel.WHERE,
            autocompletion=options.criteria_names,
        ),
    ] = None,
    objective: Annotated[
        str | None,
        typer.Option(
            help=f"Error to lower: {options.OBJECTIVES}.",
            metavar="NAME",
            rich_help_panel=Panel.WHERE,
            autocompletion=options.objective_names,
        ),
    ] = None,
    exposure: Annotated[
        float | None, advanced("Stops by which the picture will be brightened. [0]", Panel.WHERE, metavar="STOPS")
    ] = None,
    importance: Annotated[
        str | None, advanced("Image, mask or weights, to multiply the importance by.", Panel.WHERE, metavar="FILE")
    ] = None,
    shape_weight: Annotated[
        list[str] | None,
        advanced("Importance of what a shape covers; may be repeated.", Panel.WHERE, metavar="NAME=FACTOR"),
    ] = None,
    pilot_spp: Annotated[
        int | None, advanced("Samples that look first, and pilot rays, per pixel.", Panel.WHERE, metavar="N")
    ] = None,
    min_spp: Annotated[
        int | None, advanced("Least samples of any pixel. (an eighth of spp)", Panel.WHERE, metavar="N")
    ] = None,
    max_spp: Annotated[
        int | None, advanced("Most samples of any pixel. (32 times spp)", Panel.WHERE, metavar="N")
    ] = None,
    cost: Annotated[
        str | None,
        advanced(
            "Cost of a sample: equal, the work of its path, or the root of that. (root)",
            Panel.WHERE,
            metavar="none|root|work",
        ),
    ] = None,
    block: Annotated[
        int | None, advanced("Side of the blocks of ID complexity. [1]", Panel.WHERE, metavar="PIXELS")
    ] = None,
    unbiased: Annotated[
        bool | None, advanced("Leave samples that decide out of the picture.", Panel.WHERE, name="--unbiased")
    ] = None,
    guide: Annotated[
        bool | None,
        advanced("Learn which lights matter. (where it may pay)", Panel.WHERE, name="--guide/--no-guide"),
    ] = None,
    seed: Annotated[
        int | None, typer.Option(help="Seed of the samples. [0]", metavar="N", rich_help_panel=Panel.WHERE)
    ] = None,
    workers: options.Workers = None,
    scheduler: Annotated[
        str | None, advanced("Dask scheduler, or the file that it has left.", Panel.WHO, metavar="ADDRESS")
    ] = None,
    part: Annotated[
        str | None, advanced('"3/8": the third of eight parts, for merge.', Panel.WHO, metavar="PART")
    ] = None,
) -> None:
    """Render a scene adaptively, until --spp, --noise or --time is reached, whichever comes first.

    --noise 0.05 means: 95 of 100 pixels are estimated to be off by at most
    5 % of their brightness (with --objective display, of what a screen
    shows). Ctrl-C stops and keeps what there is, picture and checkpoint.

    Example: tracer render scene.xml --noise 0.05 --time 600
    """
    given = {name: value for name, value in options.given(context).items() if name not in OWN}
    if shape_weight:
        given["shape_weights"] = ",".join(shape_weight)

    from tracer.cli import signals
    from tracer.cli.progress import watch
    from tracer.cli.startup import STARTED
    from tracer.errors import WriteError

    any_unwritten = False

    def tell(sentence: str) -> None:
        if not quiet:
            typer.echo(sentence, err=True)

    with watch("Rendering", quiet or as_json) as progress:
        progress.stage("Starting Mitsuba")
        from tracer.jobs.job import make_job
        from tracer.jobs.run import perform

        job = make_job(given, config)
        for picture, result in perform(job, progress, STARTED, tell, progress.stage):
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
    from tracer.core.quantities import mean_count, percent, samples_in_words

    report = result.report
    height, width = result.image.shape[:2]
    least, most, mean = result.samples.min(), result.samples.max(), mean_count(result.samples.mean())
    samples = samples_in_words(least) if least == most else f"{mean} ({least} to {most}) samples per pixel"
    text = f"{width} x {height}, {samples}, {result.seconds:.1f} s"
    if report.converged is not None:
        text += f"; {percent(report.converged, 1)} % converged"
        text += f" ({100 * report.settings.noise_share:g} % within {report.noise:.3g})"
    if report.pixels_at_most:
        most_samples = report.settings.most_samples
        text += f"; {report.pixels_at_most} pixels reached the most that a pixel may have, {most_samples} (--max-spp)"
    return text

"""Command ``merge``."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer

from tracer.cli import options


def merge(
    checkpoints: Annotated[list[Path], typer.Argument(help="Checkpoints of one picture, with different seeds.")],
    output: Annotated[Path, typer.Option("--output", "-o", help="Picture to write: .exr (all layers) or .png.")],
    checkpoint: Annotated[Path | None, typer.Option(help="Checkpoint of all of them, for another merge.")] = None,
    denoise: Annotated[
        bool, typer.Option("--denoise", help="Take out the noise (Open Image Denoise); keep it as a layer.")
    ] = False,
    layers: options.Layers = None,
    overwrite: options.Overwrite = False,
    quiet: options.Quiet = False,
    as_json: options.AsJson = False,
) -> None:
    """Merge checkpoints that a farm has rendered of one picture; every pixel counts by its samples.

    Example: tracer merge part1.ckpt part2.ckpt -o out.exr --denoise
    """
    from tracer.io import atomic
    from tracer.io.exr import chosen_layers

    atomic.check_output(output, overwrite)
    layer_choice = chosen_layers(layers)
    if checkpoint is not None:
        atomic.check_output(checkpoint, overwrite, suffixes=())

    from tracer.cli.render import in_words, summary
    from tracer.result import metadata, write_result
    from tracer.session.merge import merge as merge_files

    result, merged = merge_files(checkpoints, checkpoint, denoise)
    entries = {**metadata(result, merged.identity["scene"]), "sources": merged.sources}
    write_result(output, result, entries, layer_choice)
    if as_json:
        typer.echo(json.dumps({"output": str(output), **summary(result)}))
    elif not quiet:
        typer.echo("\n".join([f"{output}: {in_words(result)}", *result.report.notes]))

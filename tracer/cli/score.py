"""Command ``score``."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer

HEADINGS = ("picture", "relMSE", "trimmed", "MSE", "PSNR", "SSIM", "FLIP", "bias")
"""Headings of the columns of the table."""


def score(
    pictures: Annotated[list[Path], typer.Argument(help="Pictures by any renderer: EXR, PNG.", show_default=False)],
    reference: Annotated[Path, typer.Argument(help="What they should look like.", show_default=False)],
    layer: Annotated[
        str | None,
        typer.Option(
            help='Layer of the pictures, such as "Beauty" for Beauty.R. Of the reference, the layer of the same name '
            "is taken, or its main picture if it has no such layer."
        ),
    ] = None,
    reference_layer: Annotated[
        str | None,
        typer.Option(help='Layer of the reference, if another one; "" for the channels without a layer.'),
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print numbers for a program.")] = False,
) -> None:
    """Measure the error of pictures against a reference, as tracer study does.

    If a layer is named, the layers that are compared are printed.

    Example: tracer score a.exr b.exr reference.exr
    """
    from dataclasses import asdict

    from tracer.cli.show import simple_table
    from tracer.image import metrics as metrics
    from tracer.io.images import read_picture, read_reference, score_pair
    from tracer.study.write import finite

    taken_layer = reference_layer
    if reference_layer is None:
        truth, taken_layer = read_reference(reference, layer)
    else:
        truth = read_picture(reference, reference_layer)
    scores_by_picture = {}
    for path in pictures:
        pair = score_pair(path, read_picture(path, layer), reference, truth)
        scores_by_picture[str(path)] = metrics.all_scores(*pair)
    if layer is not None or reference_layer is not None:
        typer.echo(f"{of_pictures(layer)} against {of_reference(taken_layer, reference)}.", err=True)
    if as_json:
        values = finite({name: asdict(scores) for name, scores in scores_by_picture.items()})
        typer.echo(json.dumps(values, indent=1, allow_nan=False))
        return
    lines = []
    for name, scores in scores_by_picture.items():
        error_cells = [f"{error:.4g}" for error in (scores.relative_mse, scores.relative_mse_trimmed, scores.mse)]
        further_cells = [f"{scores.psnr:.2f}", f"{scores.ssim:.4f}", f"{scores.flip:.4f}", f"{100 * scores.bias:.2f} %"]
        lines.append([name, *error_cells, *further_cells])
    simple_table(HEADINGS, lines)


def of_pictures(layer: str | None) -> str:
    """Return in words which layer of the pictures is scored, as the beginning of a sentence."""
    return f"Layer '{layer}' of the pictures" if layer else "The pictures themselves"


def of_reference(layer: str | None, path: Path) -> str:
    """Return in words which layer of the reference the pictures are scored against."""
    return f"layer '{layer}' of '{path}'" if layer else f"the picture of '{path}' itself"

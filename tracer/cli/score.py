"""Command ``score``."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer

HEADINGS = ("picture", "relMSE", "trimmed", "MSE", "PSNR", "SSIM", "FLIP", "bias")


def score(
    pictures: Annotated[list[Path], typer.Argument(help="Pictures by any renderer: EXR, PNG.", show_default=False)],
    reference: Annotated[Path, typer.Argument(help="What they should look like.", show_default=False)],
    layer: Annotated[str | None, typer.Option(help='Layer of an EXR, as in "Beauty" for Beauty.R.')] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print numbers for a program.")] = False,
) -> None:
    """Measure the error of pictures against a reference, as tracer study does.

    Example: tracer score a.exr b.exr reference.exr
    """
    from dataclasses import asdict

    from tracer import score as metrics
    from tracer.cli.show import simple_table
    from tracer.errors import ScoreError
    from tracer.pictures import read_picture, score_pair
    from tracer.study.write import finite

    truth = read_picture(reference, layer)
    if min(truth.shape[:2]) < metrics.SSIM_WINDOW:
        side = metrics.SSIM_WINDOW
        raise ScoreError(f"'{reference}' is smaller than {side} x {side} pixels, too small for structural similarity.")
    found = {}
    for path in pictures:
        pair = score_pair(path, read_picture(path, layer), reference, truth)
        found[str(path)] = metrics.all_scores(*pair)
    if as_json:
        plain = finite({name: asdict(scores) for name, scores in found.items()})
        typer.echo(json.dumps(plain, indent=1, allow_nan=False))
        return
    lines = []
    for name, one in found.items():
        errors = [f"{error:.4g}" for error in (one.relative_mse, one.relative_mse_trimmed, one.mse)]
        lines.append(
            [name, *errors, f"{one.psnr:.2f}", f"{one.ssim:.4f}", f"{one.flip:.4f}", f"{100 * one.bias:.2f} %"]
        )
    simple_table(HEADINGS, lines)

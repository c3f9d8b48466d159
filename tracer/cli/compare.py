"""Command ``compare``."""

from __future__ import annotations

import re
import tempfile
from pathlib import Path
from typing import Annotated

import typer

from tracer.cli import options

REFERENCE_FACTOR = 64
"""Largest number of samples of a reference, as a multiple of the largest budget, unless it is given."""


STOCK = ("independent", "multijitter")
"""Samplers with which plain ``mi.render`` is measured."""


def compare(
    scenes: Annotated[list[Path], typer.Argument(help="Mitsuba scene files (XML).", show_default=False)],
    spp: Annotated[list[int] | None, typer.Option(help="Mean samples per pixel; several may follow. [64]")] = None,
    seeds: Annotated[int, typer.Option(help="How many seeds.", min=1)] = 5,
    first_seed: Annotated[int, typer.Option(help="The first of them.", min=0)] = 0,
    criterion: Annotated[
        list[str] | None, typer.Option(help="Criteria to compare; several may follow. (fused)")
    ] = None,
    objective: options.Objective = "relative",
    integrator: options.Integrator = None,
    sensor: options.Sensor = 0,
    size: options.Width = None,
    reference_spp: Annotated[
        int | None, typer.Option(help="Most samples per pixel of the reference. (64 x spp)")
    ] = None,
    output: Annotated[Path | None, typer.Option("--output", "-o", help="Folder for page, tables and numbers.")] = None,
    overwrite: options.Overwrite = False,
    quiet: options.Quiet = False,
) -> None:
    """Measure adaptive against uniform sampling and plain mi.render, by a high-spp reference that is kept for later.

    The same as a study of these scenes, see tracer study.

    Example: tracer compare scene.xml --spp 16 64
    """
    from tracer.study.plan import make_plan
    from tracer.study.toml_location import Origin

    spps = spp or [64]
    scene_settings = {"sensor": sensor} | ({"integrator": integrator} if integrator else {})
    criteria = list(dict.fromkeys(["uniform", *(criterion or ["fused"])]))
    plan = make_plan(
        {
            "name": plan_name(scenes),
            "size": size,
            "spp": spps,
            "seeds": seeds,
            "first_seed": first_seed,
            "reference_spp": max(REFERENCE_FACTOR * max(spps), 16) if reference_spp is None else reference_spp,
            "scenes": [{"path": str(scene), **scene_settings} for scene in scenes],
            "methods": [
                *({"name": name, "criterion": name, "objective": objective, "guide": None} for name in criteria),
                *({"name": f"mi.render {name}", "sampler": name, "objective": objective} for name in STOCK),
            ],
        },
        Origin("compare"),
    )
    from tracer.cli.study import measure

    if output is not None:
        measure(plan, output, overwrite, quiet)
        return
    with tempfile.TemporaryDirectory() as folder:
        measure(plan, Path(folder), overwrite, quiet)


def plan_name(scenes: list[Path]) -> str:
    """Return a name for the study that is different for every set of scenes, because a folder holds only one study."""
    from tracer.study.plan import scene_name

    return re.sub(r"[^\w.+() -]", "_", f"compare {' '.join(scene_name(scene) for scene in scenes)}")

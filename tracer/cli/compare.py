"""Command ``compare``."""

from __future__ import annotations

import re
import shlex
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from tracer.cli import options

if TYPE_CHECKING:
    from tracer.study.results import Results

REFERENCE_FACTOR = 64
"""Largest number of samples of a reference, as a multiple of the largest budget, unless it is given."""
WIDTH = 320
"""Largest width of the pictures, in pixels, unless a size is given: a reference of a large picture takes hours."""
STOCK = ("independent", "multijitter")
"""Samplers with which plain ``mi.render`` is measured."""


def compare(
    scenes: Annotated[list[Path], typer.Argument(help="Mitsuba scene files (XML).", show_default=False)],
    spp: Annotated[list[int] | None, typer.Option(help="Mean samples per pixel; several may follow. [64]")] = None,
    seeds: Annotated[int, typer.Option(help="How many seeds.", min=1)] = 5,
    first_seed: Annotated[int, typer.Option(help="The first of them.", min=0)] = 0,
    criterion: Annotated[
        list[str] | None,
        typer.Option(help="A name below, or your own Python file; may be repeated. (fused)", metavar="NAME"),
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

    The same as a study of these scenes, see tracer study. It ends with what
    you would gain in samples and in time, and the command to use.

    Example: tracer compare scene.xml --spp 16 64
    """
    from tracer.cli.progress import steps
    from tracer.criteria import name_of
    from tracer.study.plan import make_plan
    from tracer.study.toml_location import Origin

    spps = spp or [64]
    scene_settings = {"sensor": sensor} | ({"integrator": integrator} if integrator else {})
    with steps(quiet) as progress:
        progress.begin("Starting Mitsuba")
        sizes = {scene: size or smaller_width(scene, sensor) for scene in scenes}
    if not quiet and (smaller := {str(width) for width in sizes.values() if width and not size}):
        typer.echo(f"Pictures are {' or '.join(smaller)} pixels wide; --size chooses another width, and takes longer.")
    criterion_files = {name_of(name): name for name in criterion or ["fused"]}
    criteria = list(dict.fromkeys(["uniform", *criterion_files]))
    plan = make_plan(
        {
            "name": plan_name(scenes),
            "spp": spps,
            "seeds": seeds,
            "first_seed": first_seed,
            "reference_spp": max(REFERENCE_FACTOR * max(spps), 16) if reference_spp is None else reference_spp,
            "scenes": [{"path": str(scene), "size": sizes[scene], **scene_settings} for scene in scenes],
            "methods": [
                *({"name": name, "criterion": name, "objective": objective, "guide": None} for name in criteria),
                *({"name": f"mi.render {name}", "sampler": name, "objective": objective} for name in STOCK),
            ],
        },
        Origin("compare"),
    )
    from tracer.cli.study import measure

    if output is not None:
        results = measure(plan, output, overwrite, quiet)
    else:
        with tempfile.TemporaryDirectory() as folder:
            results = measure(plan, Path(folder), overwrite, quiet)
    if quiet:
        return
    given = {"--integrator": integrator, "--sensor": sensor or None, "--size": size}
    given["--objective"] = None if objective == "relative" else objective
    chosen_options = [text for name, value in given.items() if value is not None for text in (name, str(value))]
    for scene, sentence in verdicts(results, scenes, criterion_files, chosen_options):
        typer.echo(f"\n{sentence}; use: tracer render {scene}")


def smaller_width(scene: Path, sensor: int) -> int | None:
    """Return the width at which a scene is compared; None for that of its film, or if there is no such film."""
    from tracer.core import backend
    from tracer.errors import SceneError

    backend.activate()
    from tracer.scene.film_width import film_width

    try:
        width = film_width(scene, sensor)
    except SceneError:
        return None  # the study says what is wrong
    return WIDTH if width is not None and width > WIDTH else None


def verdicts(
    results: Results, scenes: list[Path], criterion_files: dict[str, str], chosen_options: list[str]
) -> Iterator[tuple[str, str]]:
    """Yield, for each scene at its largest budget, the rest of a command that renders it best, and why in a clause.

    ``criterion_files``: what the person wrote, by name of the criterion; ``chosen_options``: further options.
    """
    from tracer.study import verdict
    from tracer.study.plan import scene_name
    from tracer.study.tables import measured

    spp = max(results.plan.spp)
    rows, _ = results.tables()
    for scene in scenes:
        of_scene = [row for row in rows if (row.scene, row.budget) == (scene_name(scene), f"{spp} spp")]
        row = verdict.best([row for row in of_scene if row.method in criterion_files])
        if row is not None:
            name = criterion_files[row.method] if verdict.pays(row) else verdict.UNIFORM
            chosen = [] if name == "fused" else ["--criterion", name]
            words = [str(scene), "--spp", str(spp), *chosen, *chosen_options]
            yield shlex.join(words), verdict.in_words(row, measured(results.plan))


def plan_name(scenes: list[Path]) -> str:
    """Return a name for the study that is different for every set of scenes, because a folder holds only one study."""
    from tracer.study.plan import scene_name

    return re.sub(r"[^\w.+() -]", "_", f"compare {' '.join(scene_name(scene) for scene in scenes)}")

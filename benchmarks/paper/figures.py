"""Pictures of patches lit in all ways (the paper, figures 11 and 12), and gains by depth."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from benchmarks import harness
from benchmarks.paper import few_rays, methods
from benchmarks.radiosity.convergence import Gathered, Place
from benchmarks.radiosity.figures import lit, picture, toned
from tracer.radiosity.lattice import evenly, randomly

FEW, FEWEST = 256, 32
"""Rays a patch of the pictures, and of those with few rays."""
STYLES: dict[tuple[bool, bool], dict[str, Any]] = {
    (right, free): {"color": "tab:blue" if right else "tab:red", "linestyle": "--" if free else "-", "marker": "."}
    for right in (False, True)
    for free in (False, True)
}
"""How gains of the paper's rules are drawn, by whether energies are made right and whether looks are free."""


def draw_depths(rows: Sequence[dict[str, Any]], path: Path) -> None:
    """Draw gains over random rays for every scene and number of rays, those of the paper's rules by depth."""
    scenes, counts = (list(dict.fromkeys(row[key] for row in rows)) for key in ("scene", "rays"))
    with harness.figure(path, 2.5 * len(scenes), 3.2 * len(counts) + 0.5, dpi=90) as figure:
        axes = figure.subplots(len(counts), len(scenes), squeeze=False, sharex=True, sharey=True)
        for line, rays in enumerate(counts):
            for column, scene in enumerate(scenes):
                some = {row["method"]: row["gain"][0] for row in rows if (row["scene"], row["rays"]) == (scene, rays)}
                draw_gains(axes[line, column], some)
                axes[line, column].set_title(f"{scene}, {rays} rays", fontsize=9)
            axes[line, 0].set_ylabel("gain over random rays")
        for axis in axes[-1]:
            axis.set_xlabel("depth")
        handles, labels = axes[-1, -1].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=len(labels), fontsize=8)


def draw_gains(axis: Axes, gains: dict[str, float]) -> None:
    """Draw the gains of a scene, which are given by method."""
    axis.axhline(1, color="black", lw=1, label=methods.CLASSICAL)
    for name, colour in ((methods.LATTICE, "tab:orange"), (methods.OURS, "tab:green")):
        axis.axhline(gains.get(name, np.nan), color=colour, label=name)
    for (right, free), style in STYLES.items():
        forms = [methods.Published(depth, right, free) for depth in methods.DEPTHS]
        label = ("energies made right" if right else "as printed") + (", looks free" if free else "")
        axis.plot(
            [form.depth for form in forms], [gains.get(form.name, np.nan) for form in forms], label=label, **style
        )
    axis.set_yscale("log")
    axis.set_xticks(methods.DEPTHS)
    axis.yaxis.set_major_locator(LogLocator(subs=(1.0, 3.0)))
    axis.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axis.yaxis.set_minor_formatter(NullFormatter())


def draw_ways(place: Place, are_looks_free: bool, path: Path) -> None:
    """Draw patches lit by few rays in all ways, by the paper's rules with all depths, and by many rays."""
    others = {
        methods.CLASSICAL: methods.plain(place, randomly, FEW, 0),
        methods.LATTICE: methods.plain(place, evenly, FEW, 0),
        methods.OURS: methods.by_ours(place, FEW, 0),
    }
    guides = {depth: methods.looked(place, depth, 0) for depth in methods.DEPTHS}
    forms = [methods.Published(depth, right, are_looks_free) for right in (False, True) for depth in methods.DEPTHS]
    results = {form.name: methods.by_rules(place, form, guides[form.depth], FEW, 0) for form in forms}
    columns = max(len(methods.DEPTHS), len(others) + 1)
    with harness.figure(path, 3.3 * columns, 11.4, dpi=80) as figure:
        axes = figure.subplots(3, columns)
        for axis in axes.ravel():
            axis.set_axis_off()
        for axis, (name, result) in zip(axes[0], others.items(), strict=False):
            draw_result(axis, place, name, result)
        draw_many(axes[0, len(others)], place)
        for axis, (name, result) in zip(axes[1:, : len(methods.DEPTHS)].ravel(), results.items(), strict=True):
            draw_result(axis, place, name, result)


def draw_few(place: Place, path: Path) -> None:
    """Draw patches lit by very few rays: of a kind of random rays each, of a lattice, and by the paper's rules."""
    look = next(look for look in few_rays.LOOKS if look.depth == 1 and look.look == few_rays.KNOWN)
    guide = few_rays.looked(place, look, 0)
    results = {
        few_rays.UNIFORM: methods.plain(place, few_rays.uniformly, FEWEST, 0),
        few_rays.COSINE: methods.plain(place, randomly, FEWEST, 0),
        methods.LATTICE: methods.plain(place, evenly, FEWEST, 0),
        f"as printed, {look.name}": few_rays.by_rules(place, look, guide, False, FEWEST, 0),
        f"energies right, {look.name}": few_rays.by_rules(place, look, guide, True, FEWEST, 0),
    }
    with harness.figure(path, 13, 9.2, dpi=80) as figure:
        axes = figure.subplots(2, 3).ravel()
        for axis, (name, result) in zip(axes, results.items(), strict=False):
            draw_result(axis, place, name, result)
        draw_many(axes[-1], place)
        for axis in axes:
            axis.set_axis_off()


def draw_result(axis: Axes, place: Place, name: str, result: Gathered | None) -> None:
    """Draw the patches in the light of a result, or say that there is none."""
    if result is None:
        axis.set_title(f"{name}:\nlooks take too many rays", fontsize=10)
        return
    error = float(np.sqrt(np.mean((result.irradiance - place.truth) ** 2)) / place.truth.mean())
    axis.imshow(toned(picture(place, lit(place, result.irradiance)), lit(place, place.truth)))
    axis.set_title(f"{name}:\n{result.rays:.0f} rays a patch, error {error:.3f}", fontsize=10)


def draw_many(axis: Axes, place: Place) -> None:
    """Draw the patches in the light of many rays."""
    truth = lit(place, place.truth)
    axis.imshow(toned(picture(place, truth), truth))
    axis.set_title("many rays", fontsize=10)

"""Curves of convergence, and pictures of patches."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import mitsuba as mi
import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from benchmarks import harness
from benchmarks.radiosity.convergence import RAYS, Curve, Place
from tracer.core.arrays import Floats
from tracer.core.device import upload
from tracer.image.colour import encode_srgb

SHOWN = ("evenly", "each for itself, strata", "distinct, strata", "distinct, warp", "entropy, warp", "deviation, warp")
"""Names of the methods whose curves are drawn."""
TICKS, WIDE = (1.0, 2.0, 5.0), 50
"""Where an axis has labels in each decade, unless its ends have a ratio of more than ``WIDE``: then at its powers."""


RAYS_LABEL = "rays a point"
"""Label of the axis of rays."""


def draw_curves(curves: list[Curve], path: Path) -> None:
    """Draw error against rays and against time, for every scene, with the range over seeds."""
    scenes = list(dict.fromkeys(curve.scene for curve in curves))
    with harness.figure(path, 3.2 * len(scenes), 6.4, dpi=90) as figure:
        axes = figure.subplots(2, len(scenes), squeeze=False)
        for column, scene in enumerate(scenes):
            for name in SHOWN:
                scene_curves = [curve for curve in curves if curve.scene == scene and curve.method == name]
                draw_errors(axes[0, column], RAYS_LABEL, [curve.traced for curve in scene_curves], scene_curves)
                draw_errors(axes[1, column], "seconds", [curve.seconds for curve in scene_curves], scene_curves)
            axes[0, column].set_title(scene)
        axes[0, 0].set_ylabel("relative error")
        axes[1, 0].set_ylabel("relative error")
        axes[0, 0].legend(fontsize=7)


def draw_errors(axis: Axes, label: str, along: list[float], curves: list[Curve]) -> None:
    """Draw the mean error of a method over seeds, and its range; ``along``: the cost of each curve."""
    name = curves[0].method
    errors = np.sqrt(np.array([curve.errors for curve in curves]))
    style: dict[str, Any] = {"color": "black", "linestyle": "--"} if name == "evenly" else {}
    axis.loglog(along, errors.mean(axis=1), marker=".", label=name, **style)
    axis.fill_between(along, errors.min(axis=1), errors.max(axis=1), alpha=0.2, lw=0, color=style.get("color"))
    axis.set_xlabel(label)
    for along_axis in (axis.xaxis, axis.yaxis):
        first, last = along_axis.get_view_interval()
        along_axis.set_major_locator(LogLocator(subs=TICKS if last < WIDE * first else (1.0,)))
        along_axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        along_axis.set_minor_formatter(NullFormatter())
    if label == RAYS_LABEL:
        axis.set_xticks(RAYS, [str(count) for count in RAYS])


def lit(place: Place, irradiance: Floats) -> Floats:
    """Return the radiosity (P, 3) of patches from the irradiance (N, 3) of the patches that do not emit."""
    radiosity = place.patches.emitted.copy()
    dark = place.patches.emitted.max(axis=1) == 0
    radiosity[dark] = place.patches.albedo[dark] * irradiance
    return radiosity


def picture(place: Place, radiosity: Floats) -> Floats:
    """Return a picture (H, W, 3) of the patches by the camera of the scene."""
    sensor = place.example.scene.sensors()[0]
    width, height = sensor.film().size()
    subpixels = 4
    across, down = ((np.arange(count * subpixels) + 0.5) / (count * subpixels) for count in (width, height))
    x, y = (upload(mi.Float, coordinates) for coordinates in np.meshgrid(across, down))
    ray, _ = sensor.sample_ray(0, 0.5, mi.Point2f(x, y), mi.Point2f(0.5, 0.5))
    _, radiance = place.patches.see(radiosity)(mi.Ray3f(ray.o, ray.d))
    rgb: Floats = np.array(radiance, np.float64).T.reshape(height, subpixels, width, subpixels, 3).mean(axis=(1, 3))
    return rgb


def toned(rgb: Floats, truth: Floats) -> Floats:
    """Return a picture for the screen, with the exposure that suits ``truth``, so that pictures are comparable."""
    exposure = 0.12 * np.pi / max(float(np.median(truth[truth > 0])), 1e-30)
    return np.clip(encode_srgb(rgb * exposure), 0, 1)

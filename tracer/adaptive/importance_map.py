"""Weights of what the person wants more of, from a mask or weight image and for shapes; they multiply importance."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import mitsuba as mi
import numpy as np
from skimage.transform import resize

from tracer.complexity import pilot
from tracer.core.arrays import Floats
from tracer.core.device import number_of_shape, upload
from tracer.core.wording import Tell, silent
from tracer.errors import ScoreError, SettingsError
from tracer.io.images import read_values
from tracer.scene.shape_names import find_shapes
from tracer.scene.view import View
from tracer.settings import Settings


def importance_weights(
    view: View, settings: Settings, sampler: Any, importance: Any = None, remark: Tell = silent
) -> Floats:
    """Return the weights (grid) by which importance is multiplied, >= 0 and not zero everywhere.

    ``importance``: an array (H, W) in place of the file that ``settings`` name; ``remark`` is told if it was scaled.
    Raises SettingsError.
    """
    weights = np.ones(view.grid)
    if importance is None and settings.importance is not None:
        importance = read_image(settings.importance)
    if importance is not None:
        values = check_image(importance)
        if values.shape != view.size:
            sizes = [f"{width} x {height}" for height, width in (values.shape, view.size)]
            remark(f"The importance is {sizes[0]} pixels and the picture {sizes[1]}: it was scaled.")
        weights = weights * on_grid(view, values)
    if settings.shape_weights:
        table = weight_table(view, settings.shape_weights)
        weights = weights * pilot.mean_over_shapes(view, sampler, settings.seed, settings.pilot_rays, table)
    if not weights.any():
        name = "shape_weights" if importance is None else "importance"
        raise SettingsError(f"{name}: nothing is wanted, it is zero in every pixel; mark what matters with 1.")
    return weights


def read_image(path: str) -> Floats:
    """Return the values (H, W) of an image file as they are stored, the mean of its colours. Raises SettingsError."""
    try:
        return read_values(Path(path))
    except ScoreError as error:
        raise SettingsError(f"importance: {error}") from None


def check_image(importance: Any) -> Floats:
    """Return an importance image as floats (H, W) >= 0. Raises SettingsError if it is no such image."""
    try:
        values = np.asarray(importance, np.float64)
    except (TypeError, ValueError):
        raise SettingsError(f"importance: must be an image of numbers, not {type(importance).__name__}.") from None
    if values.ndim == 3:
        values = values.mean(axis=-1)
    if values.ndim != 2 or values.size == 0:
        raise SettingsError(f"importance: must be an image (height, width), not of shape {values.shape}.")
    if not np.all(np.isfinite(values)) or values.min() < 0:
        raise SettingsError("importance: every pixel must be finite and not negative.")
    return values


def on_grid(view: View, values: Floats) -> Floats:
    """Return an image (H, W) scaled to the picture, with its edge repeated over the border of the film (grid)."""
    if values.shape != view.size:
        values = np.maximum(resize(values, view.size, order=1, anti_aliasing=True), 0.0)
    return np.pad(values, view.border, mode="edge")


def weight_table(view: View, weights: dict[str, float]) -> Any:
    """Return the weights of shapes (mi.Float), at Mitsuba's numbers of the shapes; 1 for shapes that are not named.

    ``weights``: by a name of the shape, see ``find_shapes``. Raises SettingsError.
    """
    numbered = [
        (number_of_shape(shape), weights[name])
        for name, shapes in find_shapes(view.scene, list(weights)).items()
        for shape in shapes
    ]
    table = np.ones(max(number for number, _ in numbered) + 1)
    for number, weight in numbered:
        table[number] *= weight
    return upload(mi.Float, table)

"""The pictures of a page as images in it, small enough together, and what the viewer needs to know of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from tracer.study.page.encode import (
    HEADROOM,
    count_codes,
    error_codes,
    image_url,
    picture_codes,
    picture_values,
    reduce,
    srgb_curve,
)
from tracer.study.page.scene import ScenePictures
from tracer.study.panels import relative_error
from tracer.study.records import SceneFacts
from tracer.study.results import Results

MOST_BYTES = 1200 * 2**10
"""Most bytes of all images of a page together, if PICTURE_BYTES does not allow more; they shrink until they fit."""
PICTURE_BYTES = 20 * 2**10
"""Bytes that each picture by a method may take with its maps, however many there are."""
TOP_SHARE = 0.99
"""Share of the baseline's pixels whose error is below the top of the scale of colours of the error maps."""


@dataclass(frozen=True)
class Source:
    """An image in the page, from which the viewer reads its pixels, and which print shows."""

    id: str
    kind: str
    """"picture", "error" or "samples": how codes become colours."""
    url: str
    caption: str


@dataclass(frozen=True)
class EncodedScene:
    """The images of a scene."""

    sources: list[Source]
    viewer: dict[str, Any]
    """What the viewer needs to know, as values for JSON."""


@dataclass(frozen=True)
class Fineness:
    """How fine the images of a page are."""

    exact: bool
    """Whether the images keep every code; else they are compressed with a loss."""
    coarser: int
    """How many pixels are added to the side of the squares over which pictures are averaged."""
    map_squares: int
    """Side of the squares over which maps are averaged, in pixels of the pictures."""


def fineness(step: int) -> Fineness:
    """Return the step-th choice: first exact, then compressed; then maps and pictures shrink in turn."""
    return Fineness(step == 0, max(step - 1, 0) // 2, 1 + max(step - 1, 0) % 2)


def fit(results: Results, pictures: Sequence[ScenePictures]) -> list[EncodedScene]:
    """Return the images of every scene, as fine as the bytes of a page allow, see ``fineness``."""
    page_size = results.plan.page_size
    factors = [1 if page_size is None else -(-facts.width // page_size) for facts in results.scenes]
    most_bytes = max(MOST_BYTES, PICTURE_BYTES * sum(len(entry.shown) for entry in pictures))
    step = 0
    while (scenes := within(most_bytes, results, pictures, factors, fineness(step))) is None:
        step += 1
    return scenes


def within(
    most_bytes: int,
    results: Results,
    pictures: Sequence[ScenePictures],
    factors: Sequence[int],
    fine: Fineness,
) -> list[EncodedScene] | None:
    """Return the images of every scene, or None as soon as they take more than ``most_bytes`` and could be smaller."""
    scenes: list[EncodedScene] = []
    used = 0
    for k, (entry, facts, factor) in enumerate(zip(pictures, results.scenes, factors, strict=True)):
        scenes.append(encode_scene(k, entry, facts, factor, fine))
        used += sum(len(source.url) for source in scenes[-1].sources)
        if used > most_bytes and fine.coarser < max(facts.width, facts.height):
            return None
    return scenes


def encode_scene(
    index: int, pictures: ScenePictures, facts: SceneFacts, least_factor: int, fine: Fineness
) -> EncodedScene:
    """Return the images of a scene.

    ``least_factor``: pixels along the side of the smallest squares over which pictures are averaged. An error is that
    of the picture as it was rendered, its root mean square over a square of the map.
    """
    factor = min(least_factor + fine.coarser, facts.width, facts.height)
    map_factor = min(factor * fine.map_squares, facts.width, facts.height)
    sources: list[Source] = []

    def add(kind: str, codes: np.ndarray, caption: str) -> str:
        sources.append(Source(f"source-{index}-{len(sources)}", kind, image_url(codes, fine.exact), caption))
        return sources[-1].id

    truth = reduce(pictures.reference, factor)
    errors = [
        np.sqrt(reduce(relative_error(shown.image, pictures.reference) ** 2, map_factor)) for shown in pictures.shown
    ]
    error_top = float(max(np.quantile(errors[0], TOP_SHARE), 1e-6))
    least = float(min(shown.counts.min() for shown in pictures.shown))
    most = float(max(shown.counts.max() for shown in pictures.shown))
    reference = add("picture", picture_codes(truth), "reference")
    images = [add("picture", picture_codes(reduce(shown.image, factor)), shown.method) for shown in pictures.shown]
    error_maps = [
        add("error", error_codes(error, error_top), f"relative error, {shown.method}")
        for shown, error in zip(pictures.shown, errors, strict=True)
    ]
    count_maps = [
        float(shown.counts.flat[0])
        if shown.counts.min() == shown.counts.max()
        else add(
            "samples", count_codes(reduce(shown.counts, map_factor), least, most), f"samples per pixel, {shown.method}"
        )
        for shown in pictures.shown
    ]
    methods = [
        {
            "name": shown.method,
            "image": image,
            "error": error,
            "counts": counts,
            "score": score_text(shown.relative_mse),
        }
        for shown, image, error, counts in zip(pictures.shown, images, error_maps, count_maps, strict=True)
    ]
    viewer = {
        "name": facts.name,
        "width": truth.shape[1],
        "height": truth.shape[0],
        "factor": factor,
        "mapFactor": map_factor,
        "caption": f"{pictures.budget}, seed {pictures.seed}",
        "reference": reference,
        "methods": methods,
        "errorTop": error_top,
        "countRange": [least, most],
    }
    return EncodedScene(sources, viewer)


def score_text(relative_mse: float) -> str:
    """Return the score of a picture as text."""
    return f"relMSE {relative_mse:.3g}"


def decoding() -> dict[str, Any]:
    """Return what the viewer needs to turn codes into values and colours."""
    values = [float(f"{value:.5g}") for value in picture_values(np.arange(256))]
    return {"values": values, "headroom": HEADROOM, "colours": colours().tobytes().hex()}


def colours() -> np.ndarray:
    """Return matplotlib's colour map for errors and counts as 256 x 3 bytes."""
    from matplotlib import colormaps

    return np.rint(colormaps["magma"](np.arange(256))[:, :3] * 255).astype(np.uint8)


def filters() -> dict[str, list[str]]:
    """Return tables for SVG filters that show the codes of each kind as colours, without a script: red, green, blue.

    A table has an entry every five codes, and the filter interpolates.
    """
    codes = np.arange(0, 256, 5)
    shown = srgb_curve(np.minimum(picture_values(codes), 1))
    table = colours() / 255
    by_error = table[np.minimum(np.rint(255 * HEADROOM * (codes / 255) ** 2), 255).astype(int)]
    channels = {"picture": np.stack([shown] * 3, axis=1), "error": by_error, "samples": table[codes]}
    return {kind: [" ".join(f"{v:.3g}" for v in column) for column in rows.T] for kind, rows in channels.items()}

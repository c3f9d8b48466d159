"""Merge checkpoints of one picture, of parts or with different seeds: on a farm, every machine renders some samples."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from tracer.core import backend
from tracer.errors import CheckpointError
from tracer.film import bias
from tracer.film.bias import UnbiasedMean, mean_at_the_end
from tracer.film.estimate import Estimate, Statistics
from tracer.result import Report, Result
from tracer.scene.frame import PlainFrame
from tracer.session import checkpoint
from tracer.session.checkpoint import Checkpoint, differences
from tracer.session.shards import missing
from tracer.session.state import before_of, numbered_arrays, require_shapes, unbiased_of
from tracer.settings import MOST_SPP, make_settings


def merge(paths: Sequence[Path], output: Path | None = None) -> tuple[Result, Checkpoint]:
    """Return the picture of all samples of some checkpoints, every pixel weighted by its counts, and what they share.

    ``output``: checkpoint of all of them to write, for another merge. Raises CheckpointError for checkpoints of
    different pictures, or that hold the same samples.
    """
    start = time.perf_counter()
    if not paths:
        raise CheckpointError("There is nothing to merge; name one checkpoint or more.")
    first = checkpoint.read(paths[0])
    variant = backend.activate(first.identity["variant"])
    if other := differences({"variant": variant}, {"variant": first.identity["variant"]}):
        raise CheckpointError(f"'{paths[0]}' cannot be merged here: {other[0]}.")
    total, means = sums(first), []
    means.append(unbiased_mean(first, total))
    sources, done = list(first.sources), int(first.plain["done"])
    for path in paths[1:]:
        stored = checkpoint.read(path)
        if differing := differences(first.identity, stored.identity, but=("seed",)):
            raise CheckpointError(f"'{path}' is not of the picture of '{paths[0]}': {'; '.join(differing)}.")
        if repeated := [source for source in stored.sources if source in sources]:
            raise CheckpointError(
                f"'{path}' holds samples that are in those before it ({', '.join(repeated)}); "
                "render parts of one picture with --part, or with different seeds."
            )
        estimate = sums(stored)
        means.append(unbiased_mean(stored, estimate))
        total.merge(estimate)
        sources += stored.sources
        done += int(stored.plain["done"])
    unbiased = merged_means(means)
    whole = replace(first, sources=sources, plain={"done": done})
    if output is not None:
        arrays = {f"estimate.{k}": array for k, array in enumerate(total.state())}
        if unbiased is not None:
            arrays |= {f"unbiased.{name}": array for name, array in vars(unbiased).items()}
        checkpoint.write(replace(whole, path=output, arrays=arrays))
    return picture(total, unbiased, whole, time.perf_counter() - start), whole


def unbiased_mean(stored: Checkpoint, total: Estimate) -> tuple[UnbiasedMean | None, Statistics]:
    """Return the unbiased mean of a checkpoint with these sums, None if it has no rounds that decided; and statistics.

    Raises CheckpointError.
    """
    known = total.statistics()
    try:
        require_shapes(stored.arrays, total)
        unbiased = unbiased_of(stored.arrays)
        if unbiased is not None and "drawn" in stored.arrays:  # a merge has no rounds
            chance, is_whole = stored.arrays.get("chance"), "allocation" not in stored.arrays
            unbiased = mean_at_the_end(unbiased, before_of(stored.arrays), known, chance, is_whole)
        return unbiased, known
    except (ValueError, TypeError):
        raise damaged(stored) from None


def damaged(stored: Checkpoint) -> CheckpointError:
    """Return the error of a checkpoint whose entries do not agree."""
    return CheckpointError(f"'{stored.path}' is a damaged checkpoint; render it anew.")


def merged_means(means: list[tuple[UnbiasedMean | None, Statistics]]) -> UnbiasedMean | None:
    """Return the unbiased mean of several renders; None where in none of them a round was decided by samples."""
    if all(unbiased is None for unbiased, _ in means):
        return None
    whole: UnbiasedMean | None = None
    for unbiased, known in means:
        if unbiased is None:  # stopped before anything was decided
            unbiased = UnbiasedMean.nothing(known.count.shape, known.mean.shape[-1]).closed(None, known, None)
        whole = unbiased if whole is None else whole.merged(unbiased)
    return whole


def sums(stored: Checkpoint) -> Estimate:
    """Return the estimate of a checkpoint. Raises CheckpointError."""
    try:
        total = restored(stored, "estimate")
        if "allocation" in stored.arrays and "held_out.0" in stored.arrays:
            total.merge(restored(stored, "held_out"))  # stopped: as in the picture that was made of it
        return total
    except (ValueError, KeyError, TypeError, AttributeError, OverflowError):
        raise damaged(stored) from None


def restored(stored: Checkpoint, name: str) -> Estimate:
    """Return one of the estimates of a checkpoint. Raises ValueError, KeyError."""
    fields: dict[str, Any] = dict(stored.frame)
    kinds = fields.pop("kinds")
    fields |= {name: tuple(fields[name]) for name in ("size", "window")}
    frame, sums = PlainFrame(**fields), numbered_arrays(stored.arrays, name)
    if any(array.shape != (frame.pixel_count,) for array in sums[1:]):  # before memory is asked for
        raise ValueError("these sums are of another number of pixels")
    estimate = Estimate(frame, *kinds)
    estimate.restore(sums)
    return estimate


def picture(total: Estimate, unbiased: UnbiasedMean | None, whole: Checkpoint, seconds: float) -> Result:
    """Return the result of a merged estimate."""
    frame = total.view
    image, stderr = total.develop()
    statistics = total.statistics()
    right = bias.with_lost_light(frame, image, stderr, statistics, unbiased)
    spp = min(max(round(whole.plain["done"] / frame.pixel_count), 1), MOST_SPP)
    chosen = {name: value for name, value in whole.settings.items() if name not in ("min_spp", "max_spp", "pilot_spp")}
    report = Report(make_settings(**{**chosen, "spp": spp, "unbiased": False}), stopped_by="spp")
    report.note(f"Merged: {'; '.join(whole.sources)}.")
    if absent := missing(whole.sources):
        report.note(absent)
    report.describe(frame, statistics, whole.plain["done"], None)
    report.light_given_back = bias.part_of(right - image, image, frame.colour_channels)
    nothing = np.zeros(frame.size, np.float32)
    return Result(
        image=right,
        samples=statistics.count[frame.inner],
        stderr=stderr,
        complexity=nothing,
        importance=nothing,
        cost=statistics.rays[frame.inner],
        noisy=None,
        seen=None,
        channels=list(frame.channels),
        window=frame.window,
        seconds=seconds,
        report=report,
    )

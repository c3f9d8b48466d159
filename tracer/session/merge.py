"""Merge checkpoints of one picture, of parts or with different seeds: on a farm, every machine renders some samples."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from tracer.core import backend
from tracer.core.arrays import Singles
from tracer.denoising.oidn import load as load_denoiser
from tracer.denoising.postprocess import without_noise
from tracer.denoising.refilter import FilterShape
from tracer.errors import CheckpointError
from tracer.film import bias
from tracer.film.bias import UnbiasedMean, mean_at_the_end
from tracer.film.estimate import Estimate, Statistics, require_sums_of
from tracer.film.features import Features
from tracer.report import Report
from tracer.result import Result
from tracer.scene.frame import PlainFrame
from tracer.session import checkpoint
from tracer.session.checkpoint import Checkpoint, differences
from tracer.session.shards import missing
from tracer.session.state import before_of, features_of, numbered_arrays, packed_features, require_shapes, unbiased_of
from tracer.settings import MOST_SPP, make_settings


def merge(paths: Sequence[Path], output: Path | None = None, denoise: bool = False) -> tuple[Result, Checkpoint]:
    """Return the picture of all samples of some checkpoints, every pixel weighted by its counts, and what they share.

    ``output``: checkpoint of all of them to write, for another merge; ``denoise``: whether to take the noise out of the
    picture. Raises CheckpointError for checkpoints of different pictures, or that hold the same samples, and
    DenoiseError without a denoiser.
    """
    start = time.perf_counter()
    if denoise:
        load_denoiser()  # before the work, not after
    if not paths:
        raise CheckpointError("There is nothing to merge; name one checkpoint or more.")
    first = checkpoint.read(paths[0], "leave it out")
    variant = backend.activate(first.identity["variant"])
    if other := differences({"variant": variant}, {"variant": first.identity["variant"]}):
        raise CheckpointError(f"'{paths[0]}' cannot be merged here: {other[0]}.")
    total, means, features, shape = sums(first), [], MeanFeatures(), filter_shape(first)
    means.append(unbiased_mean(first, total))
    features.add(first)
    sources, done = list(first.sources), int(first.plain["done"])
    for path in paths[1:]:
        stored = checkpoint.read(path, "leave it out")
        if differing := differences(first.identity, stored.identity, but=("seed",)):
            raise CheckpointError(f"'{path}' is not of the picture of '{paths[0]}': {'; '.join(differing)}.")
        if repeated := [source for source in stored.sources if source in sources]:
            raise CheckpointError(
                f"'{path}' holds samples that are in those before it ({', '.join(repeated)}); "
                "render parts of one picture with --part, or with different seeds."
            )
        estimate = sums(stored)
        means.append(unbiased_mean(stored, estimate))
        features.add(stored)
        total.merge(estimate)
        sources += stored.sources
        done += int(stored.plain["done"])
    unbiased = merged_means(means)
    whole = replace(first, sources=sources, plain={"done": done})
    if output is not None:
        arrays = {f"estimate.{k}": array for k, array in enumerate(total.state())} | packed_features(features.mean)
        if unbiased is not None:
            arrays |= {f"unbiased.{name}": array for name, array in vars(unbiased).items()}
        checkpoint.write(replace(whole, path=output, arrays=arrays))
    return picture(total, unbiased, whole, (shape, features.mean) if denoise else None, start), whole


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


class MeanFeatures:
    """Mean of what is seen in each pixel over some renders of one picture: other seeds have other rays."""

    def __init__(self) -> None:
        self.totals: dict[str, Singles] = {}
        self.renders = 0

    def add(self, stored: Checkpoint) -> None:
        """Add the features of a checkpoint, which may be a merge of several renders. Raises CheckpointError."""
        try:
            features = features_of(stored.arrays)
        except TypeError:
            features = None
        if features is None:
            raise damaged(stored)
        for name, array in vars(features).items():
            share = np.float32(len(stored.sources)) * array
            self.totals[name] = self.totals[name] + share if self.renders else share
        self.renders += len(stored.sources)

    @property
    def mean(self) -> Features:
        """The mean over all renders."""
        return Features(**{name: total / np.float32(self.renders) for name, total in self.totals.items()})


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
    except (ValueError, LookupError, TypeError, AttributeError, OverflowError):
        raise damaged(stored) from None


def restored(stored: Checkpoint, name: str) -> Estimate:
    """Return one of the estimates of a checkpoint. Raises ValueError, LookupError, TypeError."""
    fields: dict[str, Any] = dict(stored.frame)
    (moments, peaks), _ = fields.pop("kinds"), fields.pop("filter")
    fields |= {name: tuple(fields[name]) for name in ("size", "window")}
    frame, sums = PlainFrame(**fields), numbered_arrays(stored.arrays, name)
    require_sums_of(frame, moments, peaks, sums)  # before memory is asked for
    estimate = Estimate(frame, moments, peaks)
    estimate.restore(sums)
    return estimate


def filter_shape(stored: Checkpoint) -> FilterShape:
    """Return the shape of the film's filter, as a checkpoint has it. Raises CheckpointError."""
    try:
        return FilterShape.from_plain(stored.frame["filter"])
    except (KeyError, TypeError, ValueError):
        raise damaged(stored) from None


def picture(
    total: Estimate,
    unbiased: UnbiasedMean | None,
    whole: Checkpoint,
    denoise_by: tuple[FilterShape, Features] | None,
    start: float,
) -> Result:
    """Return the result of a merged estimate. Raises DenoiseError.

    ``denoise_by``: what denoising needs, None if the picture is to stay noisy; ``start``: when the merge began, by
    ``time.perf_counter``.
    """
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
    report.light_given_back = bias.light_added(right, image, frame.colour_channels)
    noisy = None
    if denoise_by is not None:
        noisy, before = right[..., : frame.colour_channels], time.perf_counter()
        clean = without_noise(frame, *denoise_by, image, statistics)
        right = bias.with_lost_light(frame, clean, stderr, statistics, unbiased)
        report.seconds_denoising = time.perf_counter() - before
    nothing = np.zeros(frame.size, np.float32)
    return Result(
        image=right,
        samples=statistics.count[frame.inner],
        stderr=stderr,
        complexity=nothing,
        importance=nothing,
        cost=statistics.work[frame.inner],
        noisy=noisy,
        seen=None,
        channels=list(frame.channels),
        window=frame.window,
        seconds=time.perf_counter() - start,
        report=report,
    )

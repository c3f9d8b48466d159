"""Evidence from samples that a test makes up."""

import mitsuba as mi
import numpy as np

from tracer import criteria
from tracer.film.estimate import Statistics


def statistics_of(samples, name, channels=3):
    """Return what is known after ``samples`` (N, H, W, C), with the moments of criterion ``name``.

    As in a render, means of moments are from float32 sums, one sample after the other.
    """
    samples = np.asarray(samples, np.float32)
    number, height, width, _ = samples.shape
    moments, peaks = [], []
    asked = criteria.get(name).moments
    for index, sample in enumerate(samples if asked else []):
        colour = [mi.Float(np.ascontiguousarray(sample[..., c]).ravel()) for c in range(channels)]
        means, maxima = asked(colour, mi.UInt32(np.full(height * width, index, np.uint32)))
        moments.append([np.array(each).reshape(height, width) for each in means])
        peaks.append([np.array(each).reshape(height, width) for each in maxima])

    def last(values):
        return np.moveaxis(np.array(values, np.float32), 0, -1) if values else np.zeros((height, width, 0), np.float32)

    exact = samples.astype(np.float64)
    with np.errstate(all="ignore"):
        return Statistics(
            count=np.full((height, width), number, np.uint32),
            invalid=np.zeros((height, width), np.uint32),
            mean=exact.mean(axis=0).astype(np.float32),
            variance=exact.var(axis=0, ddof=min(number - 1, 1)).astype(np.float32),
            work=np.ones((height, width), np.float32),
            moments=last(list(np.add.accumulate(np.array(moments, np.float32))[-1] / np.float32(number)))
            if asked
            else last([]),
            peaks=last(list(np.max(np.array(peaks, np.float32), axis=0))) if asked else last([]),
        )


def evidence_of(known, before=None, channels=3, look=None):
    """Return evidence of a decision in the middle of a render."""
    ones = np.ones(known.count.shape)
    return criteria.Evidence(
        look=look or not_asked,
        statistics=known,
        before=before,
        weight=ones,
        weight_before=ones,
        colour_channels=channels,
        wanted=ones,
    )


def not_asked():
    raise AssertionError("this criterion should not look at pilot rays")


def importance(name, samples, channels=3, **rest):
    """Return the importance (H, W) that criterion ``name`` gives to ``samples`` (N, H, W, C)."""
    known = statistics_of(samples, name, channels)
    return criteria.get(name).importance(evidence_of(known, channels=channels, **rest))


def light(number=9, height=3, width=4, channels=3, seed=0):
    """Return samples (N, H, W, C) as a path tracer finds them: skewed, some black."""
    generator = np.random.default_rng(seed)
    values = generator.lognormal(0, 1.5, (number, height, width, channels))
    return values * (generator.random((number, height, width, 1)) < 0.8)

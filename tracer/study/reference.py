"""Reference pictures: two independent halves, one by plain ``mi.render``, one by our loop, uniform.

Both are uniform, so nothing decides where their samples go, and they share nothing but the scene: samplers, seeds and
estimators differ. A quarter of their squared difference is the squared error of their mean, measured and not assumed.
Halves are kept under a hash of the scene's content and of every setting that changes the picture.
"""

from __future__ import annotations

import hashlib
import os
import warnings
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

import filelock
import mitsuba as mi
import numpy as np
from scipy import stats

from tracer.core.arrays import Floats
from tracer.errors import OutputError, SceneError
from tracer.image import metrics
from tracer.io import atomic
from tracer.progress import CountCallback
from tracer.scene.fingerprint import fingerprint
from tracer.scene.view import View
from tracer.study.methods import Setting, Studio
from tracer.study.reference_half import Half
from tracer.study.uniform import render_uniform

FORMAT = 1
"""Version of kept halves, changed when those of earlier versions must not be used any more."""
FIRST_SEED = 1000003
"""Seed of the first chunk, far from the seeds that are measured."""
SAMPLER = "multijitter"
"""Sampler plugin of the half by ``mi.render``."""
CHUNK_SAMPLES = 2**24
"""Most samples of a chunk, unless that is less than four per pixel."""
LEAST_CHUNKS = 4
"""Least chunks of each half, so that the spread between chunks can be estimated."""
ROUNDING = 1e-5
"""Relative difference between halves that is ignored: without noise, sums in float32 differ by about as much."""
FALSE_ALARM = 1e-3
"""Probability that two halves of the same expectation are said to disagree."""


@dataclass(frozen=True)
class Reference:
    """A picture close enough to the truth to measure others by, in two independent halves."""

    by_mitsuba: Half
    """The half by ``mi.render``."""
    by_tracer: Half
    """The half by our loop."""

    @property
    def image(self) -> Floats:
        """(H, W, 3), linear sRGB: the mean of the halves."""
        return (self.by_mitsuba.mean + self.by_tracer.mean) / 2

    @property
    def spp(self) -> int:
        """Samples per pixel of both halves together."""
        return self.by_mitsuba.spp + self.by_tracer.spp

    @property
    def variance(self) -> Floats:
        """(H, W, 3): variance of one sample of a pixel."""
        return self.by_tracer.variance

    @property
    def squared_error(self) -> Floats:
        """(H, W, 3): an unbiased, noisy estimate of the squared error of ``image``."""
        return (self.by_mitsuba.mean - self.by_tracer.mean) ** 2 / 4

    @property
    def mse(self) -> float:
        """Mean squared error of ``image``."""
        return float(self.squared_error.mean())

    @property
    def relative_mse(self) -> float:
        """The same, relative as in ``metrics.relative_mse``."""
        return float((self.squared_error / metrics.relative_scale(self.image)[..., None]).mean())

    @property
    def disagreement(self) -> float:
        """Least p-value of Welch's t-test between the halves, over all tiles of the picture.

        It is corrected for the number of tiles (Sidak); below FALSE_ALARM the halves do not show the same picture.
        """
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)  # tiles that are nearly without noise
            p = stats.ttest_ind(self.by_mitsuba.tiles, self.by_tracer.tiles, equal_var=False).pvalue
        first, second = (half.tiles.mean(axis=0) for half in (self.by_mitsuba, self.by_tracer))
        p = np.where(np.isfinite(p) & (abs(first - second) > ROUNDING * abs(first + second) / 2), p, 1.0)
        return float(-np.expm1(p.size * np.log1p(-min(p.min(), 1 - 1e-16))))

    @property
    def halves_agree(self) -> bool:
        """Whether the halves show the same picture."""
        return self.disagreement >= FALSE_ALARM


def cache_folder() -> Path:
    """Return the folder of kept references: ``$TRACER_CACHE``, else ``tracer`` in the user's cache folder."""
    home = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(os.environ.get("TRACER_CACHE") or Path(home) / "tracer") / "references"


def cache_key(setting: Setting) -> str:
    """Return the name under which a reference is kept: a hash of scene content, settings and versions."""
    parts = (fingerprint(setting.source), setting.integrator, setting.sensor, setting.size, FORMAT)
    versions = (FIRST_SEED, CHUNK_SAMPLES, mi.variant(), mi.__version__)
    return hashlib.sha256(repr((parts, versions)).encode()).hexdigest()[:24]


def make_reference(setting: Setting, spp: int, progress: CountCallback | None = None) -> Reference:
    """Return a reference of at least ``spp`` samples per pixel; halves that are kept from before are added to.

    Raises KeyboardInterrupt if ``progress`` stops it; the chunks that were finished are kept.
    """
    folder = prepare_cache() / cache_key(setting)
    folder.mkdir(exist_ok=True)
    paths = [folder / "mitsuba.npz", folder / "tracer.npz"]
    with filelock.FileLock(folder / "lock"), ExitStack() as stack:
        halves = [half for path in paths if (half := Half.load(path)) is not None]
        if len(halves) == 2 and next_step(halves, spp) is None:
            return Reference(*halves)
        studio, sampler = open_studio(stack, setting)
        chunk_spp = spp_of_chunk(studio.view.pixel_count)
        halves = [Half.load(path) or Half.empty(chunk_spp, *studio.view.size) for path in paths]
        adders = [by_mitsuba(studio, sampler), by_tracer(studio.view)]
        total = 2 * chunk_spp * max(LEAST_CHUNKS, -(-spp // (2 * chunk_spp)))
        while (step := next_step(halves, spp)) is not None:
            adders[step](halves[step], FIRST_SEED + (0, 10**6)[step] + halves[step].chunks)
            halves[step].save(paths[step])
            if progress is not None and progress(sum(half.spp for half in halves), total) is False:
                raise KeyboardInterrupt
    return Reference(*halves)


def next_step(halves: Sequence[Half], spp: int) -> int | None:
    """Return the index of the half with fewer chunks, which is added to next; None if both together have ``spp``."""
    behind = int(np.argmin([half.chunks for half in halves]))
    enough = halves[behind].chunks >= LEAST_CHUNKS and 2 * halves[behind].spp >= spp
    return None if enough else behind


def prepare_cache() -> Path:
    """Make the folder of kept references and return it. Raises OutputError if it cannot be written in."""
    folder = cache_folder()
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise OutputError(f"Cannot keep references in '{folder}': {error.strerror}; set TRACER_CACHE.") from None
    return atomic.check_folder(folder)


def spp_of_chunk(pixel_count: int) -> int:
    """Return the samples per pixel of a chunk: a power of four up to 1024, which suits stratified samplers best."""
    most_spp = max(CHUNK_SAMPLES // pixel_count, 4)
    return int(min(4 ** ((most_spp.bit_length() - 1) // 2), 1024))


def open_studio(stack: ExitStack, setting: Setting) -> tuple[Studio, str | None]:
    """Return an open scene and its sampler under ``mi.render``: SAMPLER, or None if the scene has none to replace."""
    try:
        return Studio(stack, setting, [SAMPLER]), SAMPLER
    except SceneError:  # no sampler to replace, or an error that the next line raises again
        return Studio(stack, setting), None


def by_mitsuba(studio: Studio, sampler: str | None) -> Callable[[Half, int], None]:
    """Return a function that adds a chunk by ``mi.render``. Raises SceneError for pixels that are not finite."""
    method = studio.stock(sampler)

    def render(half: Half, seed: int) -> None:
        image = method(half.chunk_spp, seed).image
        bad_count = np.count_nonzero(~np.isfinite(image).all(axis=-1))
        if bad_count:
            raise SceneError(
                f"{bad_count} pixels of the reference by mi.render are not finite, so nothing can be scored."
            )
        half.add(image)

    return render


def by_tracer(view: View) -> Callable[[Half, int], None]:
    """Return a function that adds a chunk by our loop with the same number of samples everywhere."""

    def render(half: Half, seed: int) -> None:
        result, statistics = render_uniform(view, half.chunk_spp, seed)
        variance = statistics.variance[view.inner]
        half.add(view.rgb(result.image), np.maximum(view.rgb(variance), 0.0))

    return render

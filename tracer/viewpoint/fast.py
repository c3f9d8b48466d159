"""The fast estimate of viewpoint entropy: from as many random rays as the person wants, with a standard error.

The paper, section 3.2. The entropy of the shares that N rays observe is too low by about (m - 1) / (2 N ln 2) bits for
m surfaces, including those that no ray has hit yet. P. Grassberger's estimate, "Entropy estimates from insufficient
samplings", arXiv:physics/0307138, knows nothing of the latter either, but is off by less. The standard error is
sqrt(Var(log2 p) / N) (G. Basharin, Theory of Probability and its Applications 4, 1959). Surfaces that were hit only
once show that others were not hit at all: as large a share of the correction as they are of the surfaces is added, as
an independent error. Where nearly all surfaces were hit only once, no estimate can tell how many there are, and the
error is larger than the standard error says.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import digamma

from tracer.complexity import measures
from tracer.core.arrays import Floats
from tracer.errors import SettingsError
from tracer.viewpoint.item_buffer import Rays, Viewpoints, projected_areas
from tracer.viewpoint.lens import Lens
from tracer.viewpoint.surfaces import Subject


@dataclass(frozen=True)
class Estimate:
    """Estimates of the entropy of views in bits. All arrays are (V,)."""

    entropy: Floats
    """Entropy, corrected for the bias of few rays."""
    stderr: Floats
    """Standard error of the entropy."""
    uncorrected: Floats
    """Entropy of the observed shares."""
    once: Floats
    """Share of the surfaces seen that a single ray hit; no estimate is good where this is near 1."""
    covered: Floats
    """Share of the rays that hit anything. The entropy is 0 both if it is 0 and if a single surface is seen."""


def estimate_entropy(
    subject: Subject, viewpoints: Viewpoints, lens: Lens, rays: int, seed: int = 0, background: bool = True
) -> Estimate:
    """Return the entropy of each view from ``rays`` random rays.

    Without background, only rays that hit a surface count. Where all rays see the same, one surface or nothing, entropy
    and error are 0, as the rays tell nothing about what they did not see. Raises SettingsError for a subject with
    weights, for which there is no such correction.
    """
    if subject.is_weighted:
        raise SettingsError("Entropy with weights needs a dense grid of rays; leave out --random.")
    rows = []
    for batch in projected_areas(subject, viewpoints, lens, Rays(random=rays, seed=seed)):
        for areas in batch.areas:
            seen = areas[areas > 0].astype(np.float64)
            share = float(seen.sum()) / lens.image_area
            count = rays if background else max(rays * share, 1.0)
            if background:
                seen = np.append(seen, max(lens.image_area - seen.sum(), 0.0))
            rows.append((*estimate(seen, count), share))
    return Estimate(*np.array(rows, np.float64).reshape(-1, 5).T)


def estimate(areas: Floats, count: float) -> tuple[float, float, float, float]:
    """Return (entropy, stderr, uncorrected, once) of ``Estimate`` for observed areas, seen by ``count`` rays."""
    p = measures.probabilities(areas)
    p = p[p > 0]
    if not len(p):
        return 0.0, 0.0, 0.0, 0.0
    surprise = -np.log2(p)
    entropy = float(np.sum(p * surprise))
    variance = max(float(np.sum(p * surprise**2)) - entropy**2, 0.0)
    hits = np.rint(p * count)
    hits = hits[hits > 0]  # a background that no ray hit may have an area left by rounding
    once = float(np.mean(hits <= 1))
    if len(hits) < 2:
        return 0.0, 0.0, entropy, once
    corrected = grassberger(hits)
    return corrected, float(np.hypot(np.sqrt(variance / count), once * (corrected - entropy))), entropy, once


def grassberger(counts: Floats) -> float:
    """Return log2 N - (1/N) sum n G(n) of counts n that sum to N, in bits.

    G(n) = psi(n) + (-1)^n (psi((n + 1) / 2) - psi(n / 2)) / 2: n G(n) stands for n ln n, Grassberger's equation 30.
    """
    n = counts[counts > 0]
    if not len(n):
        return 0.0
    alternating = np.where(n % 2 == 0, 0.5, -0.5) * (digamma((n + 1) / 2) - digamma(n / 2))
    logs = (np.log(n.sum()) - np.sum(n * (digamma(n) + alternating)) / n.sum()) / np.log(2)
    return max(float(logs), 0.0)

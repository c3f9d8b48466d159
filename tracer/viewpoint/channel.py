"""What all views have in common: the information channel between viewpoints V and surfaces Z.

With a_z(v) the projected area of z from v: p(v) = a_t(v) / sum a_t, p(z|v) = a_z(v) / a_t(v), p(z) = sum_v p(v) p(z|v),
p(v|z) = a_z(v) / sum_v a_z(v). M. Feixas, M. Sbert and F. Gonzalez, "A unified information-theoretic framework for
viewpoint selection and mesh saliency", ACM Transactions on Applied Perception 6(1), 2009. Only sums over views are
kept, so that memory does not grow with the number of views.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from tracer.complexity import measures
from tracer.core.arrays import Floats, Integers
from tracer.viewpoint.surfaces import Mesh

ROUNDING = 1e-12
"""A divergence of at most this many bits is taken for 0: what rounding leaves of 0 is less."""


def times_log(values: NDArray) -> Floats:
    """Return x log2 x of values x >= 0, which is 0 at 0."""
    values = np.asarray(values, np.float64)
    return values * np.log2(values, out=np.zeros_like(values), where=values > 0)


@dataclass
class Channel:
    """Sums over views of projected areas a and of a log2 a."""

    sums: Floats
    """(Z,): sum over views of a_z."""
    sums_of_logs: Floats
    """(Z,): sum over views of a_z log2 a_z."""
    totals: list[float]
    """a_t of every view."""
    pairs: Integers
    """(E, 2): pairs of surfaces that share an edge; E is 0 unless saliency is asked for."""
    pair_logs: Floats
    """(E,): sum over views of (a_y + a_z) log2 (a_y + a_z)."""

    def add(self, areas: NDArray) -> None:
        """Add the projected areas (B, Z) of B views."""
        for view_areas in areas.astype(np.float64):
            self.sums += view_areas
            self.sums_of_logs += times_log(view_areas)
            self.totals.append(float(view_areas.sum()))
            if len(self.pairs):
                self.pair_logs += times_log(view_areas[self.pairs[:, 0]] + view_areas[self.pairs[:, 1]])

    @cached_property
    def surface_entropy(self) -> float:
        """H(Z) in bits."""
        return float(measures.entropy(self.sums))

    @cached_property
    def view_entropy(self) -> float:
        """H(V) in bits."""
        return float(measures.entropy(np.array(self.totals)))

    @cached_property
    def entropy_of_views(self) -> Floats:
        """(Z,): H(V|z) in bits, log2 S - (1/S) sum a log2 a with S = sum a; 0 for a surface that no view sees."""
        return mean_logs(self.sums, self.sums_of_logs)

    @cached_property
    def saliency(self) -> Floats:
        """(Z,): how differently from its neighbours a surface is seen, in bits, 0 to 1.

        S(z) is the mean over surfaces y that share an edge with z of the Jensen-Shannon divergence of p(V|z) and
        p(V|y), weighted by p(z) and p(y) (Feixas and others, equation 21). It is 0 without neighbours.
        """
        if not len(self.pairs):
            return np.zeros_like(self.sums)
        y, z = self.pairs.T
        joint = self.sums[y] + self.sums[z]
        separate = self.sums[y] * self.entropy_of_views[y] + self.sums[z] * self.entropy_of_views[z]
        mean_separate = np.divide(separate, joint, out=np.zeros_like(separate), where=joint > 0)
        divergence = mean_logs(joint, self.pair_logs) - mean_separate
        divergence = np.where(divergence > ROUNDING, divergence, 0.0)
        count = np.bincount(self.pairs.ravel(), minlength=len(self.sums))
        total = np.bincount(self.pairs.ravel(), np.repeat(divergence, 2), len(self.sums))
        return total / np.maximum(count, 1)


def mean_logs(sums: Floats, logs: Floats) -> Floats:
    """Return log2 S - L / S, at least 0, of ``sums`` S and ``logs`` L; 0 where S is 0."""
    seen = sums > 0
    safe = np.where(seen, sums, 1.0)
    return np.where(seen, np.maximum(np.log2(safe) - logs / safe, 0.0), 0.0)


def new_channel(surfaces: int, pairs: Integers | None = None) -> Channel:
    """Return a channel without views; ``pairs`` (E, 2): surfaces that are compared for their saliency."""
    pairs = np.zeros((0, 2), np.int64) if pairs is None else pairs
    return Channel(np.zeros(surfaces), np.zeros(surfaces), [], pairs, np.zeros(len(pairs)))


def adjacent(mesh: Mesh) -> Integers:
    """Return the pairs (E, 2) of different surfaces with triangles at the same edge, each pair once.

    More than two surfaces may share an edge.
    """
    corners = mesh.joined
    edges = np.sort(np.stack([corners, np.roll(corners, -1, axis=1)], axis=-1).reshape(-1, 2), axis=1)
    rows = np.column_stack([edges, np.repeat(mesh.surface, 3)])
    rows = rows[np.lexsort(rows.T[::-1])]
    rows = rows[np.any(np.diff(rows, axis=0, prepend=-1) != 0, axis=1)]  # each surface is listed once at each edge
    pairs = [np.zeros((0, 2), np.int64)]
    for step in range(1, len(rows)):
        same = np.all(rows[step:, :2] == rows[:-step, :2], axis=1)
        if not same.any():  # no edge has more than ``step`` surfaces
            break
        pairs.append(np.stack([rows[:-step, 2][same], rows[step:, 2][same]], axis=-1))
    return np.unique(np.concatenate(pairs), axis=0)

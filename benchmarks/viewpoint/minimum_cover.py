"""The smallest set of views, found exactly, by which greedy view sets are judged."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import Bounds, LinearConstraint, milp
from scipy.sparse import csr_matrix, hstack, identity

from tracer.core.arrays import Floats, Integers


@dataclass(frozen=True)
class Fewest:
    """The smallest set of views that was found, and a bound."""

    chosen: Integers
    """(N,): numbers of the views; empty if no set was found in time."""
    least: int
    """Lower bound for the size of a set; it is the size of ``chosen`` if the search was completed."""


def fewest_views(shown: NDArray[np.bool_], weights: Floats, enough: float = 1.0, seconds: float = 60.0) -> Fewest:
    """Return the fewest views that show a share ``enough`` of the weight of surfaces, by integer programming.

    ``shown`` (V, Z): whether each view shows each surface well; ``weights`` (Z,): true areas. ``seconds``: limit of
    time. With x_v = 1 if view v is taken, and y_z <= 1 how far surface z is shown, it minimises sum x_v such that
    y_z <= sum of x_v over the views that show z, and sum w_z y_z >= enough sum w_z. Surfaces that the same views show
    are merged.
    """
    seen = shown.any(axis=0) & (weights > 0)
    patterns, group = np.unique(shown[:, seen], axis=1, return_inverse=True)
    pattern_weights = np.bincount(group.reshape(-1), weights[seen])
    views, pattern_count = patterns.shape
    if not pattern_count:
        return Fewest(np.zeros(0, np.int64), 0)
    cover_constraint = hstack([csr_matrix(patterns.T.astype(float)), -identity(pattern_count)], format="csr")
    weight_constraint = csr_matrix(np.concatenate([np.zeros(views), pattern_weights / pattern_weights.sum()])[None])
    solution = milp(
        np.concatenate([np.ones(views), np.zeros(pattern_count)]),
        integrality=np.concatenate([np.ones(views), np.zeros(pattern_count)]),
        bounds=Bounds(0, 1),
        constraints=[
            LinearConstraint(cover_constraint, 0, np.inf),
            LinearConstraint(weight_constraint, enough - 1e-9, np.inf),
        ],
        options={"time_limit": seconds},
    )
    bound = 0.0 if solution.mip_dual_bound is None else float(solution.mip_dual_bound)
    chosen = np.zeros(0, np.int64) if solution.x is None else np.flatnonzero(solution.x[:views] > 0.5)
    return Fewest(chosen, int(np.ceil(bound - 1e-6)))

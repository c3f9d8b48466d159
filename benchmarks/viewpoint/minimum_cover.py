"""The fewest views there can be: the exact answer that a greedy view set is judged by."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import Bounds, LinearConstraint, milp
from scipy.sparse import csr_matrix, hstack, identity

from tracer.core.arrays import Floats

Integers = NDArray[np.int64]


@dataclass(frozen=True)
class Fewest:
    """A smallest set of views."""

    chosen: Integers
    """(N,): numbers of the views; empty if none was found in time."""
    least: int
    """No set is smaller than this: the size of ``chosen`` if the search came to its end."""


def fewest_views(shown: NDArray[np.bool_], weights: Floats, enough: float = 1.0, seconds: float = 60.0) -> Fewest:
    """Return the fewest views that show a share ``enough`` of the weight of surfaces, by integer programming.

    ``shown`` (V, Z): which view shows which surface well; ``weights`` (Z,): true areas. With x_v = 1 if view v is
    taken and y_z <= 1 how far surface z is shown: least sum x_v such that y_z <= sum of x_v over views that show z, and
    sum w_z y_z >= enough sum w_z. Surfaces that the same views show are one.
    """
    seen = shown.any(axis=0) & (weights > 0)
    patterns, group = np.unique(shown[:, seen], axis=1, return_inverse=True)
    mass = np.bincount(group.reshape(-1), weights[seen])
    views, count = patterns.shape
    if not count:
        return Fewest(np.zeros(0, np.int64), 0)
    covers = hstack([csr_matrix(patterns.T.astype(float)), -identity(count)], format="csr")
    total = csr_matrix(np.concatenate([np.zeros(views), mass / mass.sum()])[None])
    solution = milp(
        np.concatenate([np.ones(views), np.zeros(count)]),
        integrality=np.concatenate([np.ones(views), np.zeros(count)]),
        bounds=Bounds(0, 1),
        constraints=[LinearConstraint(covers, 0, np.inf), LinearConstraint(total, enough - 1e-9, np.inf)],
        options={"time_limit": seconds},
    )
    bound = 0.0 if solution.mip_dual_bound is None else float(solution.mip_dual_bound)
    chosen = np.zeros(0, np.int64) if solution.x is None else np.flatnonzero(solution.x[:views] > 0.5)
    return Fewest(chosen, int(np.ceil(bound - 1e-6)))

"""The ways in which the rays of patches can be spread over their hemispheres, by name."""

from __future__ import annotations

from dataclasses import replace
from typing import Literal

from tracer.core.wording import option
from tracer.errors import SettingsError
from tracer.radiosity.guide import Guidance
from tracer.radiosity.paper import PaperRules

RANDOMLY: Literal["randomly"] = "randomly"
"""Independent random rays, as in classical Monte Carlo radiosity."""
Spread = Guidance | PaperRules | Literal["randomly"] | None
"""Guided rays, rays by the paper's rules, random ones, or, for None, those of a lattice, which are evenly spread."""
SPREADS: dict[str, Spread] = {
    "guided": Guidance(),
    "evenly": None,
    "randomly": RANDOMLY,
    "paper": PaperRules(),
    "paper_right": PaperRules(right=True),
}
"""All of them by the names by which a person chooses."""
METHODS = ("gathering", "shooting")
"""The ways in which radiosity is solved."""
MOST_DEPTH = 4
"""Largest number of times that a part of a hemisphere is split by the paper's rules."""


def usual_spread(method: str) -> str:
    """Return the name of the way to spread rays that is taken if none is chosen."""
    return "evenly" if method == "shooting" else "guided"


def chosen_spread(name: str, method: str, threshold: float | None = None, depth: int | None = None) -> Spread:
    """Return how rays are spread that gather or shoot.

    ``threshold``, ``depth``: see ``PaperRules``; None: the defaults. Raises SettingsError.
    """
    if method not in METHODS:
        hint = f"; '{method}' is a way to spread rays: {option('spread', method)}" if method in SPREADS else ""
        raise SettingsError(f"method is one of {', '.join(METHODS)}, not '{method}'{hint}.")
    if name not in SPREADS:
        raise SettingsError(f"spread is one of {', '.join(SPREADS)} (was {name}).")
    if name == "guided" and method == "shooting":
        raise SettingsError("Rays that shoot cannot be guided, as no light is known yet; choose another spread.")
    spread = SPREADS[name]
    if not isinstance(spread, PaperRules):
        if threshold is not None or depth is not None:
            raise SettingsError(f"threshold and depth are for the paper's rules, and spread is {name}.")
        return spread
    chosen = replace(
        spread,
        threshold=spread.threshold if threshold is None else threshold,
        depth=spread.depth if depth is None else depth,
    )
    if not 0 <= chosen.threshold < float("inf") or not 0 <= chosen.depth <= MOST_DEPTH:
        raise SettingsError(f"threshold must not be negative, and depth is from 0 to {MOST_DEPTH}.")
    return chosen

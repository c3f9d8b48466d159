"""One picture in parts, without a cluster: each part is a render of its own, with other samples and a share of them.

Parts share nothing: each decides by what it has seen itself. ``tracer merge`` makes one picture of their checkpoints,
every pixel weighted by its counts.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from tracer.errors import SettingsError
from tracer.settings import Settings

MOST_PARTS = 2**16


@dataclass(frozen=True)
class Part:
    """Part ``number``, from 1, of ``total``."""

    number: int
    total: int

    def source(self, seed: int) -> str:
        """Return what the samples of this part are called in a checkpoint."""
        return f"seed {seed}, part {self.number} of {self.total}"


def parse_part(text: str) -> Part:
    """Return a part from "3/8". Raises ValueError."""
    match = re.fullmatch(r"\s*(\d{1,6})\s*/\s*(\d{1,6})\s*", text)
    if not match or not 1 <= int(match[1]) <= int(match[2]) <= MOST_PARTS:
        raise ValueError(f'part: write "3/8" for the third of eight, of at most {MOST_PARTS} (was {text!r})')
    return Part(int(match[1]), int(match[2]))


def settings_of_part(settings: Settings, part: Part) -> dict[str, Any]:
    """Return the settings of a part that are not those of the whole. Raises SettingsError.

    The shares of spp add up. A seed of its own keeps the samples of each part apart from those of all others.
    """
    if settings.noise is not None:
        raise SettingsError("A part does not know the noise of the whole: give it spp or time, not noise.")
    if settings.spp < part.total:
        raise SettingsError(
            f"{settings.spp} spp cannot be shared by {part.total} parts: ask for more, or for fewer parts."
        )
    spp = settings.spp // part.total + (part.number <= settings.spp % part.total)
    seed = int(np.random.SeedSequence([settings.seed, part.number]).generate_state(1)[0])
    changed: dict[str, Any] = {"spp": spp, "seed": seed}
    if settings.min_spp is not None:
        changed["min_spp"] = max(1, settings.min_spp // part.total)
    if settings.max_spp is not None:
        changed["max_spp"] = max(spp, settings.max_spp // part.total)
    return changed


def missing(sources: Sequence[str]) -> str:
    """Return a sentence about parts that are not there, "" if none is missing."""
    numbers_of_parts: dict[tuple[str, int], set[int]] = {}
    for source in sources:
        if match := re.fullmatch(r"(seed \d+), part (\d+) of (\d+)", source):
            numbers_of_parts.setdefault((match[1], int(match[3])), set()).add(int(match[2]))
    absent = [
        f"{number} of {total}"
        for (_, total), present in numbers_of_parts.items()
        for number in range(1, total + 1)
        if number not in present
    ]
    if not absent:
        return ""
    more = f" and {len(absent) - 8} more" if len(absent) > 8 else ""
    return f"Not all parts are there: {', '.join(absent[:8])}{more} would make it less noisy."

"""Did you mean: the known name that a mistaken one is likely to stand for."""

from __future__ import annotations

import difflib
import re


def nearest(name: str, names: list[str]) -> str | None:
    """Return the one of ``names`` that is most like ``name``, whatever the order of its words; None if none is."""
    return max(
        (word for word in names if likeness(name, word) >= 0.6), key=lambda word: likeness(name, word), default=None
    )


def did_you_mean(name: str, names: list[str], otherwise: str = ".") -> str:
    """Return the end of a sentence about an unknown name: the nearest known name, or ``otherwise`` if none is near."""
    hint = nearest(name, names)
    return otherwise if hint is None else f", did you mean '{hint}'?"


def likeness(name: str, candidate: str) -> float:
    """Return how alike two names are, 0 to 1: as they are written or with their words sorted, whichever is more."""
    pairs = [(name, candidate), (sorted_words(name), sorted_words(candidate))]
    return max(difflib.SequenceMatcher(None, other_words, name_words).ratio() for name_words, other_words in pairs)


def sorted_words(name: str) -> str:
    """Return a name with its words in alphabetical order, so that "spp_max" is "max_spp"."""
    return "_".join(sorted(re.split("[_-]", name.lower())))


def known(name: str, kind: str, names: list[str]) -> str:
    """Return ``name`` if it is one of ``names``; else raise ValueError with the nearest of them.

    ``kind``: what the message says such a name stands for, such as "criterion".
    """
    if name in names:
        return name
    raise ValueError(unknown(kind, name, sorted(names)))


def unknown(kind: str, name: str, names: list[str]) -> str:
    """Return a clause about a name that does not exist: the nearest name that does, and all ``names``."""
    return f"there is no {kind} '{name}'{did_you_mean(name, names)} There are: {', '.join(names)}"

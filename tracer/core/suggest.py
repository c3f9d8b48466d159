"""Did you mean: the known name that a mistaken one is likely to stand for."""

from __future__ import annotations

import difflib
import re


def nearest(name: str, known: list[str]) -> str | None:
    """Return the member of ``known`` most like ``name``, in whatever order its words are; None if none is alike."""
    return max(
        (word for word in known if likeness(name, word) >= 0.6), key=lambda word: likeness(name, word), default=None
    )


def did_you_mean(name: str, known: list[str], otherwise: str = ".") -> str:
    """Return the end of a sentence about an unknown name: the nearest that is known, or ``otherwise`` if none is."""
    hint = nearest(name, known)
    return otherwise if hint is None else f", did you mean '{hint}'?"


def likeness(name: str, other: str) -> float:
    """Return how alike two names are, 0 to 1: as they are written, or with the words between "_" and "-" sorted."""
    pairs = [(name, other), (sorted_words(name), sorted_words(other))]
    return max(difflib.SequenceMatcher(None, second, first).ratio() for first, second in pairs)


def sorted_words(name: str) -> str:
    """Return a name with its words in alphabetical order, so that "spp_max" is "max_spp"."""
    return "_".join(sorted(re.split("[_-]", name.lower())))


def known(name: str, what: str, names: list[str]) -> str:
    """Return ``name`` if it is one of ``names``; else raise ValueError with the nearest."""
    if name in names:
        return name
    raise ValueError(unknown(what, name, sorted(names)))


def unknown(what: str, name: str, names: list[str]) -> str:
    """Return the clause for a name that does not exist, with the nearest that does, and all that do."""
    return f"there is no {what} '{name}'{did_you_mean(name, names)} There are: {', '.join(names)}"

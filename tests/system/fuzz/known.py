"""Where Mitsuba ends the process: the command line says so in a sentence, as it runs in a child."""

import re
from typing import NamedTuple


class Known(NamedTuple):
    """A way in which Mitsuba is known to crash."""

    kinds: str
    """Pattern of the kinds of inputs in which it is allowed."""
    signals: tuple[int, ...]
    said: str
    """Pattern of what is printed before."""
    reason: str


CRASHES: tuple[Known, ...] = ()


def known(outcome):
    """Return why a process died, if that is known."""
    for one in CRASHES:
        if re.fullmatch(one.kinds, outcome.kind) and -outcome.code in one.signals and re.search(one.said, outcome.err):
            return one.reason
    return None

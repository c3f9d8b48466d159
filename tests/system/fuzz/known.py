"""Where Mitsuba ends the process: the command line says so in a sentence, as it runs in a child."""

import re
from signal import SIGABRT, SIGBUS, SIGSEGV
from typing import NamedTuple


class Known(NamedTuple):
    """A way in which Mitsuba is known to crash."""

    kinds: str
    """Pattern of the kinds of inputs that may have it."""
    holds: bytes
    """Pattern of the scene, or of a file beside it, that may have it."""
    reason: str


CRASHES = (
    Known(
        "(lying|damaged|odd) meshes",
        rb"\A(ply\s.*end_header|\x1c\x04)",
        "PLY and serialized meshes: faces with vertices that do not exist, far beyond the last, are followed while the "
        "mesh is loaded (those a little beyond load, and are found by tracer.scene.validate)",
    ),
    Known("volumes", rb"\AVOL", "a grid without cells, or with a negative number of them"),
    Known(
        "textures",
        rb"\A(P6|PF)\s+([-+]?0*\s|\d+\s+0*\s|\D)",
        "PPM and PFM pictures without pixels load, and are then looked up",
    ),
)
SIGNALS = (SIGABRT, SIGBUS, SIGSEGV)


def known(outcome):
    """Return why a process died, if that is known."""
    files = [path.read_bytes() for path in (outcome.folder / "in").iterdir() if path.is_file()]
    for one in CRASHES:
        found = any(re.search(one.holds, data, re.DOTALL) for data in files)
        if found and re.fullmatch(one.kinds, outcome.kind) and -outcome.code in SIGNALS:
            return one.reason
    return None

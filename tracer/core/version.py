"""What this distribution is called, which version it is, and how its optional parts are installed."""

from __future__ import annotations

import importlib.metadata
import re

DISTRIBUTION = "mitsuba-tracer"
"""Name of this distribution for ``pip``. Its package is imported as ``tracer``, a name that belongs to another project
on package indexes."""


def version() -> str:
    """Return the version of tracer."""
    return importlib.metadata.version(DISTRIBUTION)


def release() -> str:
    """Return the release on which this version builds: "0.1.0" of "0.1.0.post12+g1a2b3c4".

    What may go on together is asked by this: checkpoints and parts survive a commit, and an archive, which knows no
    commit, is as good as a clone.
    """
    return re.split(r"\.post|\.dev|\+", version())[0]


def install_command(extra: str) -> str:
    """Return a clause that says how the packages of an optional part are installed."""
    return f'in the folder of tracer\'s source, with: pip install ".[{extra}]"'

"""What this distribution is called, which version it is, and how its optional parts are installed."""

from __future__ import annotations

import importlib.metadata

DISTRIBUTION = "mitsuba-tracer"
"""Name of this distribution for ``pip``. Its package is imported as ``tracer``, a name that belongs to another project
on package indexes."""


def version() -> str:
    """Return the version of tracer."""
    return importlib.metadata.version(DISTRIBUTION)


def install_command(extra: str) -> str:
    """Return a clause that says how the packages of an optional part are installed."""
    return f'in the folder of tracer\'s source, with: pip install ".[{extra}]"'

"""tracer: adaptive rendering on Mitsuba 3.

Look first with cheap rays, measure the complexity of what they hit, and spend the expensive rays where they pay.
"""

from __future__ import annotations

import importlib
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tracer import errors
from tracer.core.backend import activate, named_library, point_to_library
from tracer.core.version import version

if TYPE_CHECKING:
    from tracer.api import render
    from tracer.progress import Progress
    from tracer.report import Report
    from tracer.result import Result
    from tracer.settings import Settings

    __version__: str

__all__ = ["Progress", "Report", "Result", "Settings", "__version__", "activate", "errors", "render"]

if not (Path(__file__).parent / "plugins").is_dir():
    # Imported from a checkout: tracer.plugins and tracer.scenes lie beside this folder, and are installed into it.
    __path__.append(str(Path(__file__).parents[1]))

point_to_library()  # before anything imports Dr.Jit, which loads LLVM when it is imported

HOMES = {
    "Progress": "tracer.progress",
    "render": "tracer.api",
    "Report": "tracer.report",
    "Result": "tracer.result",
    "Settings": "tracer.settings",
}
"""Modules that define the public names, by name; each is imported when the name is first used."""


def __getattr__(name: str) -> Any:
    """Import public names when they are first used, after the LLVM library is known to be usable (PEP 562)."""
    if name == "__version__":
        return version()
    if name not in HOMES:
        raise AttributeError(f"module 'tracer' has no attribute '{name}'")
    named_library()
    value = getattr(importlib.import_module(HOMES[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    """Return the public names alone, for completion."""
    return sorted(__all__)

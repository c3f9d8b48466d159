"""Packages that only some commands need, and what is said where one is not installed."""

from __future__ import annotations

import importlib
from types import ModuleType

from tracer.core.version import install_command
from tracer.errors import MissingPackageError


def require_package(module: str, package: str, purpose: str, extra: str) -> ModuleType:
    """Import and return a module of an optional package.

    ``purpose``: what needs it, as the beginning of a sentence; ``extra``: which part of tracer brings it. Raises
    MissingPackageError if it is not installed.
    """
    try:
        return importlib.import_module(module)
    except ImportError:
        raise MissingPackageError(f"{purpose} needs {package}; install it, {install_command(extra)}.") from None

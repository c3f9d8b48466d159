"""Packages that only some commands need, and the error for one that is not installed."""

from __future__ import annotations

import importlib
from types import ModuleType

from tracer.core.version import install_command
from tracer.errors import MissingPackageError


def require_package(module: str, package: str, purpose: str, extra: str) -> ModuleType:
    """Import and return a module of an optional package.

    ``purpose``: what needs the package, as the beginning of a sentence; ``extra``: the optional part of tracer that
    installs it. Raises MissingPackageError if it is not installed.
    """
    try:
        return importlib.import_module(module)
    except ImportError:
        raise MissingPackageError(f"{purpose} needs {package}; install it, {install_command(extra)}.") from None

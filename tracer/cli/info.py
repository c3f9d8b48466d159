"""Command ``info``."""

from __future__ import annotations

import typer


def info() -> None:
    """Print what a bug report needs: versions, the LLVM file, variant, threads and the folder of the bundled scenes.

    Example: tracer info
    """
    import importlib
    import os
    import platform

    from tracer.core import backend
    from tracer.core.version import version

    variant = backend.activate()
    import drjit as dr
    import mitsuba as mi

    library = backend.loaded_library()
    rows = {
        "tracer": version(),
        "mitsuba": mi.__version__,
        "drjit": dr.__version__,
        "python": platform.python_version(),
        "system": platform.platform(),
        "processor": backend.processor(),
        "variant": variant,
        "llvm": f"{'.'.join(map(str, library.version))} ({library.path})",
        "threads": f"{backend.thread_count()} of {os.cpu_count()} processors",
        "scenes": importlib.import_module("tracer.scenes").__path__[0],
    }
    for name, value in rows.items():
        typer.echo(f"{name:10} {value}")

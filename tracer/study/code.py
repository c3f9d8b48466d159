"""Hashes of the source that results depend on: what was made by other code is made again."""

from __future__ import annotations

import hashlib
import inspect
from functools import cache
from pathlib import Path
from types import ModuleType

import tracer
from tracer import band, criteria, draw, estimate, loop, scene, source

UNSEEN = (
    "cli",
    "study",
    "criteria",
    "cluster",
    "viewpoint",
    "radiosity",
    "api.py",
    "checkpoint.py",
    "errors.py",
    "files.py",
    "job.py",
    "live.py",
    "load_error.py",
    "memory.py",
    "merge.py",
    "metadata.py",
    "parts.py",
    "perform.py",
    "pictures.py",
    "progress.py",
)
"""Parts of tracer that no pixel depends on, apart from the criterion that a method names."""


def hash_of(paths: list[Path]) -> str:
    """Return a hash of the content of files."""
    digest = hashlib.sha256()
    for path in paths:
        digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


def files_of(*modules: ModuleType) -> list[Path]:
    """Return the files of modules."""
    return [Path(inspect.getfile(module)) for module in modules]


def plugin_sources() -> list[Path]:
    """Return the files of our plugins, but for the integrator that no study renders with."""
    from tracer import plugins

    return sorted(path for path in Path(plugins.__path__[0]).glob("*.py") if path.stem != "radiosity")


@cache
def render_hash() -> str:
    """Return a hash of the source that a picture by our loop depends on, but for its criterion."""
    from tracer.study import methods

    root = Path(tracer.__file__).parent
    sources = [path for path in sorted(root.rglob("*.py")) if path.relative_to(root).parts[0] not in UNSEEN]
    return hash_of([*sources, *files_of(methods), *plugin_sources()])


@cache
def stock_hash() -> str:
    """Return a hash of the source that a picture by plain ``mi.render`` depends on: how it is opened, and plugins."""
    from tracer.study import methods

    return hash_of([*files_of(source, scene, methods), *plugin_sources()])


def criterion_hash(name: str) -> str:
    """Return a hash of the file of a criterion, and of those beside it or among ours that it takes functions from."""
    found: list[ModuleType] = []
    waiting = [inspect.getmodule(criteria.get(name).importance)]
    while waiting:
        module = waiting.pop()
        if module is None or module in found:
            continue
        found.append(module)
        sources = {inspect.getmodule(one) for one in vars(module).values() if inspect.isfunction(one)}
        folders = (module.__package__, criteria.__name__)
        waiting += [one for one in sources if one is not None and one.__package__ in folders]
    return hash_of(sorted(files_of(*found)))


@cache
def truth_hash() -> str:
    """Return a hash of the source that the measurements of an oracle depend on."""
    from tracer.study import truth, uniform

    return hash_of([*files_of(truth, uniform, band, draw, estimate, loop, scene), *plugin_sources()])


@cache
def oracle_hash() -> str:
    """Return a hash of the source that an oracle's allocation depends on."""
    from tracer.study import oracle

    return hash_of(files_of(oracle)) + truth_hash()

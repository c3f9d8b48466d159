"""Hashes of the source that results depend on: what was made by other code is made again."""

from __future__ import annotations

import hashlib
import inspect
from functools import cache
from pathlib import Path
from types import ModuleType

import tracer
from tracer import criteria

ROOT = Path(tracer.__file__).parent
DECIDING = (
    "core",
    "image",
    "scene",
    "complexity",
    "sampling",
    "film",
    "adaptive",
    "denoising",
    "session",
    "settings.py",
    "result.py",
)
"""Folders and files that pixels depend on, beside the plugins and the criterion that a method names."""


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


def sources(*names: str) -> list[Path]:
    """Return files of tracer, by their names within the package; a folder stands for all of its files."""
    found = (ROOT / name for name in names)
    return [path for each in found for path in (sorted(each.rglob("*.py")) if each.is_dir() else [each])]


@cache
def render_hash() -> str:
    """Return a hash of the source that a picture by our loop depends on, but for its criterion."""
    return hash_of([*sources(*DECIDING, "study/methods.py"), *plugin_sources()])


@cache
def stock_hash() -> str:
    """Return a hash of the source that a picture by plain ``mi.render`` depends on: how it is opened, and plugins."""
    return hash_of([*sources("scene", "study/methods.py"), *plugin_sources()])


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
    own = sources("study/oracle_measurements.py", "study/uniform.py")
    return hash_of([*own, *sources("sampling", "film", "scene", "session/render_loop.py"), *plugin_sources()])


@cache
def oracle_hash() -> str:
    """Return a hash of the source that an oracle's allocation depends on."""
    return hash_of(sources("study/oracle.py")) + truth_hash()

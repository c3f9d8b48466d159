"""Hashes of the source files that a result depends on: when these files have changed, it is made again."""

from __future__ import annotations

import hashlib
import inspect
from functools import cache
from pathlib import Path
from types import ModuleType

import tracer
from tracer import criteria

ROOT = Path(tracer.__file__).parent
"""Folder of the package."""
DECIDING = (
    "core",
    "image",
    "scene",
    "complexity",
    "sampling",
    "film",
    "adaptive",
    "guiding",
    "denoising",
    "session",
    "settings.py",
    "report.py",
    "result.py",
)
"""Folders and files of the package that pixels depend on, besides the plugins and the criterion of the method."""


def hash_of(paths: list[Path]) -> str:
    """Return a hash of the content of these files."""
    digest = hashlib.sha256()
    for path in paths:
        digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


def files_of(*modules: ModuleType) -> list[Path]:
    """Return the source files of modules."""
    return [Path(inspect.getfile(module)) for module in modules]


def plugin_sources() -> list[Path]:
    """Return the source files of our plugins, without the integrator that no study renders with."""
    from tracer import plugins

    return sorted(path for path in Path(plugins.__path__[0]).glob("*.py") if path.stem != "radiosity")


def sources(*names: str) -> list[Path]:
    """Return source files, by names within the package; the name of a folder stands for all files in it."""
    places = (ROOT / name for name in names)
    return [path for place in places for path in (sorted(place.rglob("*.py")) if place.is_dir() else [place])]


@cache
def render_hash() -> str:
    """Return a hash of the source that a picture by our loop depends on, without its criterion."""
    return hash_of([*sources(*DECIDING, "study/methods.py"), *plugin_sources()])


@cache
def stock_hash() -> str:
    """Return a hash of the source that a picture by plain ``mi.render`` depends on: opening of scenes, and plugins."""
    return hash_of([*sources("scene", "study/methods.py"), *plugin_sources()])


def criterion_hash(name: str) -> str:
    """Return a hash of the file of a criterion, and of the files that its functions come from.

    Of these, only files in its own package or among tracer's criteria count.
    """
    modules: list[ModuleType] = []
    waiting = [inspect.getmodule(criteria.get(name).importance)]
    while waiting:
        module = waiting.pop()
        if module is None or module in modules:
            continue
        modules.append(module)
        origins = {inspect.getmodule(value) for value in vars(module).values() if inspect.isfunction(value)}
        packages = (module.__package__, criteria.__name__)
        waiting += [origin for origin in origins if origin is not None and origin.__package__ in packages]
    return hash_of(sorted(files_of(*modules)))


@cache
def truth_hash() -> str:
    """Return a hash of the source that the measurements of an oracle depend on."""
    measuring = sources("study/oracle_measurements.py", "study/uniform.py")
    return hash_of([*measuring, *sources("sampling", "film", "scene", "session/render_loop.py"), *plugin_sources()])


@cache
def oracle_hash() -> str:
    """Return a hash of the source that an oracle's allocation depends on."""
    return hash_of(sources("study/oracle.py")) + truth_hash()

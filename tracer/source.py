"""Where a scene comes from: a file, a dictionary or a loaded scene; and what identifies its content."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import mitsuba as mi

from tracer.errors import SceneError
from tracer.load_error import load_error
from tracer.soundness import require_faces, require_sources

LOAD_ERRORS = (RuntimeError, ValueError, TypeError, MemoryError)
"""What Mitsuba raises for a scene it cannot load."""


def describe(source: Any) -> str:
    """Return how a message names a source."""
    return f"'{source}'" if isinstance(source, str | Path) else "the scene"


def load(source: Any, sampler: str | None = None, define: dict[str, str] | None = None) -> Any:
    """Return the ``mi.Scene`` of a path or dictionary; an object is passed through. Raises SceneError.

    Meshes of one material are not merged, as ``mi.load_file`` does by default, so that shapes can be told apart. It is
    as fast, but where faces of two meshes lie in one plane the picture may be another one.
    ``sampler`` names a plugin to take the place of every sampler of the scene, with its sample count. ``define``:
    values of the $parameters of a file.
    """
    if not isinstance(source, str | Path | dict):
        if not hasattr(source, "class_name"):
            raise SceneError(f"A scene is a path, a dictionary or an mi.Scene, not {type(source).__name__}.")
        return source
    config, state = parse(source, define)
    config.merge_meshes = False
    require_sources(describe(source), state)
    for node in state.nodes:
        if sampler is not None and node.type == mi.ObjectType.Sampler:
            node.props.set_plugin_name(sampler)
            for name in [name for name in node.props.keys() if name != "sample_count"]:  # noqa: SIM118
                del node.props[name]
    try:
        with files_beside(source):
            mi.parser.transform_all(config, state)
            scene = mi.parser.instantiate(config, state)
    except LOAD_ERRORS as error:
        raise load_error(describe(source), error) from None
    require_faces(describe(source), scene)
    if sampler is not None:
        require_samplers(source, state, scene)
    return scene


def require_samplers(source: Any, state: Any, scene: Any) -> None:
    """Raise SceneError if a sensor of ``scene`` has no sampler of its own, in whose place another could be put."""
    samplers = sum(node.type == mi.ObjectType.Sampler for node in state.nodes)
    if scene.class_name() == "Scene" and samplers < len(scene.sensors()):
        raise SceneError(
            f"{describe(source)} has a sensor without a sampler, so samplers cannot be compared on it; "
            'add one inside of the sensor, for example <sampler type="independent"/>.'
        )


@contextmanager
def files_beside(source: str | Path | dict[str, Any]) -> Iterator[None]:
    """Let Mitsuba find meshes and textures in the folder of a scene file, as ``mi.load_file`` does."""
    before = mi.file_resolver()
    if not isinstance(source, dict):
        resolver = mi.FileResolver(before)
        resolver.prepend(str(Path(source).resolve().parent))
        mi.set_file_resolver(resolver)
    try:
        yield
    finally:
        mi.set_file_resolver(before)


def parse(source: str | Path | dict[str, Any], define: dict[str, str] | None = None) -> tuple[Any, Any]:
    """Return Mitsuba's parser configuration and the parsed scene, not yet made into objects. Raises SceneError."""
    config = mi.parser.ParserConfig(mi.variant())
    config.parallel = False  # loading Python plugins in parallel can deadlock
    if isinstance(source, dict):
        try:
            return config, mi.parser.parse_dict(config, source)
        except LOAD_ERRORS as error:
            raise load_error(describe(source), error) from None
    path = Path(source)
    if not path.exists():
        raise SceneError(f"There is no scene file '{path}'.")
    if not path.is_file():
        raise SceneError(f"'{path}' is a folder, not a scene file.")
    try:
        with files_beside(path):  # of spectra, which are read now
            return config, mi.parser.parse_file(config, str(path), **(define or {}))
    except LOAD_ERRORS as error:
        raise load_error(describe(source), error) from None


def properties(source: Any, node: Any) -> list[tuple[str, Any]]:
    """Return names and values of what the source says of an object. Raises SceneError."""
    try:
        return list(node.props.items())
    except UnicodeDecodeError:
        raise SceneError(f"{describe(source)} does not load: there is text in it that is not UTF-8.") from None


def fingerprint(source: Any, define: dict[str, str] | None = None) -> str:
    """Return a hash (hexadecimal, 16 digits) of what a scene consists of.

    For a path: its XML, all files it includes, and the content of every file it names (meshes, textures, volumes). For
    a dictionary: the same after parsing. For a loaded scene: what it prints of itself, which leaves out mesh data.
    """
    digest = hashlib.sha256()
    if not isinstance(source, str | Path | dict):
        digest.update(str(source).encode())
        return digest.hexdigest()[:16]
    _, state = parse(source, define)
    digest.update(repr(sorted(define.items())).encode() if define else b"")
    folders = [Path(str(file)).parent for file in state.files] or [Path.cwd()]
    for file in state.files:
        digest.update(Path(str(file)).read_bytes())
    for node in state.nodes:
        for name, value in properties(source, node):
            digest.update(f"{node.props.plugin_name()} {name} {value}\n".encode() if isinstance(source, dict) else b"")
            if hasattr(value, "wavelengths"):
                digest.update(repr((list(value.wavelengths), list(value.values))).encode())
            if isinstance(value, str):
                named = next((folder / value for folder in folders if os.path.isfile(folder / value)), None)
                digest.update(named.read_bytes() if named else b"")
    return digest.hexdigest()[:16]

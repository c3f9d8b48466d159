"""Load a scene from a file, a dictionary or an object, as Mitsuba does."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import mitsuba as mi

from tracer.core import threads
from tracer.errors import SceneError
from tracer.scene.load_errors import load_error
from tracer.scene.mesh_defects import meshes_explained
from tracer.scene.shape_names import name_after_files
from tracer.scene.validate import require_faces, require_sources

LOAD_ERRORS = (RuntimeError, ValueError, TypeError, MemoryError)
"""Types of the errors that Mitsuba raises for a scene that it cannot load."""


@dataclass(frozen=True)
class Parsed:
    """A scene that has been read, and of which no objects have been made yet."""

    config: Any
    """``mi.parser.ParserConfig``."""
    state: Any
    """``mi.parser.ParserState``: nodes with their properties, and the XML files they come from."""
    resolver: Any
    """``mi.FileResolver`` with the folders in which the scene's files are looked for, those of ``<path>`` first."""

    @property
    def folders(self) -> list[Path]:
        """The folders in which files are looked for, in order."""
        return [Path(str(folder)) for folder in self.resolver]

    @property
    def own_folders(self) -> list[Path]:
        """The folders of this scene alone: those that it names with ``<path>``, and the folder that it is in."""
        return self.folders[: len(self.folders) - len(list(mi.file_resolver()))]

    def find(self, name: str) -> Path | None:
        """Return the file that ``name`` stands for in this scene, or None if there is none."""
        return next((folder / name for folder in self.folders if is_file(folder / name)), None) if name else None


def is_file(path: Path) -> bool:
    """Return whether there is a file of that name; False for text that cannot be a name, as it is too long."""
    try:
        return path.is_file()
    except (OSError, ValueError):
        return False


def describe(source: Any) -> str:
    """Return how a message names the source of a scene: by its path in quotes, or as "the scene"."""
    return f"'{source}'" if isinstance(source, str | Path) else "the scene"


def require_scene(source: Any, loaded: Any) -> Any:
    """Return what was loaded from ``source`` if it is a scene, else raise SceneError."""
    if loaded.class_name() != "Scene":
        raise SceneError(f"{describe(source)} holds a {loaded.class_name()}, not a scene; wrap it in <scene>.")
    return loaded


def load(source: Any, sampler: str | None = None, define: dict[str, str] | None = None) -> Any:
    """Return the ``mi.Scene`` of a path or dictionary; an object is passed through. Raises SceneError.

    Meshes of one material are not merged, unlike by default in ``mi.load_file``, so that shapes can be told apart. This
    renders as fast, but the picture may differ where faces of two meshes lie in one plane. Meshes without an id in a
    file are called after their own files. ``sampler`` names a plugin
    that takes the place of every sampler of the scene and keeps its sample count. ``define``: values of the
    $parameters of a file.
    """
    if not isinstance(source, str | Path | dict):
        if not hasattr(source, "class_name"):
            raise SceneError(f"A scene is a path, a dictionary or an mi.Scene, not {type(source).__name__}.")
        return source
    parsed = parse(source, define)
    config, state = parsed.config, parsed.state
    config.merge_meshes = False
    require_sources(describe(source), state)
    if not isinstance(source, dict):
        name_after_files(state.nodes)
    for node in state.nodes:
        if sampler is not None and node.type == mi.ObjectType.Sampler:
            node.props.set_plugin_name(sampler)
            for name in [name for name in node.props.keys() if name != "sample_count"]:  # noqa: SIM118
                del node.props[name]
    try:
        with looking_in(parsed.resolver), threads.for_files(), meshes_explained(describe(source), state):
            mi.parser.transform_all(config, state)
            scene = mi.parser.instantiate(config, state)
    except LOAD_ERRORS as error:
        raise load_error(describe(source), error) from None
    require_faces(describe(source), scene)
    if sampler is not None:
        require_samplers(source, state, scene)
    return scene


def require_samplers(source: Any, state: Any, scene: Any) -> None:
    """Raise SceneError if a sensor of ``scene`` has no sampler in its source that another could replace."""
    sampler_count = sum(node.type == mi.ObjectType.Sampler for node in state.nodes)
    if scene.class_name() == "Scene" and sampler_count < len(scene.sensors()):
        raise SceneError(
            f"{describe(source)} has a sensor without a sampler, so samplers cannot be compared on it; "
            'add one inside of the sensor, for example <sampler type="independent"/>.'
        )


@contextmanager
def looking_in(resolver: Any) -> Iterator[None]:
    """Let Mitsuba look for files in the folders of ``resolver`` within the block, in its former folders after it.

    A scene may add folders to the resolver while it is read.
    """
    previous = mi.file_resolver()
    mi.set_file_resolver(resolver)
    try:
        yield
    finally:
        mi.set_file_resolver(previous)


def parse(source: str | Path | dict[str, Any], define: dict[str, str] | None = None) -> Parsed:
    """Read a scene as ``mi.load_file`` or ``mi.load_dict`` does, without making objects. Raises SceneError.

    Files are looked for in the folders that ``<path>`` names, the last one first, then beside the scene file, then in
    the current folder.
    """
    config = mi.parser.ParserConfig(mi.variant())
    # In parallel, loading can deadlock: with plugins in Python, and where the pool of threads is made smaller
    # afterwards, as a thread that has loaded objects then still waits for Python's lock.
    config.parallel = False
    resolver = mi.FileResolver(mi.file_resolver())
    if not isinstance(source, dict):
        path = Path(source)
        if not path.exists():
            raise SceneError(f"There is no scene file '{path}'.")
        if not path.is_file():
            raise SceneError(f"'{path}' is a folder, not a scene file.")
        resolver.prepend(str(path.resolve().parent))
    try:
        with looking_in(resolver):  # <path> adds folders to it, and files of spectra are read now
            if isinstance(source, dict):
                state = mi.parser.parse_dict(config, source)
            else:
                state = mi.parser.parse_file(config, str(source), **(define or {}))
    except LOAD_ERRORS as error:
        raise load_error(describe(source), error) from None
    return Parsed(config, state, resolver)


def properties(source: Any, node: Any) -> list[tuple[str, Any]]:
    """Return names and values of the properties that ``source`` gives an object. Raises SceneError."""
    try:
        return list(node.props.items())
    except UnicodeDecodeError:
        raise SceneError(f"{describe(source)} does not load: there is text in it that is not UTF-8.") from None

"""A scene with all of its files in one piece, for workers that do not share a disk with the client.

The piece is a ZIP archive, named by the hash of the scene. A worker unpacks it once, in its own folder, and uses the
scene in it only if that has the expected hash. Only files are read from the archive; nothing in it is executed.
"""

from __future__ import annotations

import io
import os
import re
import zipfile
from pathlib import Path, PurePosixPath
from typing import Any

from distributed import WorkerPlugin

from tracer.errors import ClusterError
from tracer.scene.load import is_file, parse, properties

SCENES = "tracer-scenes"
"""Folder, within the local folder of a worker, where bundles are unpacked."""
ATTRIBUTE = re.compile(r'\b(?:value|filename)\s*=\s*(?:"([^"]*)"|\'([^\']*)\')')
"""Attribute of XML that may name a file. The text is searched, as Mitsuba reads spectra and included scenes while it
parses and does not tell which files they were."""
DEFAULT = re.compile(r'<default\s+name\s*=\s*"([^"]*)"\s+value\s*=\s*"([^"]*)"')
"""Tag of XML that gives a $parameter its default value."""


class Bundle(WorkerPlugin):
    """Brings a scene to all present workers, and to those that join later."""

    def __init__(self, scene_hash: str, archive: bytes) -> None:
        self.name = f"tracer-scene-{scene_hash}"
        self.scene_hash, self.archive = scene_hash, archive

    def setup(self, worker: Any) -> None:
        """Unpack the files."""
        unpack(self.archive, Path(worker.local_directory) / SCENES / self.scene_hash)


def pack(scene: Path, define: dict[str, str]) -> bytes:
    """Return an archive of a scene file and all files that it names, with their relative paths as they are now.

    Raises ClusterError for a scene that names files by absolute paths, which a worker would not have.
    """
    paths, folders = contents_of(scene, define)
    root = Path(os.path.commonpath([*(path.parent for path in paths), *folders]))
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive:
        for folder in sorted(folders - {root}):
            archive.writestr(folder.relative_to(root).as_posix() + "/", "")
        for path in sorted(paths):
            archive.write(path, path.relative_to(root).as_posix())
    return stream.getvalue()


def contents_of(scene: Path, define: dict[str, str]) -> tuple[set[Path], set[Path]]:
    """Return a scene file with all files that it names, and the folders in which it looks for them.

    All are normal absolute paths. Raises ClusterError for a file that workers could not find by the same name.
    """
    parsed = parse(scene, define)
    paths = {normal(Path(str(file))) for file in parsed.state.files}
    names = {value for node in parsed.state.nodes for _, value in properties(scene, node) if isinstance(value, str)}
    defaults = [pair for path in paths for pair in DEFAULT.findall(path.read_text(encoding="utf-8", errors="replace"))]
    values = {**dict(defaults), **define}
    for path in list(paths):
        names |= named_in(path.read_text(encoding="utf-8", errors="replace"), values)
    own_folders = [normal(folder) for folder in parsed.own_folders]
    folders = {folder for folder in own_folders if folder.is_dir()}
    for name in sorted(filter(None, names)):
        if Path(name).is_absolute() and exists(Path(name)):
            raise ClusterError(
                f"'{scene}' names '{name}', a path that workers do not have: name files relative to the scene, or put "
                "it in a folder that workers share."
            )
        matches = [
            folder / name for folder in (*own_folders, *{path.parent for path in paths}) if is_file(folder / name)
        ]
        paths |= {normal(path) for path in matches}
        if not matches and parsed.find(name) is not None:
            raise ClusterError(
                f"'{scene}' names '{name}', which is in the current folder and not beside the scene, where workers "
                'look for it: move it there, or name its folder in the scene with <path value="..."/>.'
            )
    return paths, folders


def named_in(text: str, values: dict[str, str]) -> set[str]:
    """Return all text of an XML file that may be the name of a file, with the ``values`` of its $parameters put in."""
    for name in sorted(values, key=len, reverse=True):
        text = text.replace(f"${name}", values[name])
    return {double or single for double, single in ATTRIBUTE.findall(text)}


def exists(path: Path) -> bool:
    """Return whether there is a file or folder of that name; False for text that is too long for a name."""
    try:
        return path.exists()
    except (OSError, ValueError):
        return False


def normal(path: Path) -> Path:
    """Return an absolute path without ".."; links are not resolved, as the scene refers to files by their names."""
    return Path(os.path.abspath(path))


def unpack(data: bytes, folder: Path) -> None:
    """Write the files of an archive into ``folder``, all or none. Raises ClusterError for names that lead out of it."""
    if folder.exists():
        return
    temporary = folder.with_name(f".{folder.name}.{os.getpid()}")
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        for name in archive.namelist():
            if PurePosixPath(name).is_absolute() or ".." in PurePosixPath(name).parts:
                raise ClusterError(f"A bundle has a file '{name}' that does not belong in it.")
            path = temporary / name
            parent = path if name.endswith("/") else path.parent
            parent.mkdir(parents=True, exist_ok=True)
            if not name.endswith("/"):
                path.write_bytes(archive.read(name))
    temporary.rename(folder)

"""A scene with all of its files in one piece, for workers that do not share a disk with the client.

A ZIP archive named by the hash of the scene. A worker unpacks it once, beside what else it keeps, and takes it for the
scene only if its hash is the one that it asked for. Files alone are read from it, nothing that runs.
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
"""Folder within that of a worker where bundles are unpacked."""
ATTRIBUTE = re.compile(r'\b(?:value|filename)\s*=\s*(?:"([^"]*)"|\'([^\']*)\')')
"""What may name a file in XML: spectra and included scenes are read as it is parsed, and leave no trace."""
DEFAULT = re.compile(r'<default\s+name\s*=\s*"([^"]*)"\s+value\s*=\s*"([^"]*)"')
"""A $parameter and its value, where nothing else is asked for."""


class Bundle(WorkerPlugin):
    """Brings a scene to every worker there is, and to those that come later."""

    def __init__(self, scene_hash: str, archive: bytes) -> None:
        self.name = f"tracer-scene-{scene_hash}"
        self.scene_hash, self.archive = scene_hash, archive

    def setup(self, worker: Any) -> None:
        """Unpack the files."""
        unpack(self.archive, Path(worker.local_directory) / SCENES / self.scene_hash)


def pack(scene: Path, define: dict[str, str]) -> bytes:
    """Return a scene file and all files that it names as an archive, where they lie to one another as they do now.

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

    All are normal absolute paths. Raises ClusterError for what workers cannot find by the same name.
    """
    parsed = parse(scene, define)
    found = {normal(Path(str(file))) for file in parsed.state.files}
    names = {value for node in parsed.state.nodes for _, value in properties(scene, node) if isinstance(value, str)}
    defaults = [pair for file in found for pair in DEFAULT.findall(file.read_text(encoding="utf-8", errors="replace"))]
    values = {**dict(defaults), **define}
    for file in list(found):
        names |= named_in(file.read_text(encoding="utf-8", errors="replace"), values)
    beside = [normal(folder) for folder in parsed.own_folders]
    folders = {folder for folder in beside if folder.is_dir()}
    for name in sorted(filter(None, names)):
        if Path(name).is_absolute() and exists(Path(name)):
            raise ClusterError(
                f"'{scene}' names '{name}', a path that workers do not have: name files relative to the scene, or put "
                "it in a folder that workers share."
            )
        there = [folder / name for folder in (*beside, *{file.parent for file in found}) if is_file(folder / name)]
        found |= {normal(path) for path in there}
        if not there and parsed.find(name) is not None:
            raise ClusterError(
                f"'{scene}' names '{name}', which is in the current folder and not beside the scene, where workers "
                'look for it: move it there, or name its folder in the scene with <path value="..."/>.'
            )
    return found, folders


def named_in(text: str, values: dict[str, str]) -> set[str]:
    """Return what may be the name of a file in the text of an XML file, with the ``values`` of its $parameters."""
    for name in sorted(values, key=len, reverse=True):
        text = text.replace(f"${name}", values[name])
    return {double or single for double, single in ATTRIBUTE.findall(text)}


def exists(path: Path) -> bool:
    """Return whether there is a file or folder of that name; text that is too long for a name is none."""
    try:
        return path.exists()
    except (OSError, ValueError):
        return False


def normal(path: Path) -> Path:
    """Return an absolute path without ".."; links stay, as their names are what the scene knows."""
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
            folder_of_it = path if name.endswith("/") else path.parent
            folder_of_it.mkdir(parents=True, exist_ok=True)
            if not name.endswith("/"):
                path.write_bytes(archive.read(name))
    temporary.rename(folder)

"""Find out what is wrong with a mesh file that Mitsuba does not load.

Mitsuba's own messages name bytes and registers instead. A file is examined only after Mitsuba has refused it, and only
up to its first defect.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from tracer.errors import SceneError
from tracer.scene.ply_defects import ANEW, ply_defect


@contextmanager
def meshes_explained(subject: str, state: Any) -> Iterator[None]:
    """Turn an error that Mitsuba raises over a shape into a SceneError that says what is wrong with its mesh file.

    ``subject``: how the message names the scene. ``state``: that of Mitsuba's parser. Files are found by the file
    resolver that Mitsuba has when the error is raised. The error stays as it is if no defect is found.
    """
    import mitsuba as mi

    try:
        yield
    except RuntimeError as error:
        match = re.search(r'(?:shape|unknown) plugin of type "(\w+)"', str(error))
        plugin = match[1] if match else ""
        nodes = [node for node in state.nodes if node.props.plugin_name() == plugin] if plugin in DEFECTS else []
        for name in [node.props["filename"] for node in nodes if isinstance(node.props.get("filename"), str)]:
            if defect := mesh_defect(Path(str(mi.file_resolver().resolve(name))), plugin):
                raise SceneError(f"{subject} does not load: '{name}' {defect}.") from None
        raise


def mesh_defect(path: Path, plugin: str) -> str | None:
    """Return what is wrong with a mesh file and what to do, as the predicate of a sentence; None if nothing is found.

    ``plugin``: name of the Mitsuba plugin that is to read the file.
    """
    if plugin not in DEFECTS or not path.is_file():
        return None
    data = path.read_bytes()
    if not data:
        return f"is empty; {ANEW}"
    return DEFECTS[plugin](data)


def obj_defect(data: bytes) -> str | None:
    """Return what is wrong with the content of an OBJ file, as ``mesh_defect`` does."""
    if data.startswith(b"ply"):
        return "is a PLY file; name the plugin 'ply' instead of 'obj'"
    faces = [line.split() for line in re.findall(rb"^[ \t]*f[ \t]+(.*)$", data, re.MULTILINE)]
    if any(words and words[-1].endswith(b"\\") for words in faces):
        return f"has faces that go on in the next line, which Mitsuba does not read; {ANEW}"
    if not any(len(words) > 2 for words in faces):
        return f"has no face of three corners or more, only points or lines; {ANEW} as a surface"
    counts = [
        len(re.findall(rb"^[ \t]*" + element + rb"[ \t]", data, re.MULTILINE)) for element in (b"v", b"vt", b"vn")
    ]
    for words in faces:
        for word in words:
            for index, count, element in zip(
                word.split(b"/"), counts, ("vertex", "texture place", "normal"), strict=False
            ):
                if re.fullmatch(rb"-\d+", index):
                    return (
                        f"has faces that count their corners backwards (negative indices, as {index.decode()}), which "
                        "Mitsuba does not read; export it with indices from 1 on, or as PLY"
                    )
                if index.isdigit() and not 1 <= int(index) <= count:
                    return f"has a face with {element} {int(index)}, and {count} of them, counted from 1; {ANEW}"
    return None


DEFECTS: dict[str, Callable[[bytes], str | None]] = {"ply": ply_defect, "obj": obj_defect}
"""Function that finds the defect of a file's content, by the Mitsuba plugin that reads such files."""

"""The house stands on its floors: nothing imports from a higher one, and no rooms stand on one another in a circle."""

import ast
from pathlib import Path

import tracer

ROOT = Path(tracer.__file__).parent
FLOORS = [
    ["errors"],
    ["core"],
    ["image"],
    ["scene"],
    ["io", "sampling"],
    ["complexity"],
    ["film"],
    ["criteria", "denoising"],
    ["settings"],
    ["adaptive"],
    ["result", "progress"],
    ["live"],
    ["session"],
    ["cluster", "viewpoint"],
    ["radiosity", "jobs"],
    ["api", "plugins"],
    ["study"],
    ["cli"],
]
"""Rooms, and files in the root, from the ground upwards."""


def room(module):
    """Return the folder of a module within the package, or its name if it is in the root."""
    return module.split(".")[1]


def imports():
    """Yield who imports what: (module, module), as far as both are of tracer."""
    folders = [(ROOT, "tracer"), (ROOT.parent / "plugins", "tracer.plugins")]
    for folder, package in folders:
        for path in sorted(folder.rglob("*.py")):
            module = ".".join((package, *path.relative_to(folder).with_suffix("").parts)).removesuffix(".__init__")
            for node in ast.walk(ast.parse(path.read_text())):
                if isinstance(node, ast.ImportFrom) and (node.module or "").split(".")[0] == "tracer":
                    for alias in node.names:
                        yield module, f"{node.module}.{alias.name}"


def test_every_room_has_a_floor():
    rooms = {path.stem for path in ROOT.iterdir() if path.name[0] != "_" and (path.suffix == ".py" or path.is_dir())}
    assert rooms | {"plugins"} == {name for floor in FLOORS for name in floor}


def test_nothing_imports_from_a_higher_floor_or_from_another_room_of_its_own():
    height = {name: number for number, floor in enumerate(FLOORS) for name in floor}
    upwards = [
        f"{importer} imports {imported}"
        for importer, imported in imports()
        if importer not in ("tracer", "tracer.__main__")
        and room(imported) in height
        and room(importer) != room(imported)
        and height[room(importer)] <= height[room(imported)]
    ]
    assert not upwards

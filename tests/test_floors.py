"""The house stands on its floors: nothing imports from a higher one, and nothing in a circle."""

import ast
from functools import cache
from graphlib import TopologicalSorter
from pathlib import Path

ROOT = Path(__file__).parents[1] / "tracer"
FLOORS = [
    ["errors"],
    ["core"],
    ["image"],
    ["scene"],
    ["io", "sampling"],
    ["complexity", "guiding"],
    ["film"],
    ["criteria", "denoising"],
    ["settings"],
    ["adaptive"],
    ["progress", "report"],
    ["result"],
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


@cache
def imports():
    """Return who imports what: (module, module or name), of all that is installed."""
    found = []
    folders = [(ROOT, "tracer"), (ROOT.parent / "plugins", "tracer.plugins")]
    for folder, package in folders:
        for path in sorted(folder.rglob("*.py")):
            module = ".".join((package, *path.relative_to(folder).with_suffix("").parts)).removesuffix(".__init__")
            for node in ast.walk(ast.parse(path.read_text())):
                found += [(module, name) for name in names_imported_by(node)]
    return found


def names_imported_by(node):
    """Return the modules, or names in modules, that a statement imports."""
    if isinstance(node, ast.ImportFrom):
        return [f"{node.module}.{alias.name}" for alias in node.names]
    return [alias.name for alias in node.names] if isinstance(node, ast.Import) else []


def test_every_room_has_a_floor():
    rooms = {path.stem for path in ROOT.iterdir() if path.name[0] != "_" and (path.suffix == ".py" or path.is_dir())}
    assert rooms | {"plugins"} == {name for floor in FLOORS for name in floor}


def test_nothing_imports_from_a_higher_floor_or_from_another_room_of_its_own():
    height = {name: number for number, floor in enumerate(FLOORS) for name in floor}
    upwards = [
        f"{importer} imports {imported}"
        for importer, imported in imports()
        if imported.startswith("tracer.")
        and importer not in ("tracer", "tracer.__main__")
        and room(imported) in height
        and room(importer) != room(imported)
        and height[room(importer)] <= height[room(imported)]
    ]
    assert not upwards


def test_no_modules_import_one_another_in_a_circle():
    modules = {importer for importer, _ in imports()}
    graph = {module: set() for module in modules}
    for importer, imported in imports():
        module = imported if imported in modules else imported.rpartition(".")[0]
        if importer not in ("tracer", module):
            graph[importer].add(module)
    TopologicalSorter(graph).prepare()  # raises CycleError, which names them


def test_nothing_that_is_installed_imports_what_measures_it():
    assert not [(importer, name) for importer, name in imports() if name.split(".")[0] == "benchmarks"]


def test_no_file_is_two_rooms_in_one():
    lengths = {path: path.read_text().count("\n") for path in [*ROOT.rglob("*.py"), *ROOT.parent.rglob("plugins/*.py")]}
    assert not [f"{path}: {length} lines" for path, length in lengths.items() if length > 400]

"""The reference of Python lists what texts and examples use, nothing that does not exist, and examples that run."""

import doctest
import importlib
import inspect
import json
import re
import textwrap
from pathlib import Path

import matplotlib as mpl
import pytest

import tracer
from conftest import LIT
from tracer import criteria
from tracer.criteria import registry

ROOT = Path(__file__).parents[1]
PAGE = (ROOT / "docs/reference/python.md").read_text()
DIRECTIVE = re.compile(r"^\.\. auto(\w+):: (\S+)\n((?:   :.*\n)*)", re.MULTILINE)
EXAMPLE = re.compile(r"Example::\n\n(.*?)(?=\n\S|\Z)", re.DOTALL)


def resolve(path):
    """Return the object of a dotted path, whose modules are imported."""
    module, _, rest = path, "", []
    while True:
        try:
            value = importlib.import_module(module)
            break
        except ModuleNotFoundError:
            module, _, name = module.rpartition(".")
            rest = [name, *rest]
    for name in rest:
        value = getattr(value, name)
    return value


def listed(kind, path, options):
    """Return the objects of a directive: of a module, the members that it lists, else all that it documents."""
    if kind != "module":
        return [resolve(path)]
    members = re.search(r":members: (.*)", options)
    module = resolve(path)
    if members:
        return [getattr(module, name) for name in members[1].split(", ")]
    return [value for value in vars(module).values() if getattr(value, "__module__", None) == path]


DIRECTIVES = DIRECTIVE.findall(PAGE)
PUBLIC = [value for directive in DIRECTIVES if directive[0] != "data" for value in listed(*directive)]
DOCUMENTED = {path: resolve(path) for kind, path, _ in DIRECTIVES if kind != "data"}
DOCUMENTED |= {f"{value.__module__}.{value.__name__}": value for value in PUBLIC if value not in DOCUMENTED.values()}
DOCUMENTED |= {"tracer.Result.save": tracer.Result.save}
criteria.names()  # registers all that come with tracer


def documentation(value):
    return inspect.getdoc(value) or ""


def code_of_texts():
    """Yield the Python of texts, examples and notebooks, by file."""
    texts = [ROOT / "README.md", *(ROOT / "docs").rglob("*.md")]
    for path in texts:
        if "gallery" not in path.parts:
            yield path, "\n".join(re.findall(r"```python\n(.*?)```", path.read_text(), re.DOTALL))
    for path in (ROOT / "examples").rglob("*.py"):
        yield path, path.read_text()
    for path in (ROOT / "examples").rglob("*.ipynb"):
        cells = json.loads(path.read_text())["cells"]
        yield path, "\n".join("".join(cell["source"]) for cell in cells if cell["cell_type"] == "code")


def test_what_texts_and_examples_import_is_public():
    imports = {}
    for path, code in code_of_texts():
        for module, names in re.findall(r"^ *from (tracer\S*) import (.*)", code, re.MULTILINE):
            imports |= {(module, name.strip()): path for name in names.strip("() ").split(",")}
    assert len(imports) > 10
    for (module, name), path in imports.items():
        value = resolve(f"{module}.{name}")
        assert any(value is public for public in [*PUBLIC, *DOCUMENTED.values()]), (module, name, path.name)


def test_members_that_are_listed_exist():
    for _, path, options in DIRECTIVES:
        for names in re.findall(r":(?:exclude-)?members: (.*)", options):
            value = resolve(path)
            known = {*dir(value), *getattr(value, "__annotations__", ())}
            assert not set(names.split(", ")) - known, path


def test_all_settings_are_listed():
    names = next(options for _, path, options in DIRECTIVES if path == "tracer.Settings")
    assert set(names.strip().removeprefix(":members: ").split(", ")) == set(tracer.Settings.model_fields)


@pytest.mark.parametrize("path", [path for path, value in DOCUMENTED.items() if callable(value)])
def test_every_public_name_has_an_example_or_names_one(path):
    value = DOCUMENTED[path]
    texts = [documentation(value), documentation(importlib.import_module(value.__module__))]
    assert any("Example:" in text or re.search(r"has an\s+example|in the\s+example of", text) for text in texts)


@pytest.mark.parametrize("path", [path for path, value in DOCUMENTED.items() if "Example::" in documentation(value)])
def test_the_examples_of_the_reference_run(path, scene_file, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(registry, "registered", dict(registry.registered))
    mpl.use("agg")
    scene_file(LIT)
    for example in EXAMPLE.findall(documentation(DOCUMENTED[path])):
        code = textwrap.dedent(example)
        assert "tracer" in code
        exec(compile(code, f"<example of {path}>", "exec"), {"__name__": "example"})


@pytest.mark.parametrize("path", [path for path, value in DOCUMENTED.items() if ">>>" in documentation(value)])
def test_the_sessions_of_the_reference_are_true(path):
    session = doctest.DocTestParser().get_doctest(documentation(DOCUMENTED[path]), {}, path, None, 0)
    assert session.examples
    assert doctest.DocTestRunner().run(session).failed == 0

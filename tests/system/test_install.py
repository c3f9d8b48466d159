"""What a new user does: install the wheel in a new environment, elsewhere, and run the demo."""

import ast
import contextlib
import os
import re
import subprocess
import sys
import sysconfig
import tomllib
from importlib import metadata
from pathlib import Path
from zipfile import ZipFile

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from conftest import PATIENCE
from tracer.core.version import release

ROOT = Path(__file__).parents[2]
OPTIONAL = {"IPython", "ase", "av", "dask", "distributed", "gemmi", "meshio", "mitsuba_oidn", "tevclient"}
"""Modules that are imported only where somebody asks for what needs them; extras install them."""


def imported(path):
    """Return the first names of all modules that a file imports."""
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            yield from (alias.name.partition(".")[0] for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.level == 0:
            yield node.module.partition(".")[0]


def installed_with(package, names):
    """Add to ``names`` all packages that are installed with a package, extras left out."""
    for requirement in map(Requirement, metadata.requires(package) or []):
        name = canonicalize_name(requirement.name)
        if "extra" not in str(requirement.marker) and name not in names:
            names.add(name)
            with contextlib.suppress(metadata.PackageNotFoundError):  # on other systems
                installed_with(name, names)
    return names


def test_what_is_imported_is_installed_with_the_wheel():
    present = installed_with("mitsuba-tracer", set())
    shipped = [*(ROOT / "tracer").rglob("*.py"), *(ROOT / "plugins").glob("*.py")]
    modules = {name for path in shipped for name in imported(path)}
    modules -= {*sys.stdlib_module_names, *OPTIONAL, "tracer"}
    packages = metadata.packages_distributions()
    missing = {name for name in modules if present.isdisjoint(map(canonicalize_name, packages.get(name, [])))}
    assert not missing


def test_all_texts_name_the_same_last_release():
    last = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools_scm"]["fallback_version"]
    assert f"\nversion: {last}\n" in (ROOT / "CITATION.cff").read_text()
    assert re.findall(r"^## (\d\S*)", (ROOT / "CHANGELOG.md").read_text(), re.MULTILINE)[0] == last


@pytest.mark.parametrize(
    "version", ["0.1.0", "0.1.0.post12+g1a2b3c4", "0.1.0.post12+g1a2b3c4.d20300101", "0.1.0.dev3", "0.1.0+d20300101"]
)
def test_what_may_go_on_together_is_asked_by_the_release(monkeypatch, version):
    monkeypatch.setattr(metadata, "version", lambda name: version)
    assert release() == "0.1.0"


@pytest.mark.slow
def test_a_shallow_clone_without_tags_installs_where_there_is_no_git(tmp_path):
    if not (ROOT / ".git").exists():
        pytest.skip("this is no clone")
    clone, wheels = tmp_path / "clone", tmp_path / "wheels"
    subprocess.run(["git", "clone", "-q", "--depth", "1", "--no-tags", ROOT.as_uri(), str(clone)], check=True)
    command = [sys.executable, "-m", "pip", "wheel", "-q", "--no-deps", "--wheel-dir", str(wheels), str(clone)]
    subprocess.run(command, check=True, env={**os.environ, "PATH": str(tmp_path)})
    last = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools_scm"]["fallback_version"]
    assert [path.name.split("-")[1] for path in wheels.iterdir()] == [last]


@pytest.mark.slow
@pytest.mark.timeout(1800)
def test_wheel_runs_the_demo_outside_the_checkout(tmp_path):
    """Dependencies are those of this environment: installing them once more takes minutes."""
    subprocess.run([sys.executable, "-m", "build", "--wheel", "--outdir", str(tmp_path), str(ROOT)], check=True)
    (wheel,) = tmp_path.glob("mitsuba_tracer-*.whl")
    with ZipFile(wheel) as installed:
        folders = {name.split("/")[0] for name in installed.namelist()}
    assert {folder for folder in folders if not folder.endswith(".dist-info")} == {"tracer"}
    environment = tmp_path / "venv"
    subprocess.run([sys.executable, "-m", "venv", str(environment)], check=True)
    (site_packages,) = environment.glob("lib/python*/site-packages")
    (site_packages / "dependencies.pth").write_text(sysconfig.get_path("purelib"))  # behind what is installed here
    for module in OPTIONAL:
        (site_packages / f"{module}.py").write_text("raise ImportError")
    folder = tmp_path / "elsewhere"
    folder.mkdir()
    clean = {k: v for k, v in os.environ.items() if k not in ("PYTHONPATH", "DRJIT_LIBLLVM_PATH", "VIRTUAL_ENV")}
    install = [str(environment / "bin" / "pip"), "install", "-q", "--no-deps", "--force-reinstall", str(wheel)]
    subprocess.run(install, check=True, cwd=folder, env=clean)
    assert (site_packages / "tracer").is_dir()
    program = environment / "bin" / "tracer"
    result = subprocess.run(
        [str(program), "demo"], cwd=folder, env=clean, capture_output=True, text=True, timeout=PATIENCE
    )
    assert result.returncode == 0, result.stderr
    assert {path.name for path in folder.iterdir()} == {"tracer-demo.png", "tracer-demo.md"}
    assert "| fused |" in (folder / "tracer-demo.md").read_text()
    again = subprocess.run(
        [str(program), "demo"], cwd=folder, env=clean, capture_output=True, text=True, timeout=PATIENCE
    )
    assert again.returncode == 2
    assert "exists" in again.stderr

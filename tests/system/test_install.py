"""What a new user does: install the wheel in a new environment, elsewhere, and run the demo."""

import ast
import contextlib
import os
import re
import subprocess
import sys
import sysconfig
import tarfile
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


@pytest.fixture(scope="module")
def distributions(tmp_path_factory):
    """Build what is published, and return the source distribution and the wheel, which is built from it alone."""
    folder = tmp_path_factory.mktemp("dist")
    subprocess.run([sys.executable, "-m", "build", "--outdir", str(folder), str(ROOT)], check=True)
    (source,), (wheel,) = folder.glob("mitsuba_tracer-*.tar.gz"), folder.glob("mitsuba_tracer-*.whl")
    return source, wheel


def files_of(folder, *endings):
    """Return the paths of the files in a folder of the checkout that end so, relative to it, as text."""
    found = (path for ending in endings for path in (ROOT / folder).rglob(f"*{ending}"))
    return {path.relative_to(ROOT / folder).as_posix() for path in found}


@pytest.mark.slow
def test_the_wheel_has_the_package_with_all_its_files_and_nothing_else(distributions):
    with ZipFile(distributions[1]) as wheel:
        names = {name for name in wheel.namelist() if ".dist-info/" not in name}
        about = {name.partition(".dist-info/")[2] for name in wheel.namelist()}
    expected = {f"tracer/{name}" for name in files_of("tracer", ".py", ".typed", ".toml", ".html", ".css", ".js")}
    expected |= {f"tracer/plugins/{name}" for name in files_of("plugins", ".py")}
    expected |= {f"tracer/scenes/{name}" for name in files_of("scenes", ".py", ".xml")}
    assert {"tracer/py.typed", "tracer/study/page/page.html", "tracer/scenes/thin_rods.xml"} <= expected
    assert names == expected
    assert {"METADATA", "entry_points.txt", "licenses/LICENSE"} <= about


@pytest.mark.slow
def test_the_source_distribution_has_all_but_results(distributions):
    with tarfile.open(distributions[0]) as source:
        names = {name.partition("/")[2] for name in source.getnames()}
    folders = {name.partition("/")[0] for name in names}
    assert {"tracer", "plugins", "scenes", "tests", "docs", "examples", "benchmarks"} <= folders
    assert {"pyproject.toml", "README.md", "LICENSE", "CITATION.cff", "scenes/thin_rods.xml"} <= names
    assert "results" not in folders


@pytest.mark.slow
@pytest.mark.timeout(1800)
def test_wheel_runs_the_demo_outside_the_checkout(tmp_path, distributions):
    """Dependencies are those of this environment: installing them once more takes minutes."""
    wheel = distributions[1]
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

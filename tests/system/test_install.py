"""What a new user does: install the wheel in a new environment, elsewhere, and run the demo."""

import os
import subprocess
import sys
from pathlib import Path
from zipfile import ZipFile

import pytest

from conftest import PATIENCE

ROOT = Path(__file__).parents[2]


@pytest.mark.slow
@pytest.mark.timeout(1800)
def test_wheel_runs_the_demo_outside_the_checkout(tmp_path):
    subprocess.run([sys.executable, "-m", "build", "--wheel", "--outdir", str(tmp_path), str(ROOT)], check=True)
    (wheel,) = tmp_path.glob("mitsuba_tracer-*.whl")
    with ZipFile(wheel) as installed:
        folders = {name.split("/")[0] for name in installed.namelist()}
    assert {folder for folder in folders if not folder.endswith(".dist-info")} == {"tracer"}
    environment = tmp_path / "venv"
    subprocess.run([sys.executable, "-m", "venv", str(environment)], check=True)
    folder = tmp_path / "elsewhere"
    folder.mkdir()
    clean = {k: v for k, v in os.environ.items() if k not in ("PYTHONPATH", "DRJIT_LIBLLVM_PATH", "VIRTUAL_ENV")}
    subprocess.run([str(environment / "bin" / "pip"), "install", "-q", str(wheel)], check=True, cwd=folder, env=clean)
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

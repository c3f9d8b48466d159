"""Commands and code of the README run as they stand there, on small scenes."""

import re
import shlex
import subprocess
import sys
from importlib.resources import files
from pathlib import Path

import pytest
import trimesh

ROOT = Path(__file__).parents[2]
README = (ROOT / "README.md").read_text()
COMMANDS = [line.split("#")[0].strip() for line in re.findall(r"^    (tracer .*)", README, re.MULTILINE)]
PROGRAMS = [code for code in re.findall(r"```python\n(.*?)```", README, re.DOTALL) if "scene.xml" in code]
ROOM = """<scene version="3.0.0">
    <integrator type="path"/>
    <sensor type="perspective">
        <transform name="to_world"><lookat origin="0, 0, 3.5" target="0, 0, 0" up="0, 1, 0"/></transform>
        <film type="hdrfilm"><integer name="width" value="64"/><integer name="height" value="48"/></film>
        <sampler type="multijitter"><integer name="sample_count" value="16"/></sampler>
    </sensor>
    <shape type="cube"><boolean name="flip_normals" value="true"/></shape>
    <shape type="rectangle">
        <transform name="to_world">
            <scale value="0.3"/><rotate x="1" angle="90"/><translate x="0" y="0.99" z="0"/>
        </transform>
        <emitter type="area"><rgb name="radiance" value="8, 8, 8"/></emitter>
    </shape>
</scene>
"""
STUDY = """name = "mine"
spp = [8]
seeds = 2
reference_spp = 64
scenes = [{path = "scene.xml"}]
methods = [{name = "uniform", criterion = "uniform"}, {name = "fused", criterion = "fused"}]
"""

pytestmark = pytest.mark.slow


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Work in a folder that has the files of the README, small ones."""
    monkeypatch.chdir(tmp_path)
    scene = (files("tracer.scenes") / "lamp_and_sky.xml").read_text()
    small, count = re.subn(r'(name="(?:width|height)" value=)"\d+"', r'\1"48"', scene)
    assert count == 2
    Path("scene.xml").write_text(small)
    Path("room.xml").write_text(ROOM)
    Path("mine.toml").write_text(STUDY)
    box = trimesh.creation.box()
    for name in ("model.glb", "bunny.ply", "spot.obj"):
        box.export(name)
    return tmp_path


def test_the_readme_has_commands_and_programs():
    assert len(COMMANDS) == 9
    assert len(PROGRAMS) == 2


@pytest.mark.parametrize("command", COMMANDS)
def test_a_command_runs(command, folder):
    before = set(folder.iterdir())
    words = shlex.split(command)
    finished = subprocess.run([sys.executable, "-m", "tracer", *words[1:]], capture_output=True, text=True)
    assert finished.returncode == 0, finished.stderr
    assert set(folder.iterdir()) > before


@pytest.mark.parametrize("program", PROGRAMS)
def test_a_program_runs(program, folder):
    finished = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert finished.returncode == 0, finished.stderr


def test_the_criterion_runs_by_the_command_beside_it(folder):
    (code,) = re.findall(r"```python\n([^`]*@criterion.*?)```", README, re.DOTALL)
    Path("darkness.py").write_text(code)
    (command,) = re.findall(r"`(tracer render [^`]*darkness\.py)`", README)
    finished = subprocess.run(
        [sys.executable, "-m", "tracer", *shlex.split(command)[1:]], capture_output=True, text=True
    )
    assert finished.returncode == 0, finished.stderr
    assert Path("scene.exr").exists()

"""What the tests of ``tracer view`` share: a command called within this process, and a small scene."""

from typer.testing import CliRunner

from tracer.cli.app import app

SCENE = """<scene version="3.0.0">
    <integrator type="path"/>
    <sensor type="perspective"><transform name="to_world"><lookat origin="0,0,9" target="0,0,0" up="0,1,0"/></transform>
    </sensor>
    <shape type="cube" id="body"/>
    <shape type="sphere" id="ball">
        <point name="center" x="1.5" y="0.5" z="0.2"/>
        <float name="radius" value="0.6"/>
    </shape>
    <emitter type="constant"/>
</scene>"""
FEW = ["--side", "32", "-q"]
"""Options with which a view is quick."""


def call(*arguments):
    result = CliRunner().invoke(app, ["view", *map(str, arguments)])
    if result.exception is not None and not isinstance(result.exception, SystemExit):
        raise result.exception
    assert result.exit_code == 0, result.output
    return result.output


def names_in(folder):
    return sorted(path.name for path in folder.iterdir())

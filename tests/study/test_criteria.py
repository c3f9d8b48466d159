"""The tutorial: a criterion of one's own in one file."""

import re
from pathlib import Path

import pytest

from tracer.criteria import registry
from tracer.errors import SettingsError
from tracer.study.plan import read_plan
from tracer.study.run import run_study

TUTORIAL = (Path(__file__).parents[2] / "docs" / "how_to" / "write_a_criterion.md").read_text()


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Write the files of the tutorial, with less work in them, and forget the criterion afterwards."""
    registry.import_all()
    monkeypatch.setattr(registry, "registered", dict(registry.registered))
    (tmp_path / "darkness.py").write_text(re.search(r"```python\n(.*?)```", TUTORIAL, re.DOTALL)[1])
    plan = re.search(r"```toml\n(.*?)```", TUTORIAL, re.DOTALL)[1]
    plan = plan.replace("size = 128", "size = 12").replace("[16, 64]", "[16]").replace("seeds = 3", "seeds = 1")
    (tmp_path / "mine.toml").write_text("reference_spp = 9000\n" + plan)
    return tmp_path


@pytest.mark.slow
def test_the_tutorial(folder):
    results = run_study(read_plan(folder / "mine.toml"), folder / "mine")
    assert not results.failures
    assert {mean.method for mean in results.tables()[1]} == {"uniform", "fused", "darkness"}
    page = (folder / "mine" / "index.html").read_text()
    assert "darkness" in page
    kept = run_study(read_plan(folder / "mine.toml"), folder / "mine").kept
    assert kept == 6
    (folder / "darkness.py").write_text((folder / "darkness.py").read_text() + "# changed\n")
    assert run_study(read_plan(folder / "mine.toml"), folder / "mine").kept == 4


MISTAKES = [
    ("import nonsense\n", "darkness.py', line 1: ModuleNotFoundError: No module named 'nonsense'"),
    ("this is no Python\n", "darkness.py', line 1: SyntaxError: invalid syntax"),
    (
        'from tracer.criteria import criterion\n\n@criterion("fused", needs_radiance=True)\ndef f(e):\n    return 1\n',
        "there is a criterion 'fused' already",
    ),
    ("", "there is no criterion 'darkness'"),
]


@pytest.mark.parametrize(("code", "message"), MISTAKES)
def test_mistakes(folder, code, message):
    (folder / "darkness.py").write_text(code)
    with pytest.raises(SettingsError) as caught:
        read_plan(folder / "mine.toml")
    assert message in str(caught.value)
    assert re.match(r"mine\.toml, line \d+: ", str(caught.value))
    assert "fused" in registry.names()


def test_a_file_that_is_not_there(folder):
    (folder / "darkness.py").unlink()
    with pytest.raises(SettingsError, match=r"mine\.toml, line 3: there is no file '.*darkness\.py'"):
        read_plan(folder / "mine.toml")

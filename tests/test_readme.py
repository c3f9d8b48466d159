"""Figures in the README are those of the files that it names."""

import re
from pathlib import Path

import pytest

from tracer.study.quote import BLOCK, quote

ROOT = Path(__file__).parents[1]


TEXTS = ["README.md", "CONTRIBUTING.md", "CHANGELOG.md", "SECURITY.md", "scenes/README.md"]
TEXTS += sorted(str(path.relative_to(ROOT)) for path in (ROOT / "docs").rglob("*.md") if "gallery" not in path.parts)
LINES = 120
"""Most lines of the README: a person reads two screens."""


@pytest.mark.parametrize("name", TEXTS)
def test_quoted_tables_are_those_of_the_results(name):
    path = ROOT / name
    text = path.read_text()
    assert quote(text, path.parent) == text, f"run python -m tracer.study.quote {name}"
    assert all(block[3].count("\n") > 3 for block in BLOCK.findall(text))


def test_the_readme_is_short_and_has_one_table():
    readme = (ROOT / "README.md").read_text()
    assert readme.count("\n") <= LINES
    assert len(BLOCK.findall(readme)) == 1


def test_gains_in_the_prose_of_the_readme_are_those_of_the_tables():
    prose = " ".join((ROOT / "README.md").read_text().split())
    samples, seconds = re.search(r"the mean gain is ([\d.]+), in the same time ([\d.]+)", prose).groups()
    results = (ROOT / "results/equal_time/results.md").read_text().split("# Gains, 64 spp")[1]
    assert re.search(r"\*\*geometric mean, equal samples\*\* \| \*\*([\d.]+)", results)[1] == samples
    assert re.search(r"\*\*geometric mean, equal time\*\* \| \*\*([\d.]+)", results)[1] == seconds


@pytest.mark.parametrize("name", TEXTS)
def test_pictures_and_files_exist(name):
    for link in re.findall(r"\]\(([^)#:\s]+)(?:#[^)]*)?\)", (ROOT / name).read_text()):
        path = (ROOT / name).parent / link
        assert path.exists() or path.with_suffix(".md").exists() or "gallery" in link, link


def test_commands_install_this_project():
    """On package indexes ``tracer`` is somebody else's package: whoever follows a text of ours must not install it."""
    texts = [*ROOT.glob("*.md"), ROOT / "pyproject.toml", ROOT / ".ci" / "run"]
    texts += [path for folder in ("docs", "tracer", "plugins", "scenes") for path in (ROOT / folder).rglob("*.*")]
    readable = [path for path in texts if path.suffix in (".md", ".py", ".toml", ".html", "")]
    commands = {}
    for path in readable:
        for command in re.findall(r"pip install[^\n#`|;&]*", path.read_text()):
            commands[command.strip()] = path
    assert len(commands) > 4
    for command, path in commands.items():
        packages = re.sub(r"^pip install", "", command).replace('"', " ").replace("'", " ").split()
        assert not any(re.match(r"tracer\b", package) for package in packages), (path, command)
    assert not any("tracer[" in path.read_text().replace("mitsuba-tracer[", "") for path in readable)


def test_every_feature_that_is_claimed_has_its_test():
    """The last column of the table of features names a test of ours, where our own column says there is something."""
    tests = {
        name for path in (ROOT / "tests").rglob("test_*.py") for name in re.findall(r"def (test_\w+)", path.read_text())
    }
    rows = [
        line.split("|")[1:-1]
        for line in (ROOT / "docs/reference/comparison.md").read_text().splitlines()
        if line.startswith("| ")
    ]
    claimed = [row for row in rows if row[1].strip().startswith("✓")]
    assert len(claimed) > 30
    for row in claimed:
        assert row[-1].strip() in tests, row[0]

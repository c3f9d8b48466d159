"""Figures in the README are those of the files that it names."""

import re
from pathlib import Path

import pytest

from tracer.study.quote import BLOCK, quote

ROOT = Path(__file__).parents[1]


def test_quoted_tables_are_those_of_the_results():
    readme = (ROOT / "README.md").read_text()
    assert quote(readme, ROOT) == readme, "run python -m tracer.study.quote README.md"
    blocks = BLOCK.findall(readme)
    assert len(blocks) == 6
    assert all(block[3].count("\n") > 3 for block in blocks)


@pytest.mark.parametrize("name", ["README.md", "tracer/study/README.md", "scenes/README.md"])
def test_pictures_and_files_exist(name):
    for link in re.findall(r"\]\(([^)#:]+)(?:#[^)]*)?\)", (ROOT / name).read_text()):
        assert ((ROOT / name).parent / link).exists(), link

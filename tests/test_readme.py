"""Figures in the README are those of the files that it names."""

import re
from pathlib import Path

ROOT = Path(__file__).parents[1]


def test_quoted_tables_are_those_of_the_results():
    readme = (ROOT / "README.md").read_text()
    quoted = re.findall(r"<!-- table: (\S+) -->\n(.*?)\n<!-- end -->", readme, flags=re.DOTALL)
    assert len(quoted) == 3
    for file, block in quoted:
        assert block.strip() in (ROOT / file).read_text()
        assert block.count("\n") > 4


def test_pictures_and_files_exist():
    for link in re.findall(r"\]\(([^)#:]+)\)", (ROOT / "README.md").read_text()):
        assert (ROOT / link).exists(), link

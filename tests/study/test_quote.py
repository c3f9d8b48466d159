"""Tables that a Markdown file quotes."""

import pytest

from tracer.errors import OutputError
from tracer.study.quote import main, quote

RESULTS = "# All\n\ntext\n\n| a | b |\n|---|---|\n| 1 | 2 |\n\n## Second\n\n| c |\n|---|\n| 3 |\n"


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "r.md").write_text(RESULTS)
    return tmp_path


def test_tables_are_renewed(folder):
    text = "x\n<!-- table: r.md -->\nold\n<!-- end -->\ny\n<!-- table: r.md # Second -->\n<!-- end -->\n"
    expected = (
        "x\n<!-- table: r.md -->\n| a | b |\n|---|---|\n| 1 | 2 |\n<!-- end -->\ny\n"
        "<!-- table: r.md # Second -->\n| c |\n|---|\n| 3 |\n<!-- end -->\n"
    )
    assert quote(text, folder) == expected
    assert quote(expected, folder) == expected
    (folder / "README.md").write_text(text)
    assert main([str(folder / "README.md")]) == 0
    assert (folder / "README.md").read_text() == expected


def test_what_is_not_there(folder, capsys):
    for place, message in (
        ("no.md", "There is no file"),
        ("r.md # Third", "has no heading 'Third'"),
        ("none.md", "has no table"),
    ):
        (folder / "none.md").write_text("text")
        text = f"<!-- table: {place} -->\n<!-- end -->\n"
        with pytest.raises(OutputError, match=message):
            quote(text, folder)
        (folder / "README.md").write_text(text)
        assert main([str(folder / "README.md")]) == 2
        assert message in capsys.readouterr().err
        assert (folder / "README.md").read_text() == text

"""Hashes of source: what is seen of a change and what is not."""

from pathlib import Path

import pytest

from tracer.criteria import colour, rigau, shape_entropy
from tracer.study import oracle_measurements, source_hash
from tracer.study.source_hash import criterion_hash, hash_of, oracle_hash, render_hash, stock_hash


@pytest.fixture
def edited(monkeypatch):
    """Return a function that makes the hashes see another text in the file of a module."""

    def edit(module):
        path, read = Path(module.__file__), Path.read_bytes
        monkeypatch.setattr(Path, "read_bytes", lambda self: read(self) + (b"#" if self == path else b""))
        for cached in (render_hash, stock_hash, oracle_hash, source_hash.truth_hash):
            cached.cache_clear()

    yield edit
    monkeypatch.undo()
    for cached in (render_hash, stock_hash, oracle_hash, source_hash.truth_hash):
        cached.cache_clear()


def test_a_criterion_is_made_again_when_a_file_it_takes_functions_from_changes(edited):
    before = criterion_hash("rigau"), criterion_hash("shape_entropy")
    edited(colour)
    assert criterion_hash("rigau") != before[0]
    assert criterion_hash("shape_entropy") == before[1]


@pytest.mark.parametrize(("module", "name"), [(rigau, "rigau"), (shape_entropy, "shape_entropy")])
def test_a_criterion_is_made_again_when_its_own_file_changes_and_nothing_else_is(edited, module, name):
    before = criterion_hash(name), render_hash(), stock_hash(), oracle_hash()
    edited(module)
    assert criterion_hash(name) != before[0]
    assert (render_hash(), stock_hash(), oracle_hash()) == before[1:]


def test_an_oracle_is_made_again_when_what_it_measures_changes(edited):
    before = oracle_hash(), render_hash()
    edited(oracle_measurements)
    assert oracle_hash() != before[0]
    assert render_hash() == before[1]


def test_a_plugin_changes_every_picture(edited):
    from tracer.plugins import owen_sobol

    before = render_hash(), stock_hash(), oracle_hash()
    edited(owen_sobol)
    assert all(now != then for now, then in zip((render_hash(), stock_hash(), oracle_hash()), before, strict=True))


def test_files_are_hashed_by_content(tmp_path):
    (tmp_path / "a").write_text("1")
    (tmp_path / "b").write_text("1")
    assert hash_of([tmp_path / "a"]) == hash_of([tmp_path / "b"])
    (tmp_path / "b").write_text("2")
    assert hash_of([tmp_path / "a"]) != hash_of([tmp_path / "b"])

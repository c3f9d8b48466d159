"""Kept halves of references."""

from tracer.study.reference_half import Half


def test_a_damaged_half_is_made_anew_and_logged(tmp_path, caplog):
    assert Half.load(tmp_path / "missing.npz") is None
    assert not caplog.records
    path = tmp_path / "damaged.npz"
    path.write_bytes(b"PK\x03\x04 and no more")
    assert Half.load(path) is None
    (message,) = [record.getMessage() for record in caplog.records]
    assert message.startswith(f"'{path}' cannot be read (")

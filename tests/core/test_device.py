"""Arrays go to the device through one door, with room behind them for the packets that kernels read."""

import re
from pathlib import Path

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import tracer
from tracer.core.device import ALIGNMENT, ROOM, number_of_shape, table_by_shape, upload, upload_tensor, with_room

ROOT = Path(tracer.__file__).parent


@given(st.integers(1, 200), st.sampled_from([np.float64, np.float32, np.uint32, np.bool_]))
def test_there_is_room_for_a_packet_behind_what_is_uploaded(size, kind):
    array = (np.arange(size) % 7).astype(kind)
    found = with_room(array)
    memory = found.base
    while memory.base is not None:
        memory = memory.base
    assert np.array_equal(found, array)
    assert found.ctypes.data % ALIGNMENT == 0
    assert memory.ctypes.data + memory.nbytes >= found.ctypes.data + found.nbytes + ROOM
    widest = np.dtype(np.float64).itemsize
    assert widest * 16 <= ROOM


@pytest.mark.parametrize(
    "kind", [mi.Float, mi.Float64, mi.UInt32, mi.Int32, mi.UInt64, mi.Bool], ids=lambda k: k.__name__
)
@pytest.mark.parametrize("large", [1, 1 << 20])
def test_values_and_order_are_kept(kind, large, monkeypatch):
    monkeypatch.setattr("tracer.core.device.LARGE", large)
    array = np.arange(35).reshape(5, 7)
    for given_array in (array, array.T, array[::2], array.astype(np.float32), array.tolist()):
        expected = np.asarray(given_array).ravel().astype(kind(0).numpy().dtype)
        assert np.array_equal(upload(kind, given_array).numpy(), expected)
    assert dr.width(upload(kind, [])) == 0


def test_a_tensor_has_the_shape_of_the_array():
    array = np.random.default_rng(0).random((3, 5, 4)).astype(np.float32)
    found = upload_tensor(array)
    assert found.shape == array.shape
    assert np.array_equal(found.numpy(), array)


def test_there_is_no_other_door():
    """A NumPy array handed over as it is is read beyond its end: rarely a crash, in what is not to blame for it."""
    door = re.compile(r"mi\.(Float|U?Int|Bool|Tensor|Point|Vector|Color)\w*\([^()]*(\bnp\.|\.astype\(|\.ravel\(\))")
    plugins = [Path(each) for each in __import__("tracer.plugins").plugins.__path__]
    files = [file for folder in (ROOT, *plugins) for file in folder.rglob("*.py") if file.name != "upload.py"]
    assert len(files) > 100
    for file in files:
        assert not door.findall(file.read_text()), file


def test_a_table_holds_the_value_of_each_shape_at_its_number():
    shapes = mi.load_dict({"type": "scene", "a": {"type": "sphere"}, "b": {"type": "cube"}}).shapes()
    numbers = [number_of_shape(shape) for shape in shapes]
    assert len(set(numbers)) == 2
    assert min(numbers) > 0
    table = table_by_shape(shapes, [7, 9]).numpy()
    assert [table[number] for number in numbers] == [7, 9]
    assert table.sum() == 16
    assert table_by_shape([], []).numpy().tolist() == [0]

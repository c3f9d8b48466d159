"""What Dr.Jit records, at whatever moment Python has garbage to collect."""

import gc

import drjit as dr
import mitsuba as mi

from tracer.sampling.recordable import Recordable

collecting = []
"""Whether Python could collect garbage at each tracing. Not in a closure, which would be an input of the recording."""


def trace(numbers):
    collecting.append(gc.isenabled())
    return numbers + 1


def test_no_garbage_is_collected_while_a_function_is_recorded():
    """Dr.Jit would end the process if a scene were part of it."""
    collecting.clear()
    recordable = Recordable([], trace)
    assert list(recordable.call(mi.Float(1, 2))) == [2, 3]
    assert list(recordable.call(mi.Float(4, 5))) == [5, 6]
    assert recordable.recordable
    assert collecting
    assert not any(collecting)
    assert gc.isenabled()
    recordable.close()


def test_what_cannot_be_recorded_is_traced_anew():
    def unrecordable(numbers):
        if dr.flag(dr.JitFlag.FreezingScope):
            raise RuntimeError("This scene cannot be recorded.")
        return numbers + 1

    recordable = Recordable([], unrecordable)
    assert list(recordable.call(mi.Float(1, 2))) == [2, 3]
    assert list(recordable.call(mi.Float(4, 5))) == [5, 6]
    assert not recordable.recordable
    assert gc.isenabled()

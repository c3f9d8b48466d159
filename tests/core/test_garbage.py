"""Collections stop for as long as any pause lasts, and go on as before."""

import gc
import threading

import pytest

from tracer.core.garbage import no_collection


def test_nothing_is_collected_until_the_last_pause_ends():
    with no_collection():
        with no_collection():
            assert not gc.isenabled()
        assert not gc.isenabled()
    assert gc.isenabled()


def test_an_error_ends_the_pause():
    with pytest.raises(ZeroDivisionError), no_collection():
        1 / 0  # noqa: B018
    assert gc.isenabled()


def test_who_collects_nothing_goes_on_so():
    gc.disable()
    try:
        with no_collection():
            pass
        assert not gc.isenabled()
    finally:
        gc.enable()


def test_pauses_of_threads_overlap():
    entered, leave = threading.Event(), threading.Event()

    def pause():
        with no_collection():
            entered.set()
            leave.wait(10)

    other = threading.Thread(target=pause)
    other.start()
    entered.wait(10)
    with no_collection():
        pass
    assert not gc.isenabled()
    leave.set()
    other.join()
    assert gc.isenabled()

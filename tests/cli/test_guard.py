"""Programs that hang are ended, others are not; in programs of their own that render nothing."""

import os
import signal
import subprocess
import sys
import time

import pytest

from tracer.cli import guard
from tracer.cli.signals import REPEATED_SECONDS
from tracer.errors import SettingsError
from tracer.io.atomic import is_running

PROGRAM = """
import os, signal, sys, threading, time
from tracer.cli import guard
guard.AT_ONCE_SECONDS = 1.0

def deaf():  # as code of Mitsuba is, in which no handler of Python's runs
    signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGINT, signal.SIGTERM])
    print(os.getpid(), flush=True)
    while True:
        time.sleep(1)

def slow():
    def end(number, frame):
        time.sleep(1.0)
        os._exit(128 + number)
    signal.signal(signal.SIGTERM, end)
    print(os.getpid(), flush=True)
    while True:
        time.sleep(1)

def busy():
    signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGINT, signal.SIGTERM])
    print(os.getpid(), flush=True)
    while True:
        pass

guard.guarded(globals()[sys.argv[1]])
"""


def start(work, seconds):
    environment = {**os.environ, "TRACER_GRACE": str(seconds)}
    command = [sys.executable, "-c", PROGRAM, work]
    program = subprocess.Popen(
        command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, bufsize=1
    )
    return program, int(program.stdout.readline())


def finish(program):
    _, err = program.communicate(timeout=60)
    return program.returncode, err


@pytest.mark.parametrize("work", ["deaf", "busy"])
def test_what_hangs_is_killed_after_the_grace_and_says_so(work):
    program, child = start(work, 1.5)
    begin = time.monotonic()
    program.send_signal(signal.SIGTERM)
    code, err = finish(program)
    assert code == 143
    assert time.monotonic() - begin > 1.4
    assert err.startswith("tracer: killed, as it did not end after SIGTERM")
    assert err.count("\n") == 1
    assert not is_running(child)


def test_what_ends_in_time_is_left_alone():
    program, _ = start("slow", 30)
    program.send_signal(signal.SIGTERM)
    assert finish(program) == (143, "")


def test_after_ctrl_c_a_person_has_the_time_they_want_and_a_second_one_ends_it():
    program, child = start("deaf", 0.2)
    program.send_signal(signal.SIGINT)
    time.sleep(REPEATED_SECONDS + 2.0)  # a busy machine passes the first one on late
    assert is_running(child)
    program.send_signal(signal.SIGINT)
    code, err = finish(program)
    assert code == 130
    assert "did not end after SIGINT" in err


def test_the_same_signal_twice_at_once_is_one():
    """As from a terminal, which sends it to all processes of a command."""
    program, _ = start("slow", 30)
    program.send_signal(signal.SIGTERM)
    program.send_signal(signal.SIGTERM)
    assert finish(program) == (143, "")


@pytest.mark.parametrize("said", ["soon", "0", "-1", "inf", "nan"])
def test_a_grace_that_is_no_number_of_seconds_is_refused(monkeypatch, said):
    monkeypatch.setenv("TRACER_GRACE", said)
    with pytest.raises(SettingsError, match=f"TRACER_GRACE is a number of seconds above 0, not '{said}'"):
        guard.grace()


def test_the_grace_is_that_of_the_documentation(monkeypatch):
    monkeypatch.delenv("TRACER_GRACE", raising=False)
    assert guard.grace() == 25

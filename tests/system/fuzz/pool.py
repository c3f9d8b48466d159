"""Runs inputs in workers, and notices when one dies or hangs."""

import contextlib
import json
import os
import queue
import select
import shutil
import subprocess
import sys
import threading
import time
from dataclasses import dataclass
from pathlib import Path
from random import Random

from .kinds import KINDS

WORKER = Path(__file__).with_name("worker.py")
SECONDS = 150.0
"""After which an input is taken to hang: far more than any needs, as a machine may be slow and shared."""
RENEWED_AFTER = 250
"""Inputs after which a worker is replaced, as Mitsuba keeps some memory of every scene."""


@dataclass
class Outcome:
    """What became of an input."""

    kind: str
    seed: int
    arguments: list[str]
    folder: Path
    seconds: float
    code: int | None
    """Exit code; negative for the signal that ended the process; None if it hung."""
    out: str
    err: str
    stray: list[str]
    """Files that were made, changed or removed where nothing should have been."""

    def __str__(self):
        ended = "hung" if self.code is None else f"code {self.code}"
        return f"{self.kind} {self.seed}: {ended}, {self.seconds:.1f} s: {self.err.strip()[-300:] or self.out[-300:]}"


class Worker:
    """One child process, started anew when it is gone."""

    def __init__(self, folder):
        self.folder = folder
        self.temporary = folder / "tmp"
        self.temporary.mkdir(parents=True)
        self.process, self.inputs = None, 0

    def start(self):
        environment = {**os.environ, "TMPDIR": str(self.temporary), "COLUMNS": "200", "NO_COLOR": "1", "TERM": "dumb"}
        self.process = subprocess.Popen(
            [sys.executable, WORKER, self.folder / "out.txt", self.folder / "err.txt"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            env=environment,
            text=True,
        )
        self.inputs = 0

    def stop(self):
        if self.process is not None:
            with contextlib.suppress(BrokenPipeError):
                self.process.stdin.close()
            self.process.kill()
            self.process.wait()
            self.process.stdout.close()
            self.process = None

    def ask(self, arguments, folder):
        """Return the exit code of a command, minus a signal, or None for one that takes too long."""
        if self.process is None or self.inputs >= RENEWED_AFTER:
            self.stop()
            self.start()
        self.inputs += 1
        self.process.stdin.write(json.dumps({"arguments": arguments, "folder": str(folder)}) + "\n")
        self.process.stdin.flush()
        ready, _, _ = select.select([self.process.stdout], [], [], SECONDS)
        answer = self.process.stdout.readline() if ready else None
        if answer:
            return json.loads(answer)["code"]
        code = self.process.wait() if ready else None
        self.stop()
        return code

    def run(self, kind, seed):
        """Make an input, run it and return what became of it. Its folder is left for who looks at the outcome."""
        place = self.folder / f"{kind.replace(' ', '_')}-{seed}"
        for name in ("in", "out", "here"):
            (place / name).mkdir(parents=True)
        arguments = KINDS[kind](Random(f"{kind} {seed}"), place / "in")
        before = tree(place)
        start = time.monotonic()
        code = self.ask(arguments, place / "here")
        seconds = time.monotonic() - start
        texts = [(self.folder / name).read_text(errors="replace") for name in ("out.txt", "err.txt")]
        after = tree(place)
        stray = sorted(name for name in {*before, *after} if before.get(name) != after.get(name))
        stray += sorted(str(path) for path in self.temporary.rglob("*"))
        return Outcome(kind, seed, arguments, place, seconds, code, *texts, stray)


def tree(folder):
    """Return size and time of every file in a folder, by name; of the folder of results only if it is gone."""
    found = {}
    for path in folder.rglob("*"):
        name = str(path.relative_to(folder))
        if not name.startswith("out/") and path.is_file():
            status = path.lstat()
            found[name] = status.st_size, status.st_mtime_ns
    return found


def run_all(inputs, folder, workers, judge):
    """Return ``judge`` of the outcome of each of ``inputs``, (kind, seed); what is made for them is then removed."""
    waiting = queue.SimpleQueue()
    for one in inputs:
        waiting.put(one)
    verdicts = []

    def work(number):
        worker = Worker(folder / f"worker{number}")
        try:
            while True:
                outcome = worker.run(*waiting.get_nowait())
                verdicts.append(judge(outcome))
                shutil.rmtree(outcome.folder)
        except queue.Empty:
            return
        finally:
            worker.stop()

    threads = [threading.Thread(target=work, args=(number,)) for number in range(workers)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    return verdicts

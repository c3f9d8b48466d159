"""Run inputs by hand: ``python -m fuzz.explore KIND FIRST COUNT`` in ``tests/system``; KIND may be ``all``."""

import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

import tracer

from .kinds import KINDS
from .pool import run_all
from .verdict import complaint


def main(kind, first, count):
    tracer.activate("llvm_ad_rgb")
    kinds = list(KINDS) if kind == "all" else kind.split(",")
    inputs = [(name, seed) for seed in range(int(first), int(first) + int(count)) for name in kinds]
    start = time.monotonic()
    with tempfile.TemporaryDirectory() as folder:
        verdicts = run_all(inputs, Path(folder), 2, lambda outcome: (outcome, complaint(outcome)))
    codes, seconds = Counter(), Counter()
    for outcome, wrong in sorted(verdicts, key=lambda one: (one[0].kind, one[0].seed)):
        codes[outcome.kind, outcome.code] += 1
        seconds[outcome.kind] += outcome.seconds
        if wrong:
            print(f"FAIL {outcome}\n     {wrong}")
        elif len(inputs) < 30:
            print(f"ok   {outcome}")
    for name in kinds:
        print(f"{name:16s} {seconds[name]:6.1f} s", {code: n for (kind, code), n in codes.items() if kind == name})
    print(f"{len(verdicts)} inputs, {time.monotonic() - start:.0f} s")


if __name__ == "__main__":
    main(*sys.argv[1:])

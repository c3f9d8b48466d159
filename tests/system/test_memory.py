"""Memory depends on pixels and pass size, not on the number of samples."""

import subprocess
import sys
from pathlib import Path

import pytest

SCRIPT = """
import resource, sys
import tracer
tracer.activate()
from conformance.cases import scene
description = scene()
description["sensor"]["film"] |= {"width": 1600, "height": 1200}
tracer.render(description, spp=int(sys.argv[1]))
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
"""
BYTES_PER_PIXEL = 1000
BYTES_PER_PASS = 1.5e9


@pytest.mark.slow
def test_peak_is_bounded():
    folder = Path(__file__).parents[1]
    peaks = []
    for spp in (16, 128):
        run = subprocess.run(
            [sys.executable, "-c", SCRIPT, str(spp)], check=True, capture_output=True, text=True, cwd=folder
        )
        peaks.append(1024 * int(run.stdout))
    print([f"{peak / 1e9:.2f} GB" for peak in peaks])
    assert max(peaks) < 1600 * 1200 * BYTES_PER_PIXEL + BYTES_PER_PASS
    assert peaks[1] < 1.3 * peaks[0]

"""Memory depends on pixels and pass size, not on the number of samples; it is foretold, and kept within a limit."""

import subprocess
import sys
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

import tracer
from tracer.errors import SettingsError
from tracer.sampling.passes import PASS_SIZES
from tracer.scene.frame import PlainFrame
from tracer.session.memory import GIB, SMALLEST_PASS, largest_pass, most_learning_paths, need
from tracer.settings import make_settings

SCRIPT = """
import sys
import tracer
tracer.activate()
from conformance.cases import scene
description = scene()
description["sensor"]["film"] |= {"width": int(sys.argv[2]), "height": int(sys.argv[3])}
limit = float(sys.argv[4]) or None
more = {"": {}, "denoise": {"denoise": True, "features": True}}
keeps = more.get(sys.argv[5], {"checkpoint": sys.argv[5]}) if len(sys.argv) > 5 else {}
tracer.render(description, spp=int(sys.argv[1]), memory_limit=limit, **keeps)
# Not ru_maxrss: that counts the process it was started from.
print(next(line.split()[1] for line in open("/proc/self/status") if line.startswith("VmHWM")))
"""
BYTES_PER_PIXEL = 1000
BYTES_PER_PASS = 1.5e9


def peak(*arguments):
    """Return the most bytes that a render takes: spp, width, height, limit in GiB (0: none), file of a checkpoint."""
    folder = Path(__file__).parents[1]
    command = [sys.executable, "-c", SCRIPT, *map(str, arguments)]
    return 1024 * int(subprocess.run(command, check=True, capture_output=True, text=True, cwd=folder).stdout)


@pytest.mark.slow
def test_peak_is_bounded():
    peaks = [peak(spp, 1600, 1200, 0) for spp in (8, 32)]
    print([f"{each / 1e9:.2f} GB" for each in peaks])
    assert max(peaks) < 1600 * 1200 * BYTES_PER_PIXEL + BYTES_PER_PASS
    assert peaks[1] < 1.3 * peaks[0]


@pytest.mark.slow
@pytest.mark.parametrize(("width", "height", "limit"), [(256, 256, 0.42), (1280, 720, 1.4)])
def test_a_limit_is_kept(tmp_path, width, height, limit):
    plain = peak(32, width, height, limit)
    kept = peak(32, width, height, limit * 1.2, tmp_path / "state.ckpt")
    denoised = peak(8, width, height, limit * 3, "denoise")
    print(f"{plain / GIB:.2f} GiB of {limit}, {kept / GIB:.2f} with a checkpoint, {denoised / GIB:.2f} denoised")
    assert denoised < 3 * limit * GIB
    assert plain < limit * GIB
    assert kept < 1.2 * limit * GIB


def test_what_a_limit_does_not_hold_is_refused_before_the_first_ray(cornell):
    with pytest.raises(SettingsError, match=r"needs about .* GiB, of which pixels take .*, and may take 2;"):
        tracer.render(cornell(size=(4000, 3000)), spp=1, memory_limit=2.0)


def test_less_is_learned_where_memory_is_short():
    found = need(PlainFrame((100, 100), 0, ["R"] * 3, 2, (0, 0, 100, 100)), make_settings())
    taken = found.total(0) / GIB
    assert most_learning_paths(found, None, 1 << 20) == 1 << 20
    assert most_learning_paths(found, taken, 1 << 20) == 0
    assert 0 < most_learning_paths(found, taken + 0.5, 1 << 20) < 1 << 20
    assert most_learning_paths(found, taken + 4, 1 << 20) == 1 << 20


@given(limit=st.floats(0.5, 64.0), channels=st.integers(1, 12), side=st.integers(1, 4000))
def test_passes_are_the_largest_that_fit(limit, channels, side):
    found = need(PlainFrame((side, side), 0, ["R"] * channels, 2, (0, 0, side, side)), make_settings())
    try:
        size = largest_pass(found, limit)
    except SettingsError:
        assert found.total(SMALLEST_PASS) > limit * GIB
    else:
        assert found.total(size) <= limit * GIB
        assert size == PASS_SIZES[-1] or found.total(2 * size) > limit * GIB

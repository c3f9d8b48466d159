"""What is known here of sums that are with workers."""

from types import SimpleNamespace

import numpy as np
import pytest

from tracer.cluster.remote_estimate import RemoteEstimate, nothing
from tracer.cluster.work_balancer import Region
from tracer.film.estimate import Estimate, Statistics
from tracer.scene.frame import PlainFrame

FRAME = PlainFrame((4, 6), 1, ["R", "G", "B"], 1, (0, 0, 6, 4))


@pytest.fixture
def held():
    """Return an estimate that counts how often its sums are brought here."""
    gathered = []
    keeper = SimpleNamespace(gather=lambda _: gathered.append(1) or len(gathered), scatter=lambda _: [Region(0, 48)])
    return RemoteEstimate(FRAME, 2, 1, keeper)


def row(count, invalid=0):
    """Return statistics of a grid of one row, all alike."""
    size = (1, len(count))
    made = {name: np.ones((*size, depth), np.float32) for name, depth in (("mean", 3), ("variance", 3), ("moments", 2))}
    invalid = np.full(size, invalid, np.uint32)
    peaks = np.full((*size, 1), 7, np.float32)
    return Statistics(np.array([count], np.uint32), invalid, work=np.ones(size, np.float32), peaks=peaks, **made)


def test_nothing_is_what_an_estimate_knows_without_samples():
    found, expected = nothing(FRAME, 2, 1), Estimate(FRAME, 2, 1).statistics()
    for name, values in vars(expected).items():
        assert np.array_equal(getattr(found, name), values), name
        assert getattr(found, name).dtype == values.dtype


def test_what_a_region_tells_is_written_to_its_pixels(held):
    held.learn(Region(10, 5), row([1, 2, 3, 4, 5], invalid=2))
    assert held.drawn().ravel()[9:16].tolist() == [0, 3, 4, 5, 6, 7, 0]
    assert np.array_equal(np.flatnonzero(held.statistics().mean[..., 0]), np.arange(10, 15))
    # Pixels 10 to 14 are the last five inner columns of the first inner row of a grid of 8 x 6.
    assert held.samples()[0].tolist() == [0, 1, 2, 3, 4, 5]
    assert held.samples().sum() == 15
    assert [region.size for region in held.sums.regions] == [10, 5, 33]


def test_sums_are_brought_again_only_when_there_are_others(held):
    assert (held.here(), held.here()) == (1, 1)
    held.learn(Region(0, 2), row([1, 1]))
    assert held.here() == 2


def test_sums_of_an_earlier_render_are_kept_and_taken_to_workers(held):
    whole = Estimate(FRAME, 2, 1)
    layout, *arrays = whole.blank()
    arrays[0][:] = 3  # counts
    held.restore([layout, *arrays])
    assert np.array_equal(held.sums.begun[0], arrays[0])
    assert held.sums.regions == [Region(0, 48)]
    assert held.drawn().tolist() == np.full(FRAME.grid, 3).tolist()
    assert held.here() is held.whole_here

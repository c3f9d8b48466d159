"""Samples that teach and judge are spread over the whole picture, whatever its size."""

import numpy as np
import pytest

from tracer.guiding.chosen import choose, samples, spread


@pytest.mark.parametrize("grid", [(1024, 1024), (2048, 2048), (720, 1280), (768, 1024), (1, 4000), (4000, 1)])
def test_pixels_are_spread_over_rows_and_columns(grid):
    """Every n-th pixel would lie in a few columns of a picture whose width is a power of two."""
    row, column = np.divmod(spread(grid, 0, 2000, 0.25), grid[1])
    for place, side in zip((row, column), grid, strict=True):
        assert place.max() < side
        counts = np.histogram(place, bins=min(side, 20), range=(0, side))[0]
        assert counts == pytest.approx(2000 / len(counts), rel=0.1)


def test_they_go_on_where_they_were():
    assert np.array_equal(spread((30, 40), 0, 300, 0.0)[100:], spread((30, 40), 100, 200, 0.0))


def test_no_sample_is_drawn_twice():
    pixel, sequence, index = samples(spread((3, 5), 0, 400, 0.0), 8)
    assert len(set(zip(pixel.tolist(), sequence.tolist(), index.tolist(), strict=True))) == 400 * 16
    assert index.max() < 400 * 8


def test_those_that_judge_come_first_and_are_the_same():
    first, second = (choose((300, 400), 100, 16, *teachers) for teachers in ((0, 500), (500, 3000)))
    assert first.judge_count == second.judge_count == 100 * 32
    for name in ("pixel", "sequence", "index"):
        assert np.array_equal(*(getattr(chosen, name)[: 100 * 32] for chosen in (first, second)))
    assert len(first.pixel) == 100 * 32 + 500 * 2
    assert first.sequence[:32].tolist() == [0] * 16 + [1] * 16
    assert first.index[:32].tolist() == [*range(16), *range(16)]
    assert np.all(first.pixel[3200:].reshape(-1, 2) == first.pixel[3200::2, None])
    assert first.sequence[3200:].tolist() == [0, 1] * 500

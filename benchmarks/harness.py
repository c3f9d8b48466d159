"""Code that all benchmarks share: counted steps, ratios with intervals, pages of sections, figures, whole files."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from importlib.resources import files as package_files
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import ArrayLike
from scipy import stats

from tracer.core import backend
from tracer.io import atomic
from tracer.progress import StepCallback
from tracer.study.gains import LEVEL, Interval
from tracer.study.write import finite

NUMBERS, PAGE = "results.json", "results.md"
"""Names of the files of results that every benchmark writes, beside its figures."""
Announce = Callable[[str], None]
"""Function that is called with the name of each step as it begins. Raises KeyboardInterrupt if the user wants to
stop."""


class StepCounter:
    """Passes the steps of a benchmark on to a progress bar; called with the name of each step as it begins."""

    def __init__(self, progress: StepCallback, total: int) -> None:
        self.progress, self.total, self.done = progress, total, 0

    def __call__(self, name: str) -> None:
        """Show the step that begins. Raises KeyboardInterrupt if the user wants to stop."""
        if self.progress(name, self.done, self.total) is False:
            raise KeyboardInterrupt
        self.done += 1


def bundled_scenes() -> list[Path]:
    """Return the files of the scenes that come with tracer, in the order of their names."""
    return sorted(Path(str(package_files("tracer.scenes"))).glob("*.xml"))


def written_by(name: str) -> str:
    """Return the beginning of a page, which names the command that wrote it."""
    return f"Written by `python -m benchmarks {name}`"


def machine() -> str:
    """Return the processor and the number of threads with which the times of a page were measured."""
    return f"{backend.processor()} with {backend.thread_count()} threads"


def ratio_over_seeds(errors: ArrayLike, baseline: ArrayLike) -> Interval:
    """Return the ratio of ``baseline`` to ``errors``, both (S,) with an entry for each seed.

    It is the geometric mean over seeds with its 95 % interval, Student's interval for the mean of the logarithms.
    """
    logarithms = np.log(np.asarray(baseline)) - np.log(np.asarray(errors))
    mean, seeds = float(logarithms.mean()), len(logarithms)
    reach = float(stats.t.ppf((1 + LEVEL) / 2, seeds - 1) * logarithms.std(ddof=1) / np.sqrt(seeds))
    return Interval(float(np.exp(mean)), float(np.exp(mean - reach)), float(np.exp(mean + reach)))


def middle_and_range(middle: float, values: Sequence[float]) -> str:
    """Return a mean or median as text, with the smallest and the largest of the values in brackets."""
    return f"{middle:.2f} [{min(values):.2f}, {max(values):.2f}]"


def page(title: str, introduction: str, sections: Mapping[str, str]) -> str:
    """Return a Markdown page; ``sections`` maps headings to texts. The introduction may be empty."""
    parts = [f"# {title}", introduction, *(f"## {heading}\n\n{text.strip()}" for heading, text in sections.items())]
    return "\n\n".join(part.strip() for part in parts if part) + "\n"


@contextmanager
def figure(path: Path, width: float, height: float, dpi: int = 110) -> Iterator[Figure]:
    """Yield an empty figure, ``width`` x ``height`` inches, and write it once the block has drawn it."""
    empty_figure = Figure(figsize=(width, height), layout="constrained")
    yield empty_figure
    with atomic.whole(path) as temporary:
        empty_figure.savefig(temporary, dpi=dpi)


def measured_before(folder: Path, resume: bool) -> dict[str, Any]:
    """Return the results that a folder has as plain values, if they are to be kept; else nothing."""
    return dict(json.loads((folder / NUMBERS).read_text())) if resume else {}


def write(folder: Path, numbers: Any, text: str) -> None:
    """Write the results as plain values, with null for NaN and infinities, and the page that shows them."""
    atomic.write_text(folder / NUMBERS, json.dumps(finite(numbers), indent=1, allow_nan=False) + "\n")
    atomic.write_text(folder / PAGE, text)

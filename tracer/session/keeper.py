"""Keep the state of a render in a checkpoint while it is under way, and go on from there."""

from __future__ import annotations

import time
from dataclasses import dataclass, field, replace
from typing import Any

from tracer.core.arrays import Floats
from tracer.core.wording import option
from tracer.denoising.refilter import FilterShape
from tracer.errors import CheckpointError, OutputError
from tracer.film.estimate import Estimate
from tracer.scene.view import View
from tracer.session import checkpoint
from tracer.session.checkpoint import Checkpoint, differences, identity_of
from tracer.session.request import CheckpointFile, Request
from tracer.session.state import State
from tracer.settings import Settings

LONGEST_SHARE = 0.05
"""Most of the time that is spent on writing checkpoints, but for the last."""


@dataclass
class Writes:
    """The writes of a file so far."""

    every: float
    """Seconds between two of them, or more if they take long."""
    count: int = 0
    last: float = field(default_factory=time.monotonic)
    """When the last one ended, or the render began."""
    took: float = 0.0
    """Seconds that the last one took."""

    def are_due(self) -> bool:
        """Return whether it is time for the next."""
        return time.monotonic() - self.last >= max(self.every, self.took / LONGEST_SHARE)

    def note(self, start: float) -> None:
        """Note one that began at ``start`` and has ended."""
        self.last = time.monotonic()
        self.took = self.last - start
        self.count += 1


class Keeper:
    """Keeps the state of one render in a file."""

    def __init__(self, file: CheckpointFile, header: Checkpoint, at_risk: bool = False) -> None:
        """``header``: what the file says of the render, without its state; ``at_risk``: see ``save_after_round``."""
        self.path, self.goes_on, self.header = file.path, file.goes_on, header
        self.at_risk = at_risk
        self.writes = Writes(file.every)
        self.complaints: list[str] = []
        """Sentences about the last write, if it failed."""
        self.kept = 0
        """Samples that the file has."""

    def load(self, beginning: State, empty: Estimate) -> State:
        """Return the state of the file, or ``beginning`` if there is none. Raises CheckpointError.

        ``empty``: another estimate without samples, for those that are held out.
        """
        if not self.goes_on:
            return beginning
        stored = checkpoint.read(self.path)
        if other := differences(self.header.identity, stored.identity):
            raise CheckpointError(
                f"Checkpoint '{self.path}' is of another render: {'; '.join(other)}. "
                "Resume it as it was begun, or name another file."
            )
        if "generator" not in stored.plain:
            raise CheckpointError(f"'{self.path}' is a merge; it can be merged further, but not rendered on from.")
        try:
            beginning.unpack(stored.arrays, stored.plain, empty)
        except (ValueError, KeyError, TypeError, AttributeError, OverflowError):
            raise CheckpointError(f"'{self.path}' is a damaged checkpoint; remove it to begin anew.") from None
        self.kept = beginning.done
        return beginning

    def save_if_due(self, state: State) -> None:
        """Write the file if it is time."""
        if self.writes.are_due():
            self.save(state)

    def save_after_round(self, state: State) -> None:
        """Write the file if it is time, or if sums are at risk, as they can be lost elsewhere, and there is no file."""
        if self.writes.are_due() or (self.at_risk and self.writes.count == 0):
            self.save(state)

    def save(self, state: State) -> None:
        """Write the file. That it cannot be written is kept as a complaint: the render goes on."""
        start = time.monotonic()
        arrays, plain = state.pack()
        frame = {**self.header.frame, "kinds": [state.estimate.moments, state.estimate.peaks]}
        try:
            checkpoint.write(replace(self.header, frame=frame, arrays=arrays, plain=plain))
            self.complaints.clear()
            self.kept = state.done
        except OutputError as error:
            self.complaints[:] = [f"{error} {self.what_is_there(state)}"]
        self.writes.note(start)

    def what_is_there(self, state: State) -> str:
        """Return a sentence about the file after it could not be written."""
        if self.kept:
            share = 100 * self.kept / max(state.done, 1)
            return f"The last checkpoint that could be written is still there, with {share:.3g} % of the samples."
        if self.path.exists():
            return "What was there before is still there; of this render there is no checkpoint."
        return "There is no checkpoint."

    def in_words(self, total: int) -> str:
        """Return a sentence about what the file has of ``total`` samples."""
        if self.kept == 0:
            return f"There is no checkpoint '{self.path}' yet."
        share = 100 * self.kept / total
        return f"The checkpoint '{self.path}' has {share:.1f} % of the samples; go on with {option('resume')}."

    def all_is_kept(self) -> str:
        """Return a sentence about a file that has all samples, "" if it does not."""
        if self.complaints or not self.kept:
            return ""
        return f"All samples are in the checkpoint '{self.path}'; make room and go on with {option('resume')}."


def make_keeper(
    request: Request, view: View, settings: Settings, weights: Floats, scene_hash: str, source: str, at_risk: bool
) -> Keeper | None:
    """Return what keeps the state of a render, if that is asked for.

    ``weights`` (grid): what the person wants more of; ``source``: what the samples are called; ``at_risk``: see
    ``Keeper.save_after_round``.
    """
    if request.checkpoint is None:
        return None
    frame: dict[str, Any] = {name: getattr(view, name) for name in ("size", "border", "channels", "reach", "window")}
    frame["filter"] = FilterShape.of(view.film.rfilter()).plain()
    header = Checkpoint(
        path=request.checkpoint.path,
        identity=identity_of(view, settings, weights, scene_hash),
        frame=frame,
        plain={},
        arrays={},
        settings=settings.model_dump(),
        sources=[source],
    )
    return Keeper(request.checkpoint, header, at_risk)

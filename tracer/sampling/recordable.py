"""A function of a view that Dr.Jit records, and that is traced anew where it cannot be recorded."""

from __future__ import annotations

import logging
from collections.abc import Callable
from typing import Any

import drjit as dr

from tracer.core.garbage import no_collection
from tracer.core.protocols import KeyedSampler
from tracer.scene.view import View

logger = logging.getLogger(__name__)


class Recordable:
    """Calls a function, which takes view and sampler from ``held``: what these refer to are inputs of the recording."""

    def __init__(self, held: list[Any], trace: Callable[..., Any]) -> None:
        """``held``: the view and the sampler."""
        self.held, self.trace, self.record = held, trace, dr.freeze(trace)
        self.recordable = True

    def call(self, *inputs: Any) -> Any:
        """Call the function with evaluated inputs."""
        if self.recordable:
            try:
                with no_collection():
                    return self.record(*inputs)
            except RuntimeError as error:  # an error of another cause is raised again by tracing
                self.recordable = False
                logger.info("Every pass is traced anew, as the scene cannot be recorded: %s", error)
        return self.trace(*inputs)

    def rest(self) -> None:
        """Release the view until ``reopen``."""
        self.held.clear()

    def reopen(self, view: View, sampler: KeyedSampler) -> None:
        """Go on with another view of the same scene and film, and a sampler of the same kind."""
        self.held[:] = [view, sampler]

    def close(self) -> None:
        """Release scene and kernels: a frozen function is part of a reference cycle, which would keep them."""
        self.record.clear()
        self.held.clear()

"""The pilot rays of a render, traced once, when they are first asked for."""

from __future__ import annotations

from functools import cached_property

from tracer.complexity.pilot import Complexity, measure_complexity
from tracer.sampling.samples import make_sampler
from tracer.scene.view import View
from tracer.session.recorder import Recorder
from tracer.settings import Settings


class FirstLook:
    """What pilot rays say of a view. They are keyed: whenever they are traced, they say the same."""

    def __init__(self, view: View, settings: Settings, recorder: Recorder) -> None:
        self.view, self.settings, self.recorder = view, settings, recorder

    @cached_property
    def complexity(self) -> Complexity:
        """Of what the rays hit."""
        settings = self.settings
        with self.recorder.timing("seconds_pilot"):
            return measure_complexity(self.view, make_sampler(), settings.seed, settings.pilot_rays, settings.block)

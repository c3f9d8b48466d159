"""What Mitsuba hands over, as far as tracer uses it: for editors and type checkers, in public signatures.

The classes of Mitsuba are others in every variant and exist only once one is active, so no signature can name them.
Each protocol lists what is asked of such an object, with the types that Python sees.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol


class Sampler(Protocol):
    """A source of random numbers: ``mi.Sampler``."""

    def sample_count(self) -> int:
        """Return the samples per pixel that it is made for."""

    def seed(self, seed: Any, wavefront_size: Any = ...) -> None:
        """Begin the sequence ``seed`` anew, for so many samples at once."""

    def next_1d(self, active: Any = ...) -> Any:
        """Return a number in [0, 1) for every sample, as ``mi.Float``."""

    def next_2d(self, active: Any = ...) -> Any:
        """Return a point in [0, 1)^2 for every sample, as ``mi.Point2f``."""


class Sensor(Protocol):
    """A camera with its film and its sampler: ``mi.Sensor``."""

    def film(self) -> Any:
        """Return the film, ``mi.Film``, which knows the size of the picture in pixels and its filter."""

    def sampler(self) -> Sampler:
        """Return the sampler of the scene; tracer takes only the number of samples from it."""


class Integrator(Protocol):
    """What computes radiance along rays of the camera: ``mi.SamplingIntegrator``."""

    def sample(self, scene: Any, sampler: Any, ray: Any, medium: Any = ..., active: Any = ...) -> Any:
        """Return radiance, whether the ray hit anything, and the values of AOVs."""

    def aov_names(self) -> Sequence[str]:
        """Return the names of the AOVs."""


class Scene(Protocol):
    """A loaded scene: ``mi.Scene``."""

    def sensors(self) -> Sequence[Any]:
        """Return the sensors, in the order of their numbers."""

    def integrator(self) -> Any:
        """Return the integrator that the scene asks for, or None."""

    def shapes(self) -> Sequence[Any]:
        """Return the shapes, in the order of their numbers."""

    def emitters(self) -> Sequence[Any]:
        """Return the lights."""

"""How rays leave a viewpoint: through an image, with parallel rays or from a point, or into all directions.

A lens maps a square [0, 1)^2 to rays. Each ray stands for a part of the *image*: a part of its area (parallel rays) or
of the solid angle that it covers (rays from a point), so that a surface counts as much at the edge as in the middle.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from tracer.core.arrays import Floats


class Lens(ABC):
    """The rays of a viewpoint, in the frame of the viewpoint: x right, y up, z backwards."""

    @abstractmethod
    def ray(self, u: Any, v: Any) -> tuple[Any, Any, Any]:
        """Return (origin, unit direction, weight) for places (mi.Float) in the square; v goes down.

        The weight is the area of the image per area of the square; its mean is ``image_area``.
        """

    @property
    @abstractmethod
    def image_area(self) -> float:
        """Area of the image: in squared units of length for parallel rays, else steradians."""

    def random_ray(self, u: Any, v: Any) -> tuple[Any, Any, Any]:
        """Return what ``ray`` does, but with rays spread so that all weights are ``image_area``, for random rays."""
        return self.ray(u, v)

    @abstractmethod
    def toward(self, places: Floats) -> tuple[Floats, NDArray[np.bool_]]:
        """Return (starts (..., 3), inside (...)) of the rays to places (..., 3), in the frame of the viewpoint.

        This is the reverse of ``ray``. ``inside``: whether the place is within the image; if not, any start may be
        returned.
        """

    wraps = False
    """Whether the left edge of the square is also its right one."""
    aspect = 1.0
    """Width of the image over its height, and of the columns of a grid of rays over its rows."""

    @property
    def most(self) -> float:
        """Largest weight of a ray."""
        return self.image_area

    def mean_weight(self, columns: int, rows: int) -> float:
        """Return the mean weight of a grid of ``columns`` x ``rows`` rays."""
        return self.image_area


@dataclass(frozen=True)
class Orthographic(Lens):
    """Parallel rays through a square window of ``2 reach`` a side, in the unit of length of the scene.

    ``tracer.viewpoint.survey.survey`` has an example.
    """

    reach: float
    """Half the side of the window."""

    def ray(self, u: Any, v: Any) -> tuple[Any, Any, Any]:
        """See ``Lens.ray``."""
        reach = dr.opaque(mi.Float, self.reach)
        origin = mi.Point3f((2 * u - 1) * reach, (1 - 2 * v) * reach, 0)
        return origin, mi.Vector3f(0, 0, -1), 4 * dr.square(reach)

    def toward(self, places: Floats) -> tuple[Floats, NDArray[np.bool_]]:
        """See ``Lens.toward``."""
        inside = (np.abs(places[..., :2]).max(axis=-1) <= self.reach) & (places[..., 2] < 0)
        return places * [1.0, 1.0, 0.0], inside

    @property
    def image_area(self) -> float:
        """See ``Lens.image_area``."""
        return 4 * self.reach**2


@dataclass(frozen=True)
class Perspective(Lens):
    """A pinhole with a square image, ``field_of_view`` degrees wide, less than 180.

    It takes the place of ``Orthographic`` in the example of ``tracer.viewpoint.survey.survey``.
    """

    field_of_view: float
    """Angle between opposite sides of the image, in degrees."""

    @property
    def reach(self) -> float:
        """Half the side of the image at distance 1."""
        return float(np.tan(np.radians(self.field_of_view) / 2))

    def ray(self, u: Any, v: Any) -> tuple[Any, Any, Any]:
        """See ``Lens.ray``; a pixel at angle t from the axis covers cos^3 t of the solid angle of one in the middle."""
        reach = dr.opaque(mi.Float, self.reach)
        x, y = (2 * u - 1) * reach, (1 - 2 * v) * reach
        cosine = dr.rsqrt(1 + dr.square(x) + dr.square(y))
        return mi.Point3f(0), mi.Vector3f(x, y, -1) * cosine, 4 * dr.square(reach) * cosine * dr.square(cosine)

    def random_ray(self, u: Any, v: Any) -> tuple[Any, Any, Any]:
        """See ``Lens.random_ray``; uniform in solid angle, with x from its marginal distribution, then y given x.

        The density cos^3 t / area has the distribution atan(r x / sqrt(1 + r^2 + x^2)) of x, and given x that of y is
        y / sqrt(1 + x^2 + y^2), both up to a factor; r is the reach.
        """
        r = dr.opaque(mi.Float, self.reach)
        tangent = dr.tan((2 * u - 1) * dr.atan(dr.square(r) * dr.rsqrt(1 + 2 * dr.square(r))))
        x = tangent * dr.sqrt((1 + dr.square(r)) / (dr.square(r) - dr.square(tangent)))
        sine = (1 - 2 * v) * r * dr.rsqrt(1 + dr.square(r) + dr.square(x))
        y = sine * dr.sqrt((1 + dr.square(x)) / (1 - dr.square(sine)))
        return mi.Point3f(0), dr.normalize(mi.Vector3f(x, y, -1)), dr.opaque(mi.Float, self.image_area)

    def toward(self, places: Floats) -> tuple[Floats, NDArray[np.bool_]]:
        """See ``Lens.toward``."""
        inside = (np.abs(places[..., :2]).max(axis=-1) <= -places[..., 2] * self.reach) & (places[..., 2] < 0)
        return np.zeros_like(places), inside

    @property
    def image_area(self) -> float:
        """See ``Lens.image_area``; here the solid angle of a square pyramid."""
        reach_squared = self.reach**2
        return float(4 * np.arcsin(reach_squared / (1 + reach_squared)))

    @property
    def most(self) -> float:
        """See ``Lens.most``; it is the weight in the middle."""
        return 4 * self.reach**2

    def mean_weight(self, columns: int, rows: int) -> float:
        """See ``Lens.mean_weight``."""
        x, y = (((2 * np.arange(count) + 1) / count - 1) * self.reach for count in (columns, rows))
        return float(np.mean(self.most * (1 + x**2 + y[:, None] ** 2) ** -1.5))


@dataclass(frozen=True)
class WholeSphere(Lens):
    """All directions, uniform on the sphere: z is uniform (Archimedes)."""

    wraps = True

    def ray(self, u: Any, v: Any) -> tuple[Any, Any, Any]:
        """See ``Lens.ray``."""
        z = 1 - 2 * v
        radius = dr.safe_sqrt(1 - dr.square(z))
        sine, cosine = dr.sincos(2 * np.pi * u)
        return mi.Point3f(0), mi.Vector3f(radius * cosine, radius * sine, z), dr.opaque(mi.Float, 4 * np.pi)

    def toward(self, places: Floats) -> tuple[Floats, NDArray[np.bool_]]:
        """See ``Lens.toward``."""
        return np.zeros_like(places), np.ones(places.shape[:-1], bool)

    @property
    def image_area(self) -> float:
        """See ``Lens.image_area``."""
        return 4 * np.pi

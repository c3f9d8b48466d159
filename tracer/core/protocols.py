"""What Mitsuba and Dask hand over, as far as tracer uses it: for editors and type checkers, in public signatures.

The classes of Mitsuba are others in every variant and exist only once one is active, so nothing can be checked against
them. Each protocol lists what is asked of such an object, with the types that Python sees. Arrays on the device are
annotated as ``mi.Float`` and so on, which editors look up in Mitsuba's stubs and which nothing evaluates.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Protocol

if TYPE_CHECKING:
    import mitsuba as mi


class Plugin(Protocol):
    """Any object that a scene describes: ``mi.Object``."""

    def class_name(self) -> str:
        """Return the name of its class."""

    def id(self) -> str:
        """Return the name that the scene file gives it, or one that Mitsuba made up."""


class Filter(Protocol):
    """A reconstruction filter: ``mi.ReconstructionFilter``."""

    def radius(self) -> float:
        """Return the distance in pixels at which it ends."""

    def border_size(self) -> int:
        """Return how many pixels beyond the picture count in it."""

    def is_box_filter(self) -> bool:
        """Return whether a sample counts in its own pixel alone."""


class Film(Plugin, Protocol):
    """What collects a picture: ``mi.Film``."""

    def size(self) -> mi.ScalarVector2u:
        """Return width and height in pixels."""

    def crop_size(self) -> mi.ScalarVector2u:
        """Return width and height of the part that is rendered, in pixels."""

    def crop_offset(self) -> mi.ScalarPoint2u:
        """Return x and y of the part that is rendered, in pixels."""

    def rfilter(self) -> Filter:
        """Return the reconstruction filter."""

    def sample_border(self) -> bool:
        """Return whether pixels around the picture are sampled, too."""

    def flags(self) -> int:
        """Return what kind of film it is, as ``mi.FilmFlags``."""

    def prepare(self, aovs: Sequence[str]) -> int:
        """Make room for the channels of the picture and for these AOVs, and return how many channels that makes."""

    def put_block(self, block: mi.ImageBlock) -> None:
        """Add a part of the picture."""

    def bitmap(self, raw: bool = ...) -> mi.Bitmap:
        """Return the picture."""

    def clear(self) -> None:
        """Forget the picture."""


class Sampler(Protocol):
    """A source of random numbers: ``mi.Sampler``."""

    def sample_count(self) -> int:
        """Return the samples per pixel that it is made for."""

    def seed(self, seed: mi.UInt32 | int, wavefront_size: int = ...) -> None:
        """Begin the sequence ``seed`` anew, for so many samples at once."""

    def next_1d(self, active: mi.Bool | bool = ...) -> mi.Float:
        """Return a number in [0, 1) for every sample."""

    def next_2d(self, active: mi.Bool | bool = ...) -> mi.Point2f:
        """Return a point in [0, 1)^2 for every sample."""


class KeyedSampler(Sampler, Protocol):
    """A sampler that can draw any sample of any pixel: the plugin ``owen_sobol``."""

    dimension: mi.UInt32
    """The next dimension of every sample."""

    def seed_samples(self, seed: mi.UInt32 | int, pixel: mi.UInt32, index: mi.UInt32) -> None:
        """Begin sample ``index`` of each ``pixel``."""

    def fork(self) -> KeyedSampler:
        """Return another sampler of this kind, with no samples begun."""


class Sensor(Plugin, Protocol):
    """A camera with its film and its sampler: ``mi.Sensor``."""

    def film(self) -> Film:
        """Return the film, which knows the size of the picture in pixels and its filter."""

    def sampler(self) -> Sampler:
        """Return the sampler of the scene; tracer takes only the number of samples from it."""

    def needs_aperture_sample(self) -> bool:
        """Return whether a ray depends on a place on the lens."""

    def shutter_open(self) -> float:
        """Return the time at which the shutter opens."""

    def shutter_open_time(self) -> float:
        """Return how long it is open."""

    def get_medium(self) -> mi.Medium:
        """Return the medium in which the camera is, or a null pointer."""

    def world_transform(self) -> mi.AffineTransform4f:
        """Return the transform from the frame of the camera to the world."""

    def sample_ray(
        self, time: mi.Float, sample1: mi.Float, sample2: mi.Point2f, sample3: mi.Point2f, active: mi.Bool | bool = ...
    ) -> tuple[mi.Ray3f, mi.Spectrum]:
        """Return rays and their weights: by time, wavelength, place on the film and place on the lens."""

    def sample_ray_differential(
        self, time: mi.Float, sample1: mi.Float, sample2: mi.Point2f, sample3: mi.Point2f, active: mi.Bool | bool = ...
    ) -> tuple[mi.RayDifferential3f, mi.Spectrum]:
        """Return the same rays with those of the neighbouring pixels."""


class Integrator(Plugin, Protocol):
    """What computes radiance along rays of the camera: ``mi.SamplingIntegrator``."""

    hide_emitters: bool
    """Whether the camera does not see lights."""

    def render(
        self,
        scene: Any,
        sensor: Any = ...,
        seed: mi.UInt32 | int = ...,
        spp: int = ...,
        develop: bool = ...,
        evaluate: bool = ...,
    ) -> mi.TensorXf:
        """Return a picture, as ``mi.render`` does."""

    def sample(
        self,
        scene: Any,
        sampler: Any,
        ray: mi.RayDifferential3f,
        medium: mi.Medium | None = ...,
        active: mi.Bool | bool = ...,
    ) -> tuple[mi.Spectrum, mi.Bool, Sequence[mi.Float]]:
        """Return radiance, whether the ray hit anything, and the values of AOVs."""

    def aov_names(self) -> Sequence[str]:
        """Return the names of the AOVs."""


class Emitter(Plugin, Protocol):
    """A light: ``mi.Emitter``."""

    def flags(self) -> int:
        """Return what kind of light it is, as ``mi.EmitterFlags``."""

    def is_environment(self) -> bool:
        """Return whether it surrounds the scene."""

    def sampling_weight(self) -> float:
        """Return how often it is chosen, relative to other lights."""


class Shape(Plugin, Protocol):
    """A shape: ``mi.Shape``, or ``mi.Mesh``, which has vertices and faces, too."""

    def is_mesh(self) -> bool:
        """Return whether it is a mesh."""

    def primitive_count(self) -> int:
        """Return the number of its faces; 1 if it is no mesh, 0 if it is only there to be instanced."""

    def surface_area(self) -> mi.Float:
        """Return its area, in squared units of the scene."""

    def bbox(self) -> mi.ScalarBoundingBox3f:
        """Return the box that holds it."""

    def bsdf(self) -> Any:
        """Return its material (``mi.BSDF``), or None."""

    def emitter(self) -> Any:
        """Return the light that it is (``Emitter``), or None."""

    def is_medium_transition(self) -> bool:
        """Return whether there is another medium on its other side."""

    def interior_medium(self) -> mi.Medium | None:
        """Return the medium within it, or None."""

    def exterior_medium(self) -> mi.Medium | None:
        """Return the medium around it, or None."""


class Scene(Protocol):
    """A loaded scene: ``mi.Scene``."""

    def sensors(self) -> Sequence[Sensor]:
        """Return the sensors, in the order of their numbers."""

    def integrator(self) -> Integrator | None:
        """Return the integrator that the scene asks for, or None."""

    def shapes(self) -> Sequence[Shape]:
        """Return the shapes, in the order of their numbers."""

    def emitters(self) -> Sequence[Emitter]:
        """Return the lights."""

    def ray_intersect(self, ray: mi.Ray3f, *arguments: Any, **keywords: Any) -> mi.SurfaceInteraction3f:
        """Return what rays hit first."""

    def ray_intersect_preliminary(
        self, ray: mi.Ray3f, *arguments: Any, **keywords: Any
    ) -> mi.PreliminaryIntersection3f:
        """Return the shape and the place on it that rays hit first."""

    def ray_test(self, ray: mi.Ray3f, *arguments: Any, **keywords: Any) -> mi.Bool:
        """Return whether rays hit anything."""


class DaskClient(Protocol):
    """The way to workers that run already: ``distributed.Client``, of the extra ``cluster``."""

    def submit(self, func: Any, *args: Any, **kwargs: Any) -> Any:
        """Let a worker call a function, and return its future."""

    def scheduler_info(self) -> Any:
        """Return what there is to know about the workers, by address."""

"""Open a scene with all that a render needs of it: sensor, film, filter, integrator, channels."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from math import ceil
from pathlib import Path
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from tracer.core import threads
from tracer.core.arrays import Singles
from tracer.core.device import upload_tensor
from tracer.core.plain_values import whole_number, whole_numbers
from tracer.core.protocols import Film, Integrator, Scene, Sensor
from tracer.errors import BackendError, SceneError, SettingsError
from tracer.scene.frame import Frame
from tracer.scene.load import LOAD_ERRORS, describe, load, require_scene
from tracer.scene.load_errors import load_error, render_error
from tracer.scene.preparation import prepare_scene

Crop = tuple[int, int, int, int] | None
"""x, y, width and height in pixels of a part of the film."""
Size = int | tuple[int, int] | None
"""Width in pixels (the height follows the film's aspect), or (width, height), or None for the film's own size."""
ABORTING = {"StokesIntegrator": "stokes"}
"""Plugin names of the integrators whose ``sample``, called from Python, ends the process, by class. All integrators of
Mitsuba 3.9 and combinations of them were tried in every variant; only these do."""
SILENT_SPP = 4
"""Samples per pixel of Mitsuba's samplers where a scene says nothing."""
MOST_SIDE, MOST_PIXELS = 2**20, 2**28
"""Largest side of a film, and most pixels that are rendered at once: float32 coordinates and 32-bit indices reach no
further."""


@dataclass(frozen=True)
class View(Frame):
    """A scene seen by one sensor through one integrator."""

    scene: Scene
    """The ``mi.Scene``."""
    sensor: Sensor
    """The ``mi.Sensor`` through which it is seen."""
    integrator: Integrator
    """The ``mi.SamplingIntegrator`` from which samples are drawn."""
    settings: dict[str, Any]
    """Settings that the scene itself asks for: the parameters of its integrator, if that is ``adaptive``."""

    @cached_property
    def film(self) -> Film:
        """The film of the sensor."""
        return self.sensor.film()

    @property
    def asked_spp(self) -> int | None:
        """Samples per pixel that the scene's sampler has; None for SILENT_SPP, which most likely nobody chose."""
        count = int(self.sensor.sampler().sample_count())
        return None if count == SILENT_SPP else count

    @cached_property
    def size(self) -> tuple[int, int]:  # type: ignore[override]
        """(height, width) of the image: the film's crop window."""
        width, height = self.film.crop_size()
        return int(height), int(width)

    @cached_property
    def border(self) -> int:  # type: ignore[override]
        """Pixels that are sampled outside each side of the image if the film asks for ``sample_border``, else 0."""
        return int(self.film.rfilter().border_size()) if self.film.sample_border() else 0

    @cached_property
    def grid_origin(self) -> mi.ScalarVector2i:
        """Film coordinates (x, y) of the first pixel of the grid."""
        return mi.ScalarVector2i(self.film.crop_offset()) - self.border

    @cached_property
    def pixel_format(self) -> mi.Bitmap.PixelFormat:
        """Pixel format of the film."""
        self.film.prepare([])
        return self.film.bitmap().pixel_format()

    @cached_property
    def channels(self) -> list[str]:  # type: ignore[override]
        """Names of the channels of the image, in the order of ``mi.render``."""
        formats = mi.Bitmap.PixelFormat
        base = {
            formats.Y: ["Y"],
            formats.YA: ["Y", "A"],
            formats.RGB: ["R", "G", "B"],
            formats.RGBA: ["R", "G", "B", "A"],
            formats.XYZ: ["X", "Y", "Z"],
            formats.XYZA: ["X", "Y", "Z", "A"],
        }[self.pixel_format]
        return base + list(self.integrator.aov_names())

    @cached_property
    def reach(self) -> int:  # type: ignore[override]
        """Distance in pixels over which a sample counts through the reconstruction filter; 0 for a box filter."""
        rfilter = self.film.rfilter()
        return 0 if rfilter.is_box_filter() else ceil(rfilter.radius() - 0.5)

    @cached_property
    def window(self) -> tuple[int, int, int, int]:  # type: ignore[override]
        """x and y of the image within the film, and width and height of the film."""
        (x, y), (width, height) = self.film.crop_offset(), self.film.size()
        return int(x), int(y), int(width), int(height)

    @cached_property
    def object_count(self) -> int:
        """Number of shapes and lights of the scene."""
        return len(self.scene.shapes()) + len(self.scene.emitters())

    def fill_film(self, image: Singles) -> None:
        """Put ``image`` (H, W, C) into the film, for ``film.develop()`` and ``film.write()``."""
        names = list(self.integrator.aov_names())
        self.film.prepare(names)
        colour = self.rgb(image)
        rest = image[..., self.colour_channels :]
        alpha, aovs = rest[..., : rest.shape[-1] - len(names)], rest[..., rest.shape[-1] - len(names) :]
        parts = [colour, alpha, np.ones_like(image[..., :1]), aovs]
        tensor = upload_tensor(np.concatenate(parts, axis=-1))
        self.film.put_block(mi.ImageBlock(tensor, mi.ScalarPoint2i(self.film.crop_offset())))

    def to_channels(self, spectrum: mi.Spectrum, valid: mi.Bool, wavelengths: mi.Wavelength) -> list[mi.Float]:
        """Return weighted radiance in the film's channels, without AOVs.

        ``valid``: whether the ray hit anything, which makes the alpha; ``wavelengths``: those of the ray.
        """
        if mi.is_polarized:
            spectrum = mi.unpolarized_spectrum(spectrum)
        if mi.is_spectral:
            rgb = mi.spectrum_to_srgb(spectrum, wavelengths)
        elif mi.is_monochromatic:
            rgb = mi.Color3f(spectrum.x)
        else:
            rgb = spectrum
        formats = mi.Bitmap.PixelFormat
        if self.pixel_format in (formats.Y, formats.YA):
            colour = [mi.luminance(rgb)]
        elif self.pixel_format in (formats.XYZ, formats.XYZA):
            colour = list(mi.srgb_to_xyz(rgb))
        else:
            colour = [rgb.x, rgb.y, rgb.z]
        has_alpha = self.pixel_format in (formats.YA, formats.RGBA, formats.XYZA)
        return colour + ([dr.select(valid, mi.Float(1), mi.Float(0))] if has_alpha else [])


@contextmanager
def open_scene(
    source: str | Path | dict[str, Any] | Scene,
    sensor: int | Sensor = 0,
    integrator: str | dict[str, Any] | Integrator | None = None,
    size: Size = None,
    crop: Crop = None,
    define: dict[str, str] | None = None,
) -> Iterator[View]:
    """Open ``source`` as a View; a variant must be active. A resized film gets its own size back when the block ends.

    ``source``: path of a Mitsuba XML file, a dictionary, or an ``mi.Scene``. ``integrator``: plugin name, dictionary
    or ``mi.Integrator`` that takes the place of the scene's; ``sensor``: number or ``mi.Sensor``; ``crop``: part of the
    film at its new ``size`` that is rendered instead of its own crop window; ``define``: values of the $parameters of
    a file. Raises SceneError, SettingsError, or BackendError for an object that was loaded under another variant.
    """
    scene = require_scene(source, require_variant("scene", load(source, define=define)))
    chosen_sensor = pick_sensor(scene, sensor, source)
    outer = require_variant("integrator", make_integrator(integrator if integrator is not None else scene.integrator()))
    is_adaptive = type(outer).__name__ == "AdaptiveIntegrator"  # by name: every variant has a class of its own
    nested, settings = (outer.nested, outer.settings) if is_adaptive else (outer, {})
    view = View(scene, chosen_sensor, require_nestable(nested), settings)
    if mi.has_flag(chosen_sensor.film().flags(), mi.FilmFlags.Special):
        raise SceneError(f"Film '{chosen_sensor.film().class_name()}' is not supported; use an 'hdrfilm'.")
    if min(chosen_sensor.film().size()) < 1:
        raise SceneError(f"{describe(source)} has a film without pixels; give it a width and height of at least 1.")
    original = resize_film(chosen_sensor, size, crop)
    try:
        require_pixels(view)
        prepare_scene(nested, scene)
        yield view
    except RuntimeError as error:
        if (explanation := render_error(describe(source), error)) is None:
            raise
        raise explanation from None
    finally:
        restore_film(chosen_sensor, original)


def require_variant(name: str, loaded: Any) -> Any:
    """Return an object of Mitsuba if it is of the active variant, else raise BackendError: variants do not mix.

    ``name``: how the message calls it.
    """
    variant = loaded.variant_name() if hasattr(loaded, "variant_name") else mi.variant()
    if variant != mi.variant():
        raise BackendError(
            f"The {name} was loaded under the variant '{variant}', and '{mi.variant()}' is active: "
            f"load it again, or call mi.set_variant('{variant}') before the render."
        )
    return loaded


def require_pixels(view: View) -> None:
    """Raise SettingsError for a picture of no pixels or of more than MOST_PIXELS: its film would end the process."""
    height, width = view.size
    if not 0 < view.pixel_count <= MOST_PIXELS:
        raise SettingsError(
            f"The picture is {width} x {height} pixels, and at most {MOST_PIXELS} can be rendered at once; "
            "choose a smaller size, or a crop."
        )


def pick_sensor(scene: Scene, sensor: int | Sensor, source: Any) -> Sensor:
    """Return a sensor of a loaded scene by number, or ``sensor`` itself.

    Raises SceneError, SettingsError, or BackendError for a sensor of another variant.
    """
    if hasattr(sensor, "film"):
        return require_variant("sensor", sensor)
    sensors = scene.sensors()
    if not sensors:
        raise SceneError(f'{describe(source)} has no sensor; add one, for example <sensor type="perspective">.')
    number = whole_number("sensor", sensor)
    if not 0 <= number < len(sensors):
        raise SettingsError(f"There is no sensor {number}: {describe(source)} has {len(sensors)}, counted from 0.")
    return sensors[number]


def make_integrator(integrator: str | dict[str, Any] | Integrator | None) -> Any:
    """Return an integrator from a plugin name, dictionary or ``mi.Integrator``; a path tracer for None."""
    if integrator is None:
        integrator = "path"
    if isinstance(integrator, str):
        integrator = {"type": integrator}
    if not isinstance(integrator, dict):
        return integrator
    try:
        with threads.for_files():
            return mi.load_dict(integrator)
    except LOAD_ERRORS as error:
        raise load_error("The integrator", error, "integrator") from None


def require_nestable(integrator: Any) -> Any:
    """Return ``integrator`` if samples can be drawn from it pixel by pixel, else raise SettingsError."""
    if not isinstance(integrator, mi.SamplingIntegrator):
        name = integrator.class_name() if hasattr(integrator, "class_name") else type(integrator).__name__
        raise SettingsError(
            f"Integrator '{name}' cannot be sampled pixel by pixel, so it cannot be rendered adaptively; "
            "use one that follows camera rays, such as 'path', 'volpath', 'direct' or 'prb'."
        )
    for part in mi.traverse(integrator).hierarchy:
        if part.class_name() in ABORTING:
            raise SettingsError(
                f"Integrator '{ABORTING[part.class_name()]}' cannot be rendered adaptively, as Mitsuba ends the whole "
                "program when single samples of it are asked for; use mi.render, or the integrator within it."
            )
    return integrator


def resize_film(sensor: Sensor, size: Size, crop: Crop = None) -> dict[str, Any]:
    """Give the film of ``sensor`` another size, and the crop window ``crop``, or its own one scaled to the size.

    Returns the former parameters of the film, for ``restore_film``. Raises SettingsError.
    """
    if size is None and crop is None:
        return {}
    parameters = mi.traverse(sensor)
    original = {
        name: [int(side) for side in parameters[name]] for name in ("film.size", "film.crop_size", "film.crop_offset")
    }
    width, height = new_size(original["film.size"], size)
    if crop is None:
        begins, ends = [], []
        for new_side, old_side, length, offset in zip((width, height), *original.values(), strict=True):
            begins.append(min(round(offset * new_side / old_side), new_side - 1))
            ends.append(max(round((offset + length) * new_side / old_side), begins[-1] + 1))
        lengths = [end - begin for begin, end in zip(begins, ends, strict=True)]
    else:
        part = whole_numbers("crop", crop, 4, "x, y, width and height in pixels")
        begins, lengths = list(part[:2]), list(part[2:])
        if min(begins) < 0 or min(lengths) < 1 or part[0] + part[2] > width or part[1] + part[3] > height:
            raise SettingsError(f"The crop x, y, width, height = {part} is not within the picture, {width} x {height}.")
    parameters["film.size"] = [width, height]
    parameters["film.crop_offset"] = begins
    parameters["film.crop_size"] = lengths
    parameters.update()
    return original


def new_size(film_size: list[int], size: Size) -> tuple[int, int]:
    """Return the (width, height) that ``size`` gives a film of (width, height) ``film_size``. Raises SettingsError."""
    if size is None:
        width, height = film_size
    elif np.ndim(size) == 0:
        width = whole_number("size", size)
        height = max(1, round(film_size[1] * width / film_size[0]))
    else:
        width, height = whole_numbers("size", size, 2, "width and height in pixels, or the width alone")
    if not (1 <= width <= MOST_SIDE and 1 <= height <= MOST_SIDE):
        raise SettingsError(
            f"The size must be at least 1 pixel a side and at most {MOST_SIDE}, not {width} x {height}."
        )
    return width, height


def restore_film(sensor: Sensor, original: dict[str, Any]) -> None:
    """Undo ``resize_film``, which returned ``original``."""
    if original:
        parameters = mi.traverse(sensor)
        for name, value in original.items():
            parameters[name] = value
        parameters.update()

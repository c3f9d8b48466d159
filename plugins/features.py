"""Integrator ``features``: AOVs of the surfaces that camera rays hit first, by which a denoiser tells edges from noise.

The radiance is 0. The AOVs are ``albedo.R``, ``albedo.G``, ``albedo.B``, ``normal.X``, ``normal.Y``, ``normal.Z`` and
``depth.Z``. It has no parameters.

- Albedo, from 0 to 1: the diffuse reflectance. A surface without diffuse reflectance (metal, glass) has the weight of
  one BSDF sample instead, always with the same random numbers, so that it adds no noise: this is the reflectance of a
  metal, or the tint of glass. Emitters add their radiance, as does the sky where nothing is hit; the sum is clipped to
  1. Under spectral variants the albedo is the colour under daylight (D65), without noise; under monochromatic variants
  it is grey.
- Normal: the shading normal, in world space, of length 1; 0 where nothing is hit.
- Depth: the distance from the start of the ray, as in Mitsuba's ``aov``; rays of perspective cameras start at the near
  plane. 0 where nothing is hit.

Media are not seen. Emitters are seen even where the picture's integrator hides them.

.. tabs::
    .. code-tab:: xml

        <integrator type="features"/>

    .. code-tab:: python

        {'type': 'features'}
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

NAMES = [f"albedo.{channel}" for channel in "RGB"] + [f"normal.{axis}" for axis in "XYZ"] + ["depth.Z"]
"""Names of the AOVs."""
WAVELENGTHS = np.linspace(400.0, 700.0, 16).reshape(4, 4)
"""Wavelengths in nanometres at which colours are evaluated under spectral variants; a row has as many as Mitsuba takes
at once."""
Spectrum = Callable[[Any], Any]
"""From a surface interaction to a spectrum (mi.UnpolarizedSpectrum) at the wavelengths of the interaction."""


class FeatureIntegrator(mi.SamplingIntegrator):
    """See the documentation of this file."""

    def __init__(self, props: mi.Properties) -> None:
        super().__init__(props)
        self.daylight = mi.load_dict({"type": "d65"}) if mi.is_spectral else None

    def sample(
        self,
        scene: mi.Scene,
        sampler: mi.Sampler,
        ray: mi.RayDifferential3f,
        medium: mi.Medium | None = None,
        active: mi.Bool | bool = True,
    ) -> tuple[mi.Spectrum, mi.Bool, list[mi.Float]]:
        surface = scene.ray_intersect(ray, mi.RayFlags.All, coherent=True, active=active)
        hit = surface.is_valid() & active
        albedo = dr.clip(
            self.reflected(surface, surface.bsdf(ray), hit) + self.emitted(surface, scene, active), 0.0, 1.0
        )
        albedo = dr.select(dr.isfinite(albedo), albedo, 0.0)
        normal = dr.select(hit, surface.sh_frame.n, 0.0)
        depth = dr.select(hit, surface.t, 0.0)
        return mi.Spectrum(0.0), hit, [*albedo, *normal, depth]

    def reflected(self, surface: mi.SurfaceInteraction3f, bsdf: mi.BSDFPtr, hit: mi.Bool) -> mi.Color3f:
        """Return the share of light that surfaces reflect; 0 where nothing is hit."""
        # This mode weights samples without the factor by which radiance changes where it enters glass.
        context = mi.BSDFContext(mi.TransportMode.Importance)

        def reflectance(surface: mi.SurfaceInteraction3f) -> mi.UnpolarizedSpectrum:
            diffuse = hit & mi.has_flag(bsdf.flags(), mi.BSDFFlags.Diffuse)
            sampled = bsdf.sample(context, surface, mi.Float(0.5), mi.Point2f(0.5), hit & ~diffuse)[1]
            colour = dr.select(diffuse, plain(bsdf.eval_diffuse_reflectance(surface, diffuse)), plain(sampled))
            return colour if self.daylight is None else colour * plain(self.daylight.eval(surface))

        return dr.select(hit, self.colour(reflectance, surface), 0.0)

    def emitted(self, surface: mi.SurfaceInteraction3f, scene: mi.Scene, active: mi.Bool | bool) -> mi.Color3f:
        """Return the radiance of the emitters that rays hit, the sky included."""
        emitter = surface.emitter(scene, active)
        return self.colour(lambda surface: plain(emitter.eval(surface, active)), surface)

    def colour(self, spectrum: Spectrum, surface: mi.SurfaceInteraction3f) -> mi.Color3f:
        """Return a spectrum as linear sRGB."""
        if self.daylight is None:
            values = spectrum(surface)
            return mi.Color3f(values.x) if mi.is_monochromatic else mi.Color3f(values)
        total, white = mi.Color3f(0.0), mi.Color3f(0.0)
        wavelengths = surface.wavelengths
        for nanometres in WAVELENGTHS.tolist():
            surface.wavelengths = type(wavelengths)(*nanometres)
            total += mi.spectrum_to_srgb(spectrum(surface), surface.wavelengths)
            white += mi.spectrum_to_srgb(plain(self.daylight.eval(surface)), surface.wavelengths)
        surface.wavelengths = wavelengths
        return total / white

    def aov_names(self) -> list[str]:
        return NAMES

    def to_string(self) -> str:
        return "FeatureIntegrator[]"


def plain(spectrum: mi.Spectrum) -> mi.UnpolarizedSpectrum:
    """Return a spectrum without its polarization."""
    return mi.unpolarized_spectrum(spectrum) if isinstance(spectrum, mi.Spectrum) else spectrum


mi.register_integrator("features", FeatureIntegrator)

"""Integrator ``features``: what the camera's rays hit first, as AOVs that tell a denoiser what is edge and what noise.

The radiance is 0. The AOVs are ``albedo.R``, ``albedo.G``, ``albedo.B``, ``normal.X``, ``normal.Y``, ``normal.Z`` and
``depth.Z``. It has no parameters.

- Albedo, from 0 to 1: the diffuse reflectance. Surfaces that have none (metal, glass) have the weight of one sample of
  what they do instead, always the same one, so that it adds no noise: the reflectance of a metal, the tint of glass.
  What shines adds its radiance, the sky alone included; all is clipped to 1. Under spectral variants it is the colour
  under daylight (D65), without noise; under monochromatic ones it is grey.
- Normal: the shading normal, in world space, of length 1; 0 where nothing is hit.
- Depth: the distance from where the ray begins, as that of Mitsuba's ``aov``; perspective cameras begin rays at their
  near plane. 0 where nothing is hit.

Media are not seen, and an emitter is, where the picture's integrator hides it.

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

NAMES = [f"albedo.{c}" for c in "RGB"] + [f"normal.{c}" for c in "XYZ"] + ["depth.Z"]
WAVELENGTHS = np.linspace(400.0, 700.0, 16).reshape(4, 4)
"""Nanometres at which colours are looked at under spectral variants, as many at once as Mitsuba takes."""
Spectrum = Callable[[Any], Any]
"""From a surface interaction, whose wavelengths count, to what it sends there (mi.UnpolarizedSpectrum)."""


class FeatureIntegrator(mi.SamplingIntegrator):
    """See the documentation of this file."""

    def __init__(self, props: mi.Properties) -> None:
        super().__init__(props)
        self.daylight = mi.load_dict({"type": "d65"}) if mi.is_spectral else None

    def sample(
        self, scene: mi.Scene, sampler: mi.Sampler, ray: Any, medium: Any = None, active: Any = True
    ) -> tuple[Any, Any, list[Any]]:
        found = scene.ray_intersect(ray, mi.RayFlags.All, coherent=True, active=active)
        hit = found.is_valid() & active
        albedo = dr.clip(self.reflected(found, found.bsdf(ray), hit) + self.emitted(found, scene, active), 0.0, 1.0)
        albedo = dr.select(dr.isfinite(albedo), albedo, 0.0)
        normal = dr.select(hit, found.sh_frame.n, 0.0)
        depth = dr.select(hit, found.t, 0.0)
        return mi.Spectrum(0.0), hit, [*albedo, *normal, depth]

    def reflected(self, found: Any, bsdf: Any, hit: Any) -> Any:
        """Return the share of light that surfaces reflect (mi.Color3f), 0 where nothing is hit."""
        # As light is weighed, not radiance, which changes where it enters glass.
        context = mi.BSDFContext(mi.TransportMode.Importance)

        def reflectance(found: Any) -> Any:
            diffuse = hit & mi.has_flag(bsdf.flags(), mi.BSDFFlags.Diffuse)
            other = bsdf.sample(context, found, mi.Float(0.5), mi.Point2f(0.5), hit & ~diffuse)[1]
            own = dr.select(diffuse, plain(bsdf.eval_diffuse_reflectance(found, diffuse)), plain(other))
            return own if self.daylight is None else own * plain(self.daylight.eval(found))

        return dr.select(hit, self.colour(reflectance, found), 0.0)

    def emitted(self, found: Any, scene: mi.Scene, active: Any) -> Any:
        """Return the radiance of what the rays see shine (mi.Color3f)."""
        emitter = found.emitter(scene, active)
        return self.colour(lambda found: plain(emitter.eval(found, active)), found)

    def colour(self, spectrum: Spectrum, found: Any) -> Any:
        """Return a spectrum as linear sRGB (mi.Color3f)."""
        if self.daylight is None:
            values = spectrum(found)
            return mi.Color3f(values.x) if mi.is_monochromatic else mi.Color3f(values)
        seen, white = mi.Color3f(0.0), mi.Color3f(0.0)
        own = found.wavelengths
        for nanometres in WAVELENGTHS.tolist():
            found.wavelengths = type(own)(*nanometres)
            seen += mi.spectrum_to_srgb(spectrum(found), found.wavelengths)
            white += mi.spectrum_to_srgb(plain(self.daylight.eval(found)), found.wavelengths)
        found.wavelengths = own
        return seen / white

    def aov_names(self) -> list[str]:
        return NAMES

    def to_string(self) -> str:
        return "FeatureIntegrator[]"


def plain(spectrum: Any) -> Any:
    """Return a spectrum without its polarization (mi.UnpolarizedSpectrum)."""
    return mi.unpolarized_spectrum(spectrum) if isinstance(spectrum, mi.Spectrum) else spectrum


mi.register_integrator("features", FeatureIntegrator)

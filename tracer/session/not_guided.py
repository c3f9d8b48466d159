"""Why a render does not learn which lights matter where, although that was asked for: one sentence."""

from __future__ import annotations

from typing import Any

import mitsuba as mi

from tracer.scene.view import View

NOT_WORTH_IT = "Not guided: to learn which lights matter where is not expected to pay here."
NOT_POSSIBLE = "Not guided: only the integrators 'path' and 'guided' learn about lights, and this is '{}'{}."
NO_MEDIUM = "; the scene has no medium, so 'path' has the same expected picture"
NESTED_PATH = (
    "Not guided: within '{}' only the integrator 'guided' learns about lights; name it there instead of 'path'."
)
PLUGINS = {
    "AOVIntegrator": "aov",
    "MomentIntegrator": "moment",
    "DirectIntegrator": "direct",
    "DepthIntegrator": "depth",
    "VolumetricPathIntegrator": "volpath",
    "VolpathMisIntegratorImpl": "volpathmis",
    "PRBIntegrator": "prb",
    "BasicPRBIntegrator": "prb_basic",
    "PRBVolpathIntegrator": "prbvolpath",
}
"""Names of Mitsuba's plugins by class."""
VOLUMETRIC = {"volpath", "volpathmis", "prbvolpath"}
"""Integrators that scenes with media need."""


def why_not_guided(view: View) -> str:
    """Return why lights are chosen as Mitsuba does; the integrator of the view has no ``guided`` in it."""
    if is_path(view.integrator):
        return NOT_WORTH_IT
    name = plugin_name(view.integrator)
    if any(is_path(part) for part in mi.traverse(view.integrator).hierarchy):
        return NESTED_PATH.format(name)
    return NOT_POSSIBLE.format(name, NO_MEDIUM if name in VOLUMETRIC and not has_medium(view) else "")


def is_path(integrator: Any) -> bool:
    """Return whether an integrator is ``path``."""
    return bool(integrator.class_name() == "PathIntegrator")


def plugin_name(integrator: Any) -> str:
    """Return the name of the plugin of an integrator, or that of its class if it does not come with Mitsuba."""
    name = str(integrator.class_name())
    if name == "SamplingIntegrator":  # the class of those in Python has its own name
        name = type(integrator).__name__
    return PLUGINS.get(name, name)


def has_medium(view: View) -> bool:
    """Return whether a shape of the scene bounds a medium, or the sensor stands in one."""
    return any(shape.is_medium_transition() for shape in view.scene.shapes()) or view.sensor.get_medium() is not None

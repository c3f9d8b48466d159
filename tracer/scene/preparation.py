"""What an integrator may do for a scene before the first sample is drawn from it."""

from __future__ import annotations

from typing import Any, Protocol, runtime_checkable


@runtime_checkable
class PreparesScene(Protocol):
    """An integrator that works something out for a whole scene first, such as a radiosity solution or a photon map.

    ``open_scene`` calls ``prepare_scene`` when the scene is loaded and before samples are recorded: within a recording
    no kernel could be evaluated. An integrator in Python takes part by having the method; nothing is registered.
    """

    def prepare_scene(self, scene: Any) -> None:
        """Prepare for an ``mi.Scene``; called once a render, also for a scene that the integrator is prepared for."""


def prepare_scene(integrator: Any, scene: Any) -> None:
    """Let an integrator prepare for a scene, if it wants to."""
    if isinstance(integrator, PreparesScene):
        integrator.prepare_scene(scene)

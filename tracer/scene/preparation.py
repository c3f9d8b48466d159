"""What an integrator may work out for a scene before the first sample is drawn."""

from __future__ import annotations

from typing import Any, Protocol, runtime_checkable


@runtime_checkable
class PreparesScene(Protocol):
    """An integrator that first works something out for the whole scene, such as a radiosity solution or a photon map.

    ``open_scene`` calls ``prepare_scene`` after the scene is loaded and before samples are recorded: no kernel can be
    evaluated within a recording. An integrator in Python only needs to have the method; nothing is registered.
    """

    def prepare_scene(self, scene: Any) -> None:
        """Prepare for an ``mi.Scene``; called once per render, even for a scene that is prepared already."""


def prepare_scene(integrator: Any, scene: Any) -> None:
    """Let an integrator prepare for a scene, if it has the method ``prepare_scene``."""
    if isinstance(integrator, PreparesScene):
        integrator.prepare_scene(scene)

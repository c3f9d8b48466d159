"""What is written beside a picture so that it can be made again."""

from __future__ import annotations

from typing import Any

import mitsuba as mi

from tracer.core.version import version
from tracer.result import Result


def metadata(result: Result, scene_hash: str) -> dict[str, Any]:
    """Return version, scene, settings and outcome as plain values.

    ``spp`` is what was drawn, samples a pixel; ``spp_at_most`` what a noise target or a limit of time could have made
    of it, or what was asked for where there is neither.
    """
    settings = result.report.settings
    return {
        "version": version(),
        "mitsuba": mi.__version__,
        "variant": mi.variant(),
        "scene_hash": scene_hash,
        "spp": result.report.spp,
        "spp_at_most": settings.spp,
        "seed": settings.seed,
        "criterion": settings.criterion,
        "objective": settings.objective,
        "seconds": result.seconds,
        "complete": int(result.report.complete),
        "report": result.report.as_dict(),
        **({"shapes": result.seen.shape_names} if result.seen is not None else {}),
    }

"""A picture by our loop with the same number of samples in every pixel, and the statistics of these samples."""

from __future__ import annotations

from tracer.film.estimate import Statistics
from tracer.result import Result
from tracer.scene.view import View
from tracer.session.render import begun, complete
from tracer.session.request import Request
from tracer.settings import make_settings


def render_uniform(view: View, spp: int, seed: int) -> tuple[Result, Statistics]:
    """Return a picture of ``spp`` samples per pixel, and the statistics of each pixel of the film's grid."""
    settings = make_settings(spp=spp, seed=seed, criterion="uniform")
    request = Request(view, settings)
    with begun(request, view) as rendering:
        return complete(rendering, request), rendering.state.estimate.statistics()

"""Integrator ``adaptive``: renders a nested integrator with more samples where the picture is complex.

A few samples in every pixel come first, and cheap rays that only find out what they hit. Further samples of the nested
integrator are drawn in rounds, each allocated by what was seen so far. ``spp`` is the mean over all pixels. Samples
always come from the progressive sampler ``owen_sobol``; the sensor's sampler only gives the sample count, if
``mi.render`` is given none.

Derivatives are those of the nested integrator, taken with its own uniform samples: the allocation is treated as a
constant, because the expected picture does not depend on it.

.. pluginparameters::

 * - (Nested plugin)
   - |integrator|
   - What to render: any integrator that follows camera rays, such as ``path``. (Default: path)
 * - criterion
   - |string|
   - What finds importance: fused, variance, shape_entropy, uniform, or another registered name. (Default: fused)
 * - objective
   - |string|
   - Which error is to be small: relative, absolute, display. (Default: relative)
 * - exposure
   - |float|
   - Stops by which the picture will be brightened for viewing. (Default: 0)
 * - pilot_spp, min_spp, max_spp
   - |int|
   - Pilot rays per pixel; smallest and largest number of samples of any pixel. (Default: chosen by the budget)
 * - cost
   - |string|
   - What a sample is taken to cost: the same everywhere (none), the work of its path (work), or its root (root).
     (Default: root)
 * - importance
   - |string|
   - Image file, a mask or weights, by which the importance of each pixel is multiplied. (Default: none)
 * - shape_weights
   - |string|
   - Factors of the importance of pixels that shapes cover, by ID or number: "lamp=4, floor=0.5". (Default: none)
 * - block
   - |int|
   - Side, in pixels, of the squares over which the complexity of IDs is measured. (Default: 1)
 * - guide
   - |bool|
   - Whether to learn which lights matter where, if the nested integrator is ``path``. (Default: where that may pay)
 * - unbiased
   - |bool|
   - Whether samples that decide on the allocation are left out of the picture; they still count towards ``spp``.
     (Default: false)
 * - spp, seed
   - |int|
   - Mean samples per pixel, and seed, if ``mi.render`` is given none. (Default: those of the sensor's sampler; 0)

.. tabs::
    .. code-tab:: xml

        <integrator type="adaptive"><integrator type="path"/></integrator>

    .. code-tab:: python

        {'type': 'adaptive', 'nested': {'type': 'path'}}
"""

from __future__ import annotations

from typing import Any

import mitsuba as mi

from tracer.core.device import seed_number, upload_tensor
from tracer.errors import SettingsError
from tracer.result import Result
from tracer.scene.view import open_scene, require_nestable
from tracer.session.render import render_request
from tracer.session.request import Request
from tracer.settings import Settings, check_settings


class AdaptiveIntegrator(mi.SamplingIntegrator):
    """See the documentation of this file."""

    def __init__(self, props: mi.Properties) -> None:
        super().__init__(props)
        nested = [value for _, value in props.objects()]
        if len(nested) > 1:
            raise SettingsError('adaptive: takes one nested integrator, such as <integrator type="path"/>.')
        self.nested = require_nestable(nested[0] if nested else mi.load_dict({"type": "path"}))
        self.settings = {name: props[name] for name in Settings.model_fields if name in props}
        if "importance" in self.settings:  # the path is relative to the scene file, like all paths in it
            self.settings["importance"] = str(mi.file_resolver().resolve(str(self.settings["importance"])))
        check_settings(**self.settings)
        self.result: Result | None = None
        """Result of the last rendering, with sample counts, errors and report; None before the first."""

    def render(
        self,
        scene: mi.Scene,
        sensor: int | mi.Sensor = 0,
        seed: mi.UInt32 | int = 0,
        spp: int = 0,
        develop: bool = True,
        evaluate: bool = True,
    ) -> mi.TensorXf:
        if not develop:
            raise SettingsError("adaptive: can only render with develop=True.")
        chosen_sensor = sensor if isinstance(sensor, mi.Sensor) else scene.sensors()[sensor]
        settings = {"spp": chosen_sensor.sampler().sample_count(), **self.settings}
        if spp:
            settings["spp"] = spp
        settings["seed"] = self.own_seed(seed)
        with open_scene(scene, chosen_sensor, self) as view:
            self.result = render_request(Request(view, settings))
            view.fill_film(self.result.image)
        return upload_tensor(self.result.image)

    def render_forward(
        self, scene: mi.Scene, params: Any, sensor: int | mi.Sensor = 0, seed: mi.UInt32 | int = 0, spp: int = 0
    ) -> mi.TensorXf:
        return self.nested.render_forward(
            scene, params, sensor, self.own_seed(seed), spp or self.settings.get("spp", 0)
        )

    def render_backward(
        self,
        scene: mi.Scene,
        params: Any,
        grad_in: mi.TensorXf,
        sensor: int | mi.Sensor = 0,
        seed: mi.UInt32 | int = 0,
        spp: int = 0,
    ) -> None:
        spp = spp or self.settings.get("spp", 0)
        self.nested.render_backward(scene, params, grad_in, sensor, self.own_seed(seed), spp)

    def own_seed(self, seed: mi.UInt32 | int) -> int:
        """Return ``seed``, or the seed of the parameters if ``seed`` is 0, which stands for none."""
        return seed_number(seed) or self.settings.get("seed", 0)

    def sample(
        self,
        scene: mi.Scene,
        sampler: mi.Sampler,
        ray: mi.RayDifferential3f,
        medium: mi.Medium | None = None,
        active: mi.Bool | bool = True,
    ) -> tuple[mi.Spectrum, mi.Bool, list[mi.Float]]:
        return self.nested.sample(scene, sampler, ray, medium, active)

    def aov_names(self) -> list[str]:
        return self.nested.aov_names()

    def to_string(self) -> str:
        settings = "".join(f"  {name} = {value},\n" for name, value in self.settings.items())
        return f"AdaptiveIntegrator[\n{settings}  nested = {self.nested}\n]"


mi.register_integrator("adaptive", AdaptiveIntegrator)

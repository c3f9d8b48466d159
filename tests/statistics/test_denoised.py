"""Denoised pictures of whole scenes are no worse than noisy ones, keep their light, and flicker less."""

from importlib.resources import files
from pathlib import Path

import mitsuba as mi
import numpy as np
import pytest

import tracer
from tracer.image import metrics

SCENES = Path(str(files("tracer.scenes")))
pytest.importorskip("mitsuba_oidn")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "size"), [("many_lights", 64), ("thin_rods", 128), ("glass_caustic", 64), ("window_interior", 64)]
)
def test_denoised_is_no_worse_than_noisy(name, size):
    """At 8 and 128 samples per pixel; the reference's own error is below a tenth of that at 128.

    In 64 pixels the rods are so much thinner than a pixel that denoising costs 8 to 16 % at 8 and 16 samples per pixel.
    The ratio over three seeds scatters by about 2 %, so a true ratio of 1 exceeds 1.06 about once in 10^3 runs.
    """
    path = SCENES / f"{name}.xml"
    reference = tracer.render(path, size=size, spp=2048, criterion="uniform", seed=99).rgb
    for spp in (8, 128):
        errors, light = [], []
        for seed in range(3):
            result = tracer.render(path, size=size, spp=spp, seed=seed, denoise=True)
            errors.append([metrics.relative_mse(image, reference) for image in (result.rgb, result.noisy)])
            light.append(result.rgb.mean() / result.noisy.mean())
        denoised, noisy = np.mean(errors, axis=0)
        assert denoised < 1.06 * noisy, spp
        assert np.mean(light) == pytest.approx(1.0, abs=0.03), spp


def frames(spp, denoise):
    """Return pictures of a camera that moves slowly past a scene, each with its own seed."""
    scene = mi.load_file(str(SCENES / "depth_of_field.xml"))
    parameters = mi.traverse(scene.sensors()[0])
    start = parameters["to_world"]
    pictures = []
    for k in range(4):
        parameters["to_world"] = start @ mi.ScalarTransform4f().translate([0.004 * k, 0.0, 0.0])
        parameters.update()
        pictures.append(tracer.render(scene, size=96, spp=spp, seed=k, denoise=denoise))
    return pictures


@pytest.mark.slow
def test_frames_of_a_slow_move_do_not_flicker_more_than_noisy_ones():
    """Flicker is the change from frame to frame that the change of the true pictures does not explain."""
    truth = [frame.rgb for frame in frames(640, denoise=False)]
    for spp in (8, 64):
        pictures = frames(spp, denoise=True)
        noisy, denoised = (
            np.mean(np.diff([picture - right for right, picture in zip(truth, kind, strict=True)], axis=0) ** 2)
            for kind in ([frame.noisy for frame in pictures], [frame.rgb for frame in pictures])
        )
        assert denoised < noisy, spp

"""On a GPU everything works as on the processor, from the same samples. ``benchmarks/on_gpu`` runs these tests."""

import subprocess
import sys

import drjit as dr
import numpy as np
import pytest

from conftest import PATIENCE

BEGIN = """
import sys
from importlib.resources import files
import numpy as np
import tracer
tracer.activate(sys.argv[1])
import mitsuba as mi
scene = str(files("tracer.scenes") / "spheres_and_rods.xml")
"""
DRAW = {
    "adaptive": "result = tracer.render(scene, size=64, spp=64); image, samples = result.image, result.samples",
    "uniform": "image = tracer.render(scene, size=64, spp=64, criterion='uniform').image",
    "unbiased": "image = tracer.render(scene, size=64, spp=64, unbiased=True).image",
    "cost": "image = tracer.render(scene, size=64, spp=64, cost='work').image",
    "noise target": "image = tracer.render(scene, size=64, noise=0.2).image",
    "rigau": "image = tracer.render(scene, size=64, spp=32, criterion='rigau').image",
    "complexity": "image = tracer.render(scene, size=64, spp=32, criterion='shape_entropy').image",
    "denoised": "image = tracer.render(scene, size=64, spp=32, denoise=True).image",
    "features": "image = tracer.render(scene, size=64, spp=16, features=True).image",
    "checkpoint": """
path = sys.argv[2] + ".ckpt"
tracer.render(scene, size=64, spp=32, checkpoint=path, progress=lambda now: now.done < now.total / 2)
image = tracer.render(scene, size=64, spp=32, checkpoint=path, resume=True).image
""",
    "plugins": """
loaded = mi.load_file(scene)
integrator = mi.load_dict({"type": "adaptive", "nested": {"type": "path"}})
image = np.array(mi.render(loaded, integrator=integrator, spp=16))
""",
    "owen_sobol": """
image = np.array(mi.render(tracer.scene.load.load(scene, sampler="owen_sobol"), spp=16))
""",
    "radiosity": """
integrator = mi.load_dict({"type": "radiosity"})
image = np.array(mi.render(mi.load_dict(mi.cornell_box()), integrator=integrator, spp=4))
""",
}
"""What is drawn, by its name: code that leaves an ``image``, and ``samples`` where they are compared."""
KEEP = """
np.savez(sys.argv[2], image=image, samples=locals().get("samples", 0))
"""
CHECK = """
assert image.ndim == 3 and image.mean() > 0
"""


def run(program, variant, path):
    """Run a program in a new process."""
    done = subprocess.run(
        [sys.executable, "-c", BEGIN + program, variant, str(path)], capture_output=True, text=True, timeout=PATIENCE
    )
    assert done.returncode == 0, done.stderr


def drawn(name, variant, path):
    """Return the image and the samples per pixel that a new process has drawn with a variant."""
    run(DRAW[name] + KEEP, variant, path)
    found = np.load(path)
    return found["image"], found["samples"]


def compare(name, variant, folder):
    """Compare a variant with the processor: the GPU rounds otherwise, which moves few samples, and no mean."""
    (image, samples), (known, known_samples) = (
        drawn(name, each, folder / f"{number}.npz") for number, each in enumerate((variant, "llvm_ad_rgb"))
    )
    assert image.shape == known.shape
    assert np.isfinite(image).all()
    assert image.mean() == pytest.approx(known.mean(), rel=0.02)
    assert np.mean(np.abs(image - known) > 0.1 * np.abs(known) + 0.01) < 0.1
    assert samples.sum() == known_samples.sum()


@pytest.mark.cuda
@pytest.mark.skipif(not dr.has_backend(dr.JitBackend.CUDA), reason="there is no GPU")
@pytest.mark.parametrize("name", DRAW)
def test_a_gpu_draws_what_a_processor_draws(name, tmp_path):
    compare(name, "cuda_ad_rgb", tmp_path)


@pytest.mark.slow
def test_the_code_above_runs_where_there_is_no_gpu(tmp_path):
    run("\n".join(code + CHECK for code in DRAW.values()), "llvm_ad_rgb", tmp_path / "image.npz")

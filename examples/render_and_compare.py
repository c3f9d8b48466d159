"""
Render and compare
==================

The same number of samples, spent evenly and where the picture is complex.
"""

# %%
# ``tracer.render`` takes the path of a scene file, a dictionary, or an ``mi.Scene``.
# The criterion ``uniform`` gives every pixel the same number of samples; ``fused``, the
# default, gives more where they lower the error most.
from importlib.resources import files

import matplotlib.pyplot as plt

import tracer
from tracer.image.colour import display
from tracer.image.metrics import relative_mse

scene = files("tracer.scenes") / "spheres_and_rods.xml"
uniform = tracer.render(scene, spp=16, size=160, criterion="uniform")
adaptive = tracer.render(scene, spp=16, size=160)

# %%
# A picture of many samples, with another seed, shows how far both are off.
reference = tracer.render(scene, spp=256, size=160, criterion="uniform", seed=1000)
error_uniform, error_adaptive = (
    relative_mse(result.rgb, reference.rgb) for result in (uniform, adaptive)
)
print(f"relative error: uniform {error_uniform:.5f}, adaptive {error_adaptive:.5f}")
print(f"samples per pixel: {uniform.report.spp:.0f}, {adaptive.report.spp:.0f}")

# %%
# The adaptive picture has more samples where there are edges, shadows and gloss.
figure, axes = plt.subplots(1, 3, figsize=(12, 3.4), layout="constrained")
axes[0].imshow(display(uniform.rgb))
axes[0].set_title("uniform")
axes[1].imshow(display(adaptive.rgb))
axes[1].set_title("adaptive")
counts = axes[2].imshow(adaptive.samples, norm="log", cmap="magma")
axes[2].set_title("samples of the adaptive picture")
figure.colorbar(counts, ax=axes[2])
for axis in axes:
    axis.axis("off")
plt.show()

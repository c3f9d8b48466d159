"""
Write a criterion
=================

A criterion says how much samples are worth in each pixel. It is a function, which
``tracer.render`` takes as it is.
"""

# %%
# ``Evidence`` holds what is known when samples are allocated: counts, means and
# variances so far, and the complexity of what cheap rays have hit. This criterion gives
# more samples where it is dark, and more at edges.
from importlib.resources import files

import matplotlib.pyplot as plt
import numpy as np

import tracer
from tracer.criteria import Evidence
from tracer.image.colour import display
from tracer.image.metrics import relative_mse


def dark_edges(evidence: Evidence) -> np.ndarray:
    """Return the importance of each pixel (H, W)."""
    brightness = evidence.statistics.mean.mean(axis=-1)
    return (0.2 + evidence.complexity.shape_entropy) / (brightness + 0.1)


scene = files("tracer.scenes") / "thin_rods.xml"
reference = tracer.render(scene, spp=256, size=128, criterion="uniform", seed=1000)

# %%
# Here it is beside even samples and beside the default.
figure, axes = plt.subplots(1, 3, figsize=(12, 3.2), layout="constrained")
for axis, criterion in zip(axes, ("uniform", dark_edges, "fused"), strict=True):
    result = tracer.render(scene, spp=16, size=128, criterion=criterion)
    name = criterion if isinstance(criterion, str) else criterion.__name__
    axis.imshow(display(result.rgb))
    axis.set_title(f"{name}: error {relative_mse(result.rgb, reference.rgb):.5f}")
    axis.axis("off")
plt.show()

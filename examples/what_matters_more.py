"""
Say what matters more
=====================

A mask, or weights of shapes, give more samples to what you care about.
"""

from importlib.resources import files

import matplotlib.pyplot as plt
import numpy as np

import tracer

scene = files("tracer.scenes") / "spheres_and_rods.xml"

# %%
# A mask may be an array or an image file of any size. Its values multiply the
# importance of the pixels.
mask = np.full((144, 192), 0.1)
mask[:, :96] = 1

# %%
# ``shape_weights`` names shapes by their ids in the scene file.
weighted = {
    "as it comes": tracer.render(scene, spp=16, size=128),
    "a mask: the left half": tracer.render(scene, spp=16, size=128, importance=mask),
    "a weight: the ground": tracer.render(
        scene, spp=16, size=128, shape_weights={"ground": 8}
    ),
}
figure, axes = plt.subplots(1, 3, figsize=(12, 3.2), layout="constrained")
for axis, (title, result) in zip(axes, weighted.items(), strict=True):
    axis.imshow(result.samples, norm="log", cmap="magma", vmin=4, vmax=256)
    axis.set_title(title)
    axis.axis("off")
plt.show()

"""
Learn which lights matter where
===============================

Mitsuba chooses one of all lights, each with the same chance. With ``guide=True`` a few
paths first find out which lights matter where.
"""

from importlib.resources import files

import matplotlib.pyplot as plt

import tracer
from tracer.image.colour import display
from tracer.image.metrics import relative_mse

scene = files("tracer.scenes") / "many_lights.xml"
reference = tracer.render(
    scene, spp=256, size=192, criterion="uniform", guide=True, seed=1000
)

# %%
# The same number of samples, with and without what was learned. What the report notes
# says how much less noise was expected.
figure, axes = plt.subplots(1, 2, figsize=(10, 3.9), layout="constrained")
for axis, guide in zip(axes, (False, True), strict=True):
    result = tracer.render(scene, spp=16, size=192, guide=guide)
    print(*result.report.notes, sep="\n")
    axis.imshow(display(result.rgb))
    axis.set_title(
        f"guide={guide}: error {relative_mse(result.rgb, reference.rgb):.4f}"
    )
    axis.axis("off")
plt.show()

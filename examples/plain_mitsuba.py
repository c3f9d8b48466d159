"""
Under plain Mitsuba
===================

The integrator ``adaptive`` and the sampler ``owen_sobol`` are plugins, so scripts for
Mitsuba can stay as they are.
"""

import matplotlib.pyplot as plt

import tracer

tracer.activate()  # sets a variant unless one is set, and registers the plugins
import mitsuba as mi

scene = mi.load_dict(mi.cornell_box())

# %%
# ``adaptive`` renders any integrator of Mitsuba that follows camera rays.
adaptive = mi.load_dict(
    {"type": "adaptive", "nested": {"type": "path", "max_depth": 8}}
)
picture = mi.render(scene, integrator=adaptive, spp=64)

# %%
# What ``tracer.render`` returns is kept in ``result``.
figure, (left, right) = plt.subplots(1, 2, figsize=(9, 4), layout="constrained")
left.imshow(mi.util.convert_to_bitmap(picture))
samples = right.imshow(adaptive.result.samples, norm="log", cmap="magma")
figure.colorbar(samples, ax=right, label="samples")
for axis in (left, right):
    axis.axis("off")
plt.show()

"""
Solve radiosity once, look often
================================

The integrator ``radiosity`` solves the light of all patches at the first picture;
further views of the same scene only gather it.
"""

import time

import matplotlib.pyplot as plt

import tracer

tracer.activate()
import mitsuba as mi

cornell_box = mi.cornell_box()
cornell_box["sensor"]["film"]["width"] = cornell_box["sensor"]["film"]["height"] = 128
scene = mi.load_dict(cornell_box)

# %%
# ``show`` says what the picture shows: the patches as they are, smoothed, or light
# gathered anew at every point.
figure, axes = plt.subplots(1, 3, figsize=(12, 4.2), layout="constrained")
for axis, show in zip(axes, ("patches", "smooth", "gather"), strict=True):
    radiosity = mi.load_dict({"type": "radiosity", "show": show})
    mi.render(scene, integrator=radiosity, spp=1)
    start = time.perf_counter()
    picture = mi.render(scene, integrator=radiosity, spp=16)
    axis.imshow(mi.util.convert_to_bitmap(picture))
    axis.set_title(f"{show}: {time.perf_counter() - start:.1f} s after it is solved")
    axis.axis("off")
plt.show()

"""
Find the best view
==================

A view is good if much can be seen in it, in equal parts: if the entropy of what is seen
is high.
"""

import matplotlib.pyplot as plt
import numpy as np

import tracer

tracer.activate()
import mitsuba as mi

from tracer.core.sphere import icosphere
from tracer.viewpoint.item_buffer import Rays, around
from tracer.viewpoint.lens import Orthographic
from tracer.viewpoint.surfaces import open_subject
from tracer.viewpoint.survey import survey

# %%
# Some boxes in front of a wall: from behind the wall none of them can be seen.
boxes = {
    f"box {number}": {
        "type": "cube",
        "to_world": mi.ScalarTransform4f()
        .translate([x, 0.4 * number, 0])
        .scale([0.3, 0.15, 0.3 + 0.1 * number]),
    }
    for number, x in enumerate((-1.2, -0.4, 0.4, 1.2))
}
wall = {
    "type": "cube",
    "to_world": mi.ScalarTransform4f().translate([0, -0.6, 0]).scale([2.0, 0.05, 1.0]),
}
scene = mi.load_dict({"type": "scene", "wall": wall, **boxes})

# %%
# ``survey`` measures views from all around, given by the corners of an icosphere.
directions, triangles = icosphere(3)
subject = open_subject(scene)
viewpoints = around(np.zeros(3), 6.0, directions)
values = survey(
    subject, viewpoints, Orthographic(reach=2.2), Rays(side=128), ["entropy", "visible"]
)

# %%
# The best view looks at the boxes from their side of the wall, aslant, so that more of
# their sides are seen.
best = directions[np.argmax(values["entropy"])]
print("the best view is from", np.round(best, 2))
figure, axis = plt.subplots(
    subplot_kw={"projection": "3d"}, figsize=(6, 5), layout="constrained"
)
points = axis.scatter(*directions.T, c=values["entropy"], cmap="viridis", s=30)
axis.quiver(0, 0, 0, *(1.3 * best), color="tab:red")
figure.colorbar(points, label="entropy (bits)")
axis.set_box_aspect((1, 1, 1))
plt.show()

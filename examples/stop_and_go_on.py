"""
Stop, and go on later
=====================

A checkpoint keeps the state of a render. What is resumed ends as the same picture, to
the last bit.
"""

from importlib.resources import files
from pathlib import Path
from tempfile import TemporaryDirectory

import matplotlib.pyplot as plt
import numpy as np

import tracer
from tracer.image.colour import display

scene = files("tracer.scenes") / "depth_of_field.xml"

with TemporaryDirectory() as folder:
    checkpoint = Path(folder) / "render.ckpt"

    # This render is stopped by its callback when a quarter of the samples are drawn.
    stopped = tracer.render(
        scene,
        spp=64,
        size=128,
        checkpoint=checkpoint,
        progress=lambda now: now.done < 16 * 128 * 96,
    )
    print(stopped.report.notes[-1])

    resumed = tracer.render(scene, spp=64, size=128, checkpoint=checkpoint, resume=True)

# %%
# The same render without an interruption:
straight = tracer.render(scene, spp=64, size=128)
print("the same to the last bit:", np.array_equal(resumed.image, straight.image))

figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.4), layout="constrained")
left.imshow(display(stopped.rgb))
left.set_title("stopped")
right.imshow(display(resumed.rgb))
right.set_title("resumed")
plt.show()

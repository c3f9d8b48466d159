"""
Render until the noise is low
=============================

Ask for an error instead of a number of samples, watch the render, and stop it when you
like.
"""

# %%
# ``noise=0.1`` means: 95 of 100 pixels are estimated to be off by at most a tenth of
# their brightness. ``progress`` is called after every pass; if it returns False, the
# render stops and keeps what there is.
from importlib.resources import files

import matplotlib.pyplot as plt

import tracer
from tracer.image.colour import display

seen = []


def watch(now: tracer.Progress) -> bool:
    """Remember how many pixels were good enough, and stop after a minute."""
    seen.append((now.done, now.converged))
    return now.seconds < 60


result = tracer.render(
    files("tracer.scenes") / "spheres_and_rods.xml", noise=0.1, size=128, progress=watch
)
report = result.report
print(f"{report.spp:.0f} samples per pixel")
print(f"{100 * report.converged:.1f} % of the pixels converged")

# %%
# The report counts the pixels by how many samples they have.
figure, (left, right) = plt.subplots(1, 2, figsize=(11, 3.6), layout="constrained")
left.imshow(display(result.rgb))
left.axis("off")
right.bar(list(report.histogram), list(report.histogram.values()))
right.set(xlabel="samples", ylabel="pixels")
plt.show()

"""A scene of as many meshes as asked for, each with a BSDF of its own, a third of them textured."""

from __future__ import annotations

from math import ceil, sqrt
from pathlib import Path

import numpy as np

SPACING = 2.5
"""Distance between neighbouring shapes."""
FRAME = """<scene version="3.0.0">
    <integrator type="path"><integer name="max_depth" value="6"/></integrator>
    <sensor type="perspective">
        <float name="fov" value="45"/>
        <transform name="to_world">
            <lookat origin="0, {distance}, {height}" target="0, 0, 0" up="0, 0, 1"/>
        </transform>
        <film type="hdrfilm"><integer name="width" value="1280"/><integer name="height" value="720"/></film>
        <sampler type="independent"/>
    </sensor>
    <emitter type="constant"/>
    <shape type="sphere">
        <point name="center" x="0" y="{distance}" z="{distance}"/>
        <emitter type="area"><rgb name="radiance" value="200"/></emitter>
    </shape>
    <shape type="rectangle">
        <transform name="to_world"><scale value="{distance}"/></transform>
        <bsdf type="diffuse"/>
    </shape>
{shapes}
</scene>
"""
SHAPE = """    <shape type="{kind}">
        <transform name="to_world"><rotate z="1" angle="{angle}"/><translate x="{x}" y="{y}" z="1"/></transform>
        {bsdf}
    </shape>"""
BSDFS = (
    '<bsdf type="diffuse"><texture name="reflectance" type="checkerboard"><rgb name="color0" value="{colour}"/>'
    '<transform name="to_uv"><scale value="4"/></transform></texture></bsdf>',
    '<bsdf type="roughplastic"><rgb name="diffuse_reflectance" value="{colour}"/></bsdf>',
    '<bsdf type="roughconductor"><rgb name="specular_reflectance" value="{colour}"/></bsdf>',
)
KINDS = ("cube", "sphere", "cylinder")


def write_scene(path: Path, shape_count: int) -> None:
    """Write the scene to a file; the same number gives the same scene."""
    generator = np.random.default_rng(shape_count)
    side = ceil(sqrt(shape_count))
    shapes = []
    for number in range(shape_count):
        row, column = divmod(number, side)
        colour = ", ".join(f"{value:.3f}" for value in generator.uniform(0.2, 0.9, 3))
        shapes.append(
            SHAPE.format(
                kind=KINDS[int(generator.integers(len(KINDS)))],
                angle=f"{generator.uniform(0, 360):.1f}",
                x=f"{SPACING * (column - side / 2):.2f}",
                y=f"{SPACING * (row - side / 2):.2f}",
                bsdf=BSDFS[number % len(BSDFS)].format(colour=colour),
            )
        )
    distance = SPACING * side
    path.write_text(FRAME.format(distance=distance, height=0.6 * distance, shapes="\n".join(shapes)))

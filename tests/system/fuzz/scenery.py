"""Small scenes that load, to be broken. Few structures, so that kernels are compiled once."""

import numpy as np

FILM = (
    '<film type="hdrfilm"><integer name="width" value="8"/><integer name="height" value="6"/>'
    '<rfilter type="{filter}"/></film>'
)
SENSOR = (
    '<sensor type="perspective" id="eye"><float name="fov" value="45"/><float name="near_clip" value="0.01"/>'
    '<transform name="to_world"><lookat origin="0, 0, 4" target="0, 0, 0" up="0, 1, 0"/></transform>'
    '{film}<sampler type="independent"><integer name="sample_count" value="2"/></sampler></sensor>'
)
PLAIN = (
    '<integrator type="path"><integer name="max_depth" value="3"/></integrator>'
    + SENSOR.format(film=FILM.format(filter="box"))
    + '<emitter type="constant"><rgb name="radiance" value="0.5, 0.6, 0.7"/></emitter>'
)
SHAPES = (
    '<bsdf type="diffuse" id="grey"><rgb name="reflectance" value="0.5"/></bsdf>'
    '<shape type="sphere" id="ball"><point name="center" x="0" y="0" z="0"/><float name="radius" value="0.7"/>'
    '<ref id="grey"/></shape>'
    '<shape type="rectangle" id="floor"><transform name="to_world"><rotate x="1" angle="-90"/>'
    '<scale value="3"/><translate x="0" y="-1" z="0"/></transform><bsdf type="diffuse"/></shape>'
)
LAMP = (
    '<shape type="rectangle" id="lamp"><transform name="to_world"><translate x="0" y="0" z="5"/></transform>'
    '<emitter type="area"><rgb name="radiance" value="4, 4, 3"/></emitter></shape>'
    '<emitter type="point"><point name="position" x="1" y="2" z="2"/><rgb name="intensity" value="3"/></emitter>'
)
FOG = (
    '<integrator type="volpath"><integer name="max_depth" value="3"/></integrator>'
    + SENSOR.format(film=FILM.format(filter="box"))
    + '<shape type="cube" id="fog"><bsdf type="null"/><medium name="interior" type="homogeneous">'
    '<rgb name="albedo" value="0.8"/><float name="sigma_t" value="0.7"/><phase type="hg"><float name="g" value="0.3"/>'
    '</phase></medium></shape><emitter type="constant"/>'
)
ADAPTIVE = PLAIN.replace(
    '<integrator type="path">',
    '<integrator type="adaptive"><integer name="spp" value="2"/><string name="criterion" value="uniform"/>'
    '<string name="shape_weights" value="ball=2"/><boolean name="unbiased" value="false"/><integrator type="path">',
).replace("</integrator>", "</integrator></integrator>", 1)
ADAPTIVE = ADAPTIVE.replace('sampler type="independent"', 'sampler type="owen_sobol"') + SHAPES
RADIOSITY = PLAIN.replace(
    '<integrator type="path"><integer name="max_depth" value="3"/>',
    '<integrator type="radiosity"><float name="size" value="2"/><integer name="rays" value="16"/>'
    '<string name="show" value="patches"/>',
) + (
    '<shape type="cube" id="box"><bsdf type="diffuse"/></shape>'
    '<shape type="rectangle"><emitter type="area"><rgb name="radiance" value="1"/></emitter></shape>'
)
GLOSS = PLAIN + (
    '<shape type="sphere" id="ball"><bsdf type="twosided"><bsdf type="roughconductor"><string name="material" '
    'value="Au"/><float name="alpha" value="0.2"/></bsdf></bsdf></shape>'
    '<shape type="disk"><bsdf type="mask"><float name="opacity" value="0.5"/><bsdf type="roughdielectric">'
    '<string name="int_ior" value="bk7"/><float name="alpha" value="0.1"/></bsdf></bsdf></shape>'
    '<shape type="cylinder"><bsdf type="blendbsdf"><float name="weight" value="0.5"/><bsdf type="plastic"/>'
    '<bsdf type="principled"><float name="roughness" value="0.4"/></bsdf></bsdf></shape>'
)
MESH = PLAIN + '<shape type="{kind}" id="mesh"><string name="filename" value="{file}"/><bsdf type="diffuse"/></shape>'
TEXTURED = PLAIN + (
    '<shape type="rectangle" id="wall"><bsdf type="diffuse"><texture name="reflectance" type="bitmap">'
    '<string name="filename" value="{file}"/><string name="filter_type" value="bilinear"/>'
    '<string name="wrap_mode" value="repeat"/></texture></bsdf></shape>'
)
SKY = (
    '<integrator type="path"><integer name="max_depth" value="3"/></integrator>'
    + SENSOR.format(film=FILM.format(filter="box"))
    + '<emitter type="envmap"><string name="filename" value="{file}"/><float name="scale" value="1"/></emitter>'
    '<shape type="sphere" id="ball"><bsdf type="diffuse"/></shape>'
)
WIDE = PLAIN.replace('rfilter type="box"', 'rfilter type="gaussian"')
SCENES = {
    "plain": PLAIN + SHAPES,
    "lamp": PLAIN + SHAPES + LAMP,
    "fog": FOG,
    "adaptive": ADAPTIVE,
    "radiosity": RADIOSITY,
    "gloss": GLOSS,
    "wide": WIDE + SHAPES,
}


def words(*lines):
    """Return the words of some lines."""
    return [word for line in lines for word in line.split()]


def xml(body):
    """Return a scene file with ``body`` in it."""
    return f'<scene version="3.0.0">{body}</scene>'


def pixels(random, height=8, width=8, channels=3):
    """Return a small picture, float32."""
    return np.random.default_rng(random.getrandbits(32)).random((height, width, channels), np.float32)

"""Emitters and materials whose light is not a number, infinite, negative or of no spectrum."""

from .scene_inputs import render, small
from .scenery import FILM, SENSOR, SHAPES, words, xml

NUMBERS = words("nan inf -inf -1 0 1 1e38 3e38 1e39 -1e38 1e-38 1e-45")
START = '<integrator type="path"><integer name="max_depth" value="4"/></integrator>' + SENSOR.format(
    film=FILM.format(filter="box")
)
LIGHTS = (
    '<emitter type="constant"><rgb name="radiance" value="{0}, {1}, {2}"/></emitter>',
    '<emitter type="constant"><float name="radiance" value="{0}"/></emitter>',
    '<shape type="sphere"><float name="radius" value="9"/><boolean name="flip_normals" value="true"/>'
    '<emitter type="area"><rgb name="radiance" value="{0}, {1}, {2}"/></emitter></shape>',
    '<emitter type="point"><point name="position" x="{1}" y="2" z="2"/><rgb name="intensity" value="{0}"/></emitter>',
    '<emitter type="directional"><vector name="direction" x="{1}" y="0" z="-1"/><rgb name="irradiance" value="{0}"/>'
    "</emitter>",
    '<emitter type="spot"><float name="cutoff_angle" value="{1}"/><rgb name="intensity" value="{0}"/></emitter>',
    '<emitter type="constant"><spectrum name="radiance" value="400:{0}, 500:{1}, 600:{2}"/></emitter>',
    '<emitter type="constant"><spectrum name="radiance" type="blackbody"><float name="temperature" value="{0}"/>'
    "</spectrum></emitter>",
    '<emitter type="sunsky"><float name="turbidity" value="{0}"/><float name="albedo" value="{1}"/></emitter>',
)
MATERIALS = (
    '<bsdf type="diffuse"><rgb name="reflectance" value="{0}, {1}, {2}"/></bsdf>',
    '<bsdf type="roughconductor"><float name="alpha" value="{0}"/></bsdf>',
    '<bsdf type="dielectric"><float name="int_ior" value="{0}"/><float name="ext_ior" value="{1}"/></bsdf>',
    '<bsdf type="principled"><float name="roughness" value="{0}"/><float name="metallic" value="{1}"/></bsdf>',
)


def lights(random, folder):
    numbers = [random.choice([*NUMBERS, "1", "1"]) for _ in range(3)]
    lit = "".join(random.sample(LIGHTS, random.choice([1, 1, 2]))).format(*numbers)
    body = START + lit + (SHAPES if random.random() < 0.8 else "")
    options = random.choice([[], [], ["--criterion", "uniform"], ["--objective", "display"]])
    return render(folder, xml(body), *small(random), *options, "--spp", random.choice(["1", "2", "9"]))


def materials(random, folder):
    numbers = [random.choice(NUMBERS) for _ in range(3)]
    shape = f'<shape type="sphere">{random.choice(MATERIALS).format(*numbers)}</shape>'
    return render(folder, xml(START + '<emitter type="constant"/>' + shape), *small(random))


TRANSFORMS = (
    '<scale value="{0}"/>',
    '<translate x="{0}" y="{1}"/>',
    '<rotate x="{0}" y="{1}" angle="{2}"/>',
    '<lookat origin="{0}, 0, 0" target="{1}, 0, 0" up="0, 1, 0"/>',
    '<matrix value="{0} 0 0 0 0 {1} 0 0 0 0 {2} 0 0 0 0 1"/>',
    '<matrix value="{0} 0 0"/>',
)


def transforms(random, folder):
    """Cameras and shapes that are flat, turned inside out, infinitely far, or nowhere."""
    numbers = [random.choice(NUMBERS) for _ in range(3)]
    text = random.choice(TRANSFORMS).format(*numbers)
    start, shapes = START, SHAPES
    if random.random() < 0.5:
        start = start.replace('<lookat origin="0, 0, 4" target="0, 0, 0" up="0, 1, 0"/>', text)
    else:
        shapes = shapes.replace('<scale value="3"/>', text)
    if random.random() < 0.3:
        shapes = shapes.replace('"radius" value="0.7"', f'"radius" value="{random.choice(NUMBERS)}"')
    return render(folder, xml(start + '<emitter type="constant"/>' + shapes), *small(random))

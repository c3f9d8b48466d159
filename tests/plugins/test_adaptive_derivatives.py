"""Derivatives through the integrator are those of the nested one."""

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest

from conformance.cases import scene

KEY = "floor.bsdf.reflectance.value"


def grey_floor(integrator="prb", reflectance=0.4):
    description = scene(integrator)
    description["floor"]["bsdf"] = {"type": "diffuse", "reflectance": {"type": "rgb", "value": [reflectance] * 3}}
    return description


def integrators(description):
    nested = mi.load_dict(description["integrator"])
    return nested, mi.load_dict({"type": "adaptive", "nested": description["integrator"]})


def gradient(loaded, integrator, *, forward):
    """Return the derivative of the floor's red, of every pixel (forward) or of their sum (backward)."""
    parameters = mi.traverse(loaded)
    value = mi.Float(0.0)
    dr.enable_grad(value)
    parameters[KEY] = mi.Color3f(0.4 + value, 0.4, 0.4)
    parameters.update()
    image = mi.render(loaded, parameters, integrator=integrator, spp=32, seed=3)
    if forward:
        dr.forward(value)
        found = np.array(dr.grad(image))
    else:
        dr.backward(dr.sum(image.array))
        found = np.array(dr.grad(value))
    parameters[KEY] = mi.Color3f(0.4)
    parameters.update()
    return found


@pytest.mark.parametrize("name", ["prb", "direct"])
@pytest.mark.parametrize("forward", [True, False])
def test_gradients_are_those_of_the_nested_integrator(name, forward):
    description = grey_floor(name)
    loaded = mi.load_dict(description)
    nested, adaptive = integrators(description)
    expected = gradient(loaded, nested, forward=forward)
    found = gradient(loaded, adaptive, forward=forward)
    assert np.abs(expected).max() > 0.1
    assert found == pytest.approx(expected, rel=1e-3, abs=float(1e-3 * np.abs(expected).max()))


def test_gradient_is_the_slope_of_the_adaptive_picture(monkeypatch):
    monkeypatch.setattr("tracer.film.bias.MOST", 0.0)  # the mean of so small a picture would be noisier than its slope
    description = grey_floor()
    _, adaptive = integrators(description)
    slope = gradient(mi.load_dict(description), adaptive, forward=False)
    bright, dark = (
        np.array(mi.render(mi.load_dict(grey_floor(reflectance=r)), integrator=adaptive, spp=512, seed=1))[..., 0]
        for r in (0.45, 0.35)
    )
    assert slope == pytest.approx((bright.sum() - dark.sum()) / 0.1, rel=0.05)


@pytest.mark.slow
def test_inverse_rendering_finds_an_albedo():
    description = grey_floor(reflectance=0.2)
    _, adaptive = integrators(description)
    wanted = mi.render(mi.load_dict(grey_floor(reflectance=0.7)), spp=512, seed=99)
    loaded = mi.load_dict(description)
    parameters = mi.traverse(loaded)
    optimizer = mi.ad.Adam(lr=0.05)
    optimizer[KEY] = parameters[KEY]
    parameters.update(optimizer)
    for step in range(60):
        image = mi.render(loaded, parameters, integrator=adaptive, spp=16, seed=step)
        dr.backward(dr.mean(dr.square(image.array - wanted.array)))
        optimizer.step()
        parameters.update(optimizer)
    assert np.array(parameters[KEY]).ravel() == pytest.approx([0.7] * 3, abs=0.03)

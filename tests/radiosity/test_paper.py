"""The paper's rules: how many rays, with which energy, and what is lost when they are taken literally."""

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest
from scipy import stats

from radiosity.scenery import UPWARDS, furnace, mean_form_factor, two_triangles
from tracer.core.sphere import solid_angle
from tracer.errors import SceneError, SettingsError
from tracer.radiosity.gathering import solve
from tracer.radiosity.groups import Points, alone
from tracer.radiosity.hemisphere import NOTHING
from tracer.radiosity.meshing import cut
from tracer.radiosity.paper import PaperRays, PaperRules, paper_guide
from tracer.radiosity.shooting import shoot
from tracer.radiosity.spread import SPREADS, chosen_spread
from tracer.radiosity.triangle_hierarchy import pyramid
from tracer.radiosity.uniform_triangle import uniform_in_triangle, uniform_table_of

POINTS = Points(np.zeros((3, 3)), np.tile([0.0, 0, 1], (3, 1)))


def guide_of(rules, see):
    return paper_guide(see, alone(POINTS), rules, 50, seed=1)


def checkered(ray):
    """See many things towards +x and +y, and one elsewhere."""
    busy = (ray.d.x > 0) & (ray.d.y > 0)
    number = mi.UInt32(mi.Int32(dr.floor(20 * (ray.d.x + 2 * ray.d.y))))
    return dr.select(busy, number, 0), white(ray)


def white(ray):
    return mi.Color3f(1.0) + dr.zeros(mi.Float, dr.width(ray))


def wall(ray):
    """See one thing everywhere."""
    return dr.zeros(mi.UInt32, dr.width(ray)), white(ray)


def drawn(way, ray_count, point_count=3):
    lane = dr.arange(mi.UInt32, ray_count * point_count)
    local, weight = way(lane // ray_count, lane % ray_count, dr.opaque(mi.UInt32, ray_count), 7)
    return np.array(local).T.reshape(point_count, ray_count, 3), np.array(weight).reshape(point_count, ray_count)


@pytest.mark.parametrize("triangle", range(20))
def test_directions_fill_a_triangle_evenly(triangle):
    """Its four parts, in proportion to their area; chi-square with 3 degrees of freedom, false alarm 1e-6 in all."""
    side = 128
    lane = dr.arange(mi.UInt32, side * side)
    u, v = (mi.Float(lane % side) + 0.5) / side, (mi.Float(lane // side) + 0.5) / side
    found = np.array(uniform_in_triangle(uniform_table_of(2), mi.UInt32(triangle), u, v)).T
    assert np.linalg.norm(found, axis=1) == pytest.approx(np.ones(side * side), abs=1e-5)
    corners = pyramid(2).corners
    level = int(np.searchsorted(pyramid(2).first, triangle, side="right")) - 1
    inside = np.zeros(len(found), bool)
    for part in pyramid(2).children(np.array([triangle]), level)[0]:
        a, b, c = corners[part]
        within = np.all([found @ np.cross(*edge) > -1e-6 for edge in ((a, b), (b, c), (c, a))], axis=0)
        expected = solid_angle(a, b, c) / solid_angle(*corners[triangle])
        assert within.mean() == pytest.approx(expected, abs=0.01)
        inside |= within
    assert inside.all()


def test_rays_are_in_proportion_to_complexity():
    guide = guide_of(PaperRules("distinct", 100.0, 0, 64), checkered)
    local, _ = drawn(PaperRays(guide, right=False), 4000)
    busy = (local[..., 0] > 0) & (local[..., 1] > 0)
    complexity = guide.regions.complexity[:4, 0]
    quarter = np.argmax(complexity)
    assert complexity[quarter] > 5
    assert busy.mean() == pytest.approx((complexity / complexity.sum())[quarter], abs=0.02)


@pytest.mark.parametrize("depth", [0, 1, 2, 3])
def test_literally_energy_is_too_much_and_right_it_is_pi_on_average(depth):
    """Area times cosine of the middle: 3.628 for four octants, 3.9 % too much one level further."""
    rules = PaperRules("distinct", 0.0, depth, 4)
    guide = guide_of(rules, wall)
    literal, right = (drawn(PaperRays(guide, flag), 4096)[1].sum(axis=1) for flag in (False, True))
    expected = {0: 3.628, 1: 1.039 * np.pi}.get(depth)
    if expected is not None:
        assert literal == pytest.approx(np.full(3, expected), rel=2e-3)
    assert np.all(literal > np.pi)
    assert right == pytest.approx(np.full(3, np.pi), rel=0.03)


def test_right_it_is_the_integral_and_literally_it_is_not():
    """Irradiance of a radiance 1 + x + 3 z over the hemisphere: pi + 2 pi."""
    guide = guide_of(PaperRules("distinct", 2.5, 1, 8), checkered)
    means = []
    for right in (False, True):
        local, weight = drawn(PaperRays(guide, right), 1 << 16)
        means.append(float(((1 + local[..., 0] + 3 * local[..., 2]) * weight).sum(axis=1).mean()))
    assert means[1] == pytest.approx(3 * np.pi, rel=0.005)
    assert abs(means[0] / (3 * np.pi) - 1) > 0.02


def test_where_nothing_is_seen_rays_are_spread_over_all():
    guide = guide_of(PaperRules(), lambda ray: (wall(ray)[0] + NOTHING, white(ray)))
    _, weight = drawn(PaperRays(guide, right=True), 1024)
    assert weight.sum(axis=1) == pytest.approx(np.full(3, np.pi), rel=0.05)


@pytest.mark.parametrize("name", ["randomly", "paper_right"])
def test_a_furnace_is_right(name):
    """In a closed room whose walls all shine and reflect, radiosity is E / (1 - albedo)."""
    patches = cut(furnace([0.5, 0.5, 0.5]), 0.5)
    found = solve(patches, 256, residual=1e-6, spread=SPREADS[name])
    expected = (patches.emitted / (1 - patches.albedo)).mean()
    assert found.radiosity.mean() == pytest.approx(expected, rel=0.01)
    assert found.energy == pytest.approx(1.0, abs=0.01)
    shot = shoot(patches, 256, 1e-5, spread=SPREADS[name])
    assert shot.radiosity.mean() == pytest.approx(expected, rel=0.02)


def test_a_literal_furnace_is_too_bright_and_says_so():
    patches = cut(furnace([0.5, 0.5, 0.5]), 0.5)
    found = solve(patches, 256, residual=1e-6, spread=SPREADS["paper"])
    assert found.energy > 1.003
    expected = (patches.emitted / (1 - patches.albedo)).mean()
    assert found.radiosity.mean() / expected == pytest.approx(0.5 / (1 - 0.5 * found.energy), rel=0.02)


def test_literal_shooting_makes_as_much_light_as_the_rules_say():
    """Two triangles that shine at each other, split into octants: area times cosine is 2 / sqrt(3) of their energy."""
    patches = cut(two_triangles())
    low = int(patches.emitted.max(axis=1).argmax())
    made = 2 / np.sqrt(3)
    exchanged = 0.6 * made * mean_form_factor(UPWARDS * patches.points.outside)
    found = shoot(patches, 1 << 18, 1e-9, spread=PaperRules(depth=0, look=256))
    expected = 2 * np.pi * np.array([1.0, exchanged]) / (1 - exchanged**2)
    # Over seeds the errors have a standard deviation of 0.002.
    assert found.radiosity[[low, 1 - low], 0] == pytest.approx(expected, rel=0.01)
    assert found.energy == pytest.approx(made, rel=1e-4)
    assert found.lost.sum() + found.absorbed.sum() > 1.1 * found.supplied.sum()


def test_shooting_with_energies_made_right_is_right_on_average_with_few_rays():
    """Six rays of each patch. If the energies of a patch were scaled to their sum, it would be 3.4 % too dark."""
    patches = cut(two_triangles(), 0.04)
    high = patches.emitted.max(axis=1) == 0

    def received(rays, seed, spread=None):
        return np.sum((patches.areas[:, None] * shoot(patches, rays, 1e-4, seed, spread).irradiance)[high])

    rules = PaperRules(depth=0, look=1, right=True)
    ratios = np.array([received(6, 977 * seed, rules) for seed in range(24)]) / received(4096, 1)
    error = ratios.std(ddof=1) / np.sqrt(len(ratios))
    assert error < 0.006
    assert abs(ratios.mean() - 1) < stats.t.isf(1e-4 / 2, len(ratios) - 1) * error


def test_light_that_the_rules_make_without_end_is_told_of():
    patches = cut(furnace([0.95] * 3), 1.0)
    for way in (shoot, solve):
        with pytest.raises(SceneError, match=r"carry 11\d.\d % of the energy there is; choose paper_right"):
            way(patches, 64, spread=PaperRules(depth=0, look=4))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("odd", "gathering"), "spread is one of"),
        (("guided", "shooting"), "cannot be guided"),
        (("evenly", "paper"), "'paper' is a way to spread rays: spread=paper"),
        (("evenly", "odd"), "method is one of gathering, shooting, not 'odd'."),
        (("evenly", "gathering", 0.5), "are for the paper's rules"),
        (("paper", "gathering", -1.0), "must not be negative"),
        (("paper", "gathering", None, 5), "from 0 to 4"),
    ],
    ids=str,
)
def test_what_cannot_be_is_one_sentence(arguments, message):
    with pytest.raises(SettingsError, match=message):
        chosen_spread(*arguments)

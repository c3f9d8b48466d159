"""Atoms from files and from lattices, and the views that chemists know."""

import numpy as np
import pytest

from tracer.core import sphere
from tracer.errors import SettingsError
from tracer.viewpoint.atom_files import Atoms
from tracer.viewpoint.balls_and_sticks import solid
from tracer.viewpoint.direction_measure import Gauge, stand
from tracer.viewpoint.item_buffer import Rays, around, projected_areas
from tracer.viewpoint.lens import Orthographic
from tracer.viewpoint.molecules import ball, open_molecule, recentred, repeat, zone_axes
from tracer.viewpoint.search import exhaustive_search
from tracer.viewpoint.survey import survey

CUT = 7.0


def diamond():
    """Return a ball of 264 atoms around the middle of a bond."""
    a = 3.567
    corners = np.array([[0, 0, 0], [0, 2, 2], [2, 0, 2], [2, 2, 0]]) / 4
    positions = np.concatenate([corners, corners + 0.25]) * a
    return ball(Atoms(["C"] * 8, positions, a * np.eye(3)), CUT, np.full(3, a / 8))


def graphite():
    """Return a ball of 166 atoms around the middle between two atoms of neighbouring layers."""
    a, c = 2.461, 6.708
    cell = np.array([[a, 0, 0], [-a / 2, a * 3**0.5 / 2, 0], [0, 0, c]])
    basis = np.array([[0, 0, 0], [1 / 3, 2 / 3, 0], [0, 0, 0.5], [2 / 3, 1 / 3, 0.5]])
    return ball(Atoms(["C"] * 4, basis @ cell, cell), CUT, [0, 0, c / 4])


def entropies(atoms, radius, directions, side=160):
    subject = open_molecule(atoms, radius)
    middle = atoms.positions.mean(axis=0)
    reach = np.linalg.norm(atoms.positions - middle, axis=1).max() + radius + 0.1
    views = around(middle, 50, sphere.normalised(directions))
    return survey(subject, views, Orthographic(reach), Rays(side=side), ["entropy"])["entropy"]


@pytest.mark.parametrize(
    ("radius", "expected"), [(0.25, [0.757, 0.924, 1.009, 1.282]), (0.77, [3.862, 4.942, 5.017, 4.961])]
)
def test_diamond_along_its_axes(radius, expected):
    atoms = diamond()
    assert len(atoms) == 264
    found = entropies(atoms, radius, [[1, 1, 0], [1, 1, 1], [1, 0, 0], [1, 1, 2]])
    assert found == pytest.approx(expected, abs=0.02)
    assert found[0] < found[1] < found[2]


@pytest.mark.parametrize(("radius", "expected"), [(0.25, [0.417, 0.506, 0.977]), (0.77, [2.189, 2.377, 5.037])])
def test_graphite_along_its_layers(radius, expected):
    atoms = graphite()
    assert len(atoms) == 166
    # Bonds are along the long diagonal of the cell (armchair), rows of cells along its sides (zigzag).
    found = entropies(atoms, radius, [[0, 1, 0], [1, 0, 0], [0, 0, 1]])
    assert found == pytest.approx(expected, abs=0.02)
    assert found[0] < found[1] < found[2]


@pytest.mark.slow
@pytest.mark.parametrize(("make", "best"), [(diamond, [[1, 1, 0]]), (graphite, [[0, 1, 0]])])
def test_the_narrow_minimum_is_found(make, best):
    atoms = make()
    known = entropies(atoms, 0.77, best)[0]
    subject = open_molecule(atoms, 0.77)
    gauge = Gauge(subject, stand(subject, orthographic=True), Rays(side=160), "entropy")
    found = exhaustive_search(lambda directions: -gauge(directions), level=2, also=zone_axes(atoms))
    again = entropies(atoms, 0.77, found.direction[None])[0]
    assert again <= known + 0.02


def test_zone_axes_of_a_lattice():
    axes = zone_axes(Atoms(["C"], np.zeros((1, 3)), np.diag([1.0, 2.0, 3.0])), most=1)
    assert np.linalg.norm(axes, axis=1) == pytest.approx(1)
    along = np.abs(axes @ sphere.normalised([[1, 0, 0], [1, 2, 0], [1, 2, 3]]).T).max(axis=0)
    assert along == pytest.approx(1)


def test_a_crystal_repeats_and_a_molecule_does_not():
    salt = Atoms(["Na", "Cl"], np.array([[0, 0, 0], [2.8, 0, 0]]), 5.6 * np.eye(3))
    twice = repeat(salt, (2, 1, 3))
    assert len(twice) == 12
    assert twice.cell == pytest.approx(np.diag([11.2, 5.6, 16.8]))
    assert sorted(set(twice.positions[:, 0].round(3))) == [0, 2.8, 5.6, 8.4]
    with pytest.raises(SettingsError, match="no cell"):
        repeat(Atoms(["H"], np.zeros((1, 3))), (2, 2, 2))
    with pytest.raises(SettingsError, match="at least once"):
        repeat(salt, (0, 1, 1))
    with pytest.raises(SettingsError, match="No atom lies within"):
        ball(Atoms(["H"], np.zeros((1, 3))), 1, [5, 0, 0])


def test_the_ball_of_a_skewed_cell_is_whole():
    atoms = Atoms(["C"], np.zeros((1, 3)), np.array([[1, 0, 0], [3.5, 1, 0], [0, 2.5, 1]]))  # a cubic lattice, sheared
    found = ball(atoms, 3.0, [0, 0, 0])
    n = np.arange(-3, 4)
    x, y, z = np.meshgrid(n, n, n)
    shift = np.stack([x, y, z], -1).reshape(-1, 3).astype(float)
    indices = np.stack(np.meshgrid(*[np.arange(-40, 41)] * 3), -1).reshape(-1, 3)
    expected = np.count_nonzero(np.linalg.norm(indices @ atoms.cell, axis=1) <= 3)
    assert len(found) == expected
    assert len(shift) == 343


def test_balls_have_the_radius_of_their_style():
    """Of S. Alvarez, 2013: hydrogen 1.20, carbon 1.77, iron 2.44 Angstrom; 2 of what is no element."""
    positions = 9 * np.arange(5)[:, None] * np.eye(3)[0]
    atoms = Atoms(["H", "C", "Fe", "X", "D"], positions)
    expected = 4 * np.pi * np.array([1.20, 1.77, 2.44, 2.0, 1.20]) ** 2
    assert open_molecule(atoms, style="space-filling").areas == pytest.approx(expected)
    assert open_molecule(atoms).areas == pytest.approx(expected / 16)
    assert open_molecule(Atoms(["H", "C"], positions[:2]), 0.4).areas == pytest.approx(4 * np.pi * 0.16)


@pytest.mark.parametrize("count", [1, 501, 12_501])
def test_the_solid_of_a_ball_has_its_mean_projected_area(count):
    points, faces = solid(count)
    a, b, c = points[faces].transpose(1, 0, 2)
    assert len(faces) == {1: 1280, 501: 320, 12_501: 80}[count]
    assert np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2 == pytest.approx(4 * np.pi)


LENGTH, BALL, STICK = 2.0, 0.5, 0.14


@pytest.mark.parametrize("counted", [False, True])
def test_a_stick_hides_what_is_behind_it_and_counts_if_asked(counted):
    """From beside, stick and ball meet in planes: what is seen is a rectangle, and discs without a segment."""
    atoms = Atoms(["C", "C"], np.array([[-LENGTH / 2, 0, 0], [LENGTH / 2, 0, 0]]))
    subject = open_molecule(atoms, BALL, np.array([[0, 1]]), counted)
    views = around(np.zeros(3), 9.0, np.array([[0.0, 1, 0]]))
    areas = next(projected_areas(subject, views, Orthographic(2), Rays(side=1000))).areas[0]
    middle = np.sqrt(BALL**2 - STICK**2)
    disc = np.pi * BALL**2 - (BALL**2 * np.arcsin(STICK / BALL) - middle * STICK)
    assert areas == pytest.approx([disc, disc, 2 * STICK * (LENGTH - 2 * middle)][: len(areas)], rel=0.005)
    assert subject.names == ["C", "C", "bond"][: len(areas)]
    assert len(areas) == (3 if counted else 2)
    if counted:
        assert subject.areas[2] == pytest.approx(2 * np.pi * STICK * (LENGTH - 2 * middle))


def test_the_sphere_around_a_molecule_is_tight():
    atoms = Atoms(["C", "O"], np.array([[0, 0, 0], [4.0, 0, 0]]))
    assert open_molecule(atoms, np.array([1.0, 0.5])).radius == pytest.approx(2.75, abs=0.01)


def test_a_molecule_has_no_curvature():
    subject = open_molecule(Atoms(["C"], np.zeros((1, 3))))
    views = around(np.zeros(3), 9.0, np.eye(3))
    with pytest.raises(SettingsError, match="need a mesh"):
        survey(subject, views, Orthographic(1), Rays(side=16), ["curvature_entropy"])


def test_far_atoms_are_brought_near():
    atoms = Atoms(["C", "O"], np.array([[1e7, -1e7, 0.25], [1e7 + 1.25, -1e7, 0.25]]))
    near, origin = recentred(atoms)
    assert near.positions == pytest.approx(np.array([[-0.625, 0, 0], [0.625, 0, 0]]))
    assert (near.positions + origin).tolist() == atoms.positions.tolist()
    assert recentred(near)[1].tolist() == [0, 0, 0]
    assert recentred(Atoms(["C"], np.full((1, 3), 1e7)))[1].tolist() == [1e7, 1e7, 1e7]


def test_radii_that_are_none():
    one = Atoms(["C"], np.zeros((1, 3)), np.eye(3))
    for radius in (-1.0, 0.0, np.nan, np.inf):
        with pytest.raises(SettingsError, match="positive"):
            open_molecule(one, radius)
        with pytest.raises(SettingsError, match="positive"):
            ball(one, radius)
    for much in (lambda: repeat(one, (400, 400, 400)), lambda: ball(one, 1e5)):
        with pytest.raises(SettingsError, match="smaller ball"):
            much()

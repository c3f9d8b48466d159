"""Surfaces of molecules against areas of spheres, and the sites from which another molecule is seen."""

import numpy as np
import pytest

from tracer.errors import SceneError, SettingsError
from tracer.viewpoint import docking
from tracer.viewpoint.atom_files import Atoms
from tracer.viewpoint.docking import find_sites, open_pair, surface_points
from tracer.viewpoint.elements import van_der_waals_radii


def molecule(symbols, positions):
    return Atoms(list(symbols), np.array(positions, float))


def test_a_single_atom_is_all_surface():
    points, atom = surface_points(molecule("C", [[1, 2, 3]]))
    assert len(points) == 42
    assert not atom.any()
    reach = van_der_waals_radii(["C"])[0] + docking.PROBE
    assert np.linalg.norm(points - [1, 2, 3], axis=1) == pytest.approx(np.full(42, reach))


def test_what_two_atoms_leave_of_each_other_is_a_cap(monkeypatch):
    monkeypatch.setattr(docking, "POINTS_LEVEL", 4)  # 2562 points an atom
    distance, reach = 2.0, van_der_waals_radii(["O"])[0] + docking.PROBE
    _, atom = surface_points(molecule("OO", [[0, 0, 0], [distance, 0, 0]]))
    free = (1 + distance / 2 / reach) / 2  # the cap of a sphere beyond the middle plane is cut off (Archimedes)
    assert np.bincount(atom) / 2562 == pytest.approx([free, free], abs=0.02)


def test_the_best_site_faces_the_other_molecule():
    seen = molecule("CCCC", [[10, 0, 0], [10, 2.5, 0], [10, -2.5, 0], [10, 0, 2.5]])
    from_ = molecule("NOS", [[-3, 0, 0], [0, 0, 0], [-6, 0, 0]])  # the oxygen is nearest
    subject = open_pair(seen, from_)
    assert subject.weights.tolist() == [1, 1, 1, 1, 0, 0, 0]
    sites = find_sites(seen, from_, subject, "projected_area", "most")
    best = sites.best_of_atoms()
    assert sites.atom[best[0]] == 1
    assert sites.points[best[0]][0] > 1
    assert len(set(sites.atom[best])) == len(best) == 3
    assert np.all(np.diff(sites.values[best]) <= 0)


def test_what_is_seen_of_a_ball_is_its_solid_angle():
    seen, from_ = molecule("C", [[8, 0, 0]]), molecule("O", [[0, 0, 0]])
    sites = find_sites(seen, from_, open_pair(seen, from_), "projected_area", "most")
    distance = np.linalg.norm(seen.positions[0] - sites.points, axis=1)
    facing = sites.points[:, 0] > 1.5
    share = (1 - np.sqrt(1 - (van_der_waals_radii(["C"])[0] / distance[facing]) ** 2)) / 2
    assert sites.values[facing] == pytest.approx(share, rel=0.08)


def test_what_is_hidden_by_the_molecule_itself_is_not_seen():
    seen, from_ = molecule("C", [[12, 0, 0]]), molecule("OO", [[0, 0, 0], [-3, 0, 0]])
    sites = find_sites(seen, from_, open_pair(seen, from_), "visible", "most")
    behind = sites.points[:, 0] < -4.0
    axis = np.linalg.norm(sites.points[:, 1:], axis=1) < 0.5
    assert np.all(np.isneginf(sites.values[behind & axis]))


def test_what_cannot_be_is_said():
    seen, from_ = molecule("C", [[9, 0, 0]]), molecule("O", [[0, 0, 0]])
    with pytest.raises(SettingsError, match="needs views as images"):
        find_sites(seen, from_, open_pair(seen, from_), "maximum_depth", "most")
    grid = np.stack(np.meshgrid(*[np.arange(-4.0, 4.1, 1.0)] * 3), axis=-1).reshape(-1, 3)
    around = molecule("C" * len(grid), grid)
    with pytest.raises(SceneError, match="fill each other"):
        find_sites(around, from_, open_pair(around, from_), "entropy", "most")

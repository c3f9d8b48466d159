"""What is known of chemical elements: radii in Angstrom, and the colours that chemists know.

The tables are those of ASE. Deuterium and tritium, D and T in many files, are hydrogen.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tracer.core.arrays import Floats, Integers
from tracer.image.colour import decode_srgb

ISOTOPES = {"D": 1, "T": 1}
"""Atomic numbers of symbols that stand for an isotope."""


def atomic_numbers(symbols: Sequence[str]) -> Integers:
    """Return the atomic numbers (N,) of elements; 0 of what is no element."""
    from ase.data import atomic_numbers as known

    different, place = np.unique(np.asarray(symbols, np.str_), return_inverse=True)
    numbers = [ISOTOPES.get(symbol, known.get(symbol, 0)) for symbol in different.tolist()]
    return np.array(numbers, np.int64)[place.reshape(-1)]


def covalent_radii(symbols: Sequence[str]) -> Floats:
    """Return covalent radii (N,) by element (B. Cordero and others, Dalton Transactions, 2008); 0.7 if unknown."""
    from ase.data import covalent_radii as table

    return radii_by_element(symbols, table, 0.7)


def van_der_waals_radii(symbols: Sequence[str]) -> Floats:
    """Return van der Waals radii (N,) by element (S. Alvarez, Dalton Transactions, 2013); 2 if unknown."""
    from ase.data.vdw_alvarez import vdw_radii

    return radii_by_element(symbols, vdw_radii, 2.0)


def radii_by_element(symbols: Sequence[str], table: Floats, unknown: float) -> Floats:
    """Return radii (N,) from a table by atomic number, in which number 0 is no element; ``unknown``: if it has none."""
    numbers = atomic_numbers(symbols)
    radii = np.where(numbers < len(table), table[np.minimum(numbers, len(table) - 1)], np.nan)
    return np.where((numbers > 0) & np.isfinite(radii), radii, unknown)


def colours_of(symbols: Sequence[str]) -> Floats:
    """Return colours (N, 3) of atoms by element, linear sRGB: those of Jmol, which chemists know."""
    from ase.data.colors import jmol_colors

    numbers = atomic_numbers(symbols)
    return decode_srgb(jmol_colors[np.where(numbers < len(jmol_colors), numbers, 0)].astype(np.float64))

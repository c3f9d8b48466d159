"""What a file of any kind becomes when it is opened: a subject, and how views of its kind are made."""

from __future__ import annotations

from dataclasses import dataclass

from tracer.core.arrays import Floats
from tracer.viewpoint.surfaces import Subject


@dataclass(frozen=True)
class Opened:
    """A subject, and how views of its kind are made."""

    subject: Subject
    colours: Floats | None = None
    """(F, 3): colours of the faces in pictures, linear sRGB; None if the scene has its own."""
    orthographic: bool = False
    """Whether the subject is looked at with parallel rays, as molecules are."""
    axes: Floats | None = None
    """(N, 3): directions that a search should try, as atoms line up along them."""
    crystal: bool = False
    """Whether the subject is a part of a lattice."""
    up: tuple[float, float, float] = (0.0, 0.0, 1.0)
    """Upward direction: the axis nearest to that of the scene's camera; for a mesh see ``up_of_file``."""
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Place in the file of the origin of the subject: a mesh or molecule that is far away is brought near."""
    remarks: tuple[str, ...] = ()
    """Sentences about what was opened, for a person."""

"""How attraction grows with mass: the touching sphere and the best body side by side (Reinel, Figure 4)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ...core.estimate import Array
from .bound import Keep, largest_field


@dataclass(frozen=True, eq=False)
class Growth:
    """Fields for a gravitational constant of one."""

    mass: Array  # [kg], shape (n,)
    # sphere, best: [kg/m^2], shape (n,)
    sphere: Array
    best: Array


def growth(mass: ArrayLike, density: float, stand_off: float, keep: Keep = "plane") -> Growth:
    """Return the field of the sphere that touches the stand-off and of the best body, for each mass.

    Parameters
    ----------
    mass : array_like, shape (n,)
        [kg].
    density : float
        [kg/m^3].
    stand_off : float
        [m].
    keep : {"plane", "sphere"}
        Where material may be.

    Raises
    ------
    DataError
        As `largest_field`.
    """
    masses = np.atleast_1d(np.asarray(mass, dtype=float))
    bounds = [largest_field(float(m), density, stand_off, keep) for m in masses]
    return Growth(masses, np.array([b.sphere for b in bounds]), np.array([b.field for b in bounds]))

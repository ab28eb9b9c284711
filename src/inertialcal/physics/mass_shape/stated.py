"""Whether a stated attraction can be at all: no body of a mass attracts more than the bound."""

from __future__ import annotations

import math
from dataclasses import dataclass

from scipy import optimize

from ...core.errors import DataError
from ..attraction.bodies import positive
from .bound import Keep, largest_field

FACTORS = (-30.0, 30.0)  # logarithms of the masses that are looked at, over the one given


@dataclass(frozen=True)
class Checked:
    """A stated attraction beside the most that can be."""

    # stated, bound: [m/s^2]
    stated: float
    bound: float
    mass_needed: float  # least mass with the stated attraction [kg]

    @property
    def excess(self) -> float:
        """Stated over bound less one: above zero it cannot be."""
        return self.stated / self.bound - 1.0


def checked(
    stated: float, mass: float, density: float, stand_off: float, gravitational_constant: float, keep: Keep = "plane"
) -> Checked:
    """Return a stated attraction with the largest one of a mass.

    Parameters
    ----------
    stated : float
        Attraction [m/s^2].
    mass : float
        [kg].
    density : float
        [kg/m^3].
    stand_off : float
        From the point to the nearest material [m].
    gravitational_constant : float
        Of the document that states it [m^3/s^2/kg].
    keep : {"plane", "sphere"}
        Where material may be.

    Raises
    ------
    DataError
        As `largest_field`; if the stated attraction is not above zero, or absurd.
    """
    positive("stated attraction", stated)

    def over(log_factor: float) -> float:
        return (
            gravitational_constant * largest_field(mass * math.exp(log_factor), density, stand_off, keep).field - stated
        )

    bound = gravitational_constant * largest_field(mass, density, stand_off, keep).field
    if over(FACTORS[1]) < 0.0 or over(FACTORS[0]) > 0.0:
        raise DataError(
            f"stated attraction {stated:g} m/s^2 is {stated / bound:.3g} times the most that {mass:g} kg can do",
            why="no mass within 13 orders of magnitude attracts that strongly",
            do="It is in m/s^2; 1 ng, a billionth of gravity, is 9.81e-9 m/s^2.",
            code="absurd_attraction",
        )
    needed = mass * math.exp(float(optimize.brentq(over, *FACTORS, xtol=1e-12)))
    return Checked(stated, bound, needed)

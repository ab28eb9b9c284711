"""The most that a mass can attract: the body of all places that attract enough.

Each piece of material adds its own attraction, so that no body of a mass attracts more than the one that fills the
places of largest attraction along the axis, ``x / r^3 >= c``, up to that mass. Two rules about where material may be:

* ``plane``: behind a plane at the stand-off d, ``x >= d``. With ``u = (c d^2)^(1/3)``, between 0 and 1::

      V = 2 pi d^3 / 3 (0.4 u^-4.5 - 0.9 u^-2 + 0.5)        a = 2 pi G rho d (0.4 u^-1.5 + 0.6 u - 1)

* ``sphere``: farther than d from the point, ``r >= d``. With ``w = c d^2``::

      V = 2 pi d^3 / 3 (0.4 w^-1.5 + 0.6 w - 1)             a = pi G rho d (0.8 w^-0.5 + 0.2 w^2 - 1)

Both follow from integrals over slices, and over shells, of the body. With no stand-off the body attracts
``(27/25)^(1/3)`` times what a sphere touching the point does; behind a plane up to 1.35 times, near ``V = d^3``.

A stated attraction above the bound cannot be, whatever the shape: mass, density, distance or attraction is wrong.

Whether a stated attraction can be at all: no body of a mass attracts more than the bound.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

from scipy import optimize

from ...core.errors import DataError
from ..attraction.bodies import finite, positive

Keep = Literal["plane", "sphere"]
TOUCHING = (27.0 / 25.0) ** (1.0 / 3.0)
EXPONENTS = (-150.0, 0.0)  # of the parameter: from any volume to none
NOTHING = 1e-15  # of the radius, a stand-off that is none; of its cube, a volume that is a point
SERIES = 1e-4  # of one, from which the closed forms lose more than eight digits
_Form = tuple[Callable[[float], float], Callable[[float], float], float]
FACTORS = (-30.0, 30.0)  # logarithms of the masses that are looked at, over the one given


@dataclass(frozen=True)
class Bound:
    """The largest attraction of a mass."""

    field: float  # along the axis, for a gravitational constant of one [kg/m^2]
    reach: float  # distance of its farthest place on the axis [m]
    sphere: float  # field of the sphere of this mass that touches the stand-off [kg/m^2]


def largest_field(mass: float, density: float, stand_off: float, keep: Keep = "plane") -> Bound:
    """Return the largest field that a mass can have at a point.

    Parameters
    ----------
    mass : float
        [kg].
    density : float
        Of its material [kg/m^3].
    stand_off : float
        Between the point and the nearest material; zero: it may touch [m].
    keep : {"plane", "sphere"}
        Material lies behind a plane, or outside of a sphere about the point.

    Raises
    ------
    DataError
        If mass or density is not above zero, or the stand-off is below it.
    """
    positive("mass", mass)
    positive("density", density)
    finite("stand-off", stand_off)
    if not stand_off >= 0.0:
        raise DataError(f"stand-off {stand_off:g} m is below zero", code="no_stand_off")
    volume = mass / density
    radius = (3.0 * volume / (4.0 * math.pi)) ** (1.0 / 3.0)
    sphere = mass / (radius + stand_off) ** 2
    if stand_off <= NOTHING * radius:
        return Bound(TOUCHING * sphere, (15.0 * volume / (4.0 * math.pi)) ** (1.0 / 3.0), sphere)
    if volume <= NOTHING * stand_off**3:
        return Bound(mass / stand_off**2, stand_off, sphere)
    volume_of, field_of, power = _FORMS[keep]
    wanted = volume / (2.0 * math.pi * stand_off**3 / 3.0)
    log = optimize.brentq(lambda s: _log(volume_of(math.exp(s))) - math.log(wanted), *EXPONENTS, xtol=1e-15, rtol=1e-14)
    u = math.exp(log)
    return Bound(density * stand_off * field_of(u), stand_off * u**-power, sphere)


def _log(value: float) -> float:
    """Logarithm, with an end where the volume is none."""
    return math.log(value) if value > 0.0 else -1e9


def _plane_volume(u: float) -> float:
    """Over 2 pi d^3 / 3; near u = 1 the first term of its series."""
    e = 1.0 - u
    return 0.4 * u**-4.5 - 0.9 * u**-2 + 0.5 if e > SERIES else 2.25 * e**2 * (1.0 + 19.0 / 6.0 * e)


def _plane_field(u: float) -> float:
    """Over rho d."""
    e = 1.0 - u
    return 2.0 * math.pi * (0.4 * u**-1.5 + 0.6 * u - 1.0 if e > SERIES else 0.75 * e**2 * (1.0 + 7.0 / 6.0 * e))


def _sphere_volume(w: float) -> float:
    """Over 2 pi d^3 / 3."""
    e = 1.0 - w
    return 0.4 * w**-1.5 + 0.6 * w - 1.0 if e > SERIES else 0.75 * e**2 * (1.0 + 7.0 / 6.0 * e)


def _sphere_field(w: float) -> float:
    """Over rho d."""
    e = 1.0 - w
    return math.pi * (0.8 * w**-0.5 + 0.2 * w**2 - 1.0 if e > SERIES else 0.5 * e**2 * (1.0 + 0.5 * e))


_FORMS: dict[str, _Form] = {
    "plane": (_plane_volume, _plane_field, 1.5),
    "sphere": (_sphere_volume, _sphere_field, 0.5),
}


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

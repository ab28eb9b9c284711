"""A small source mass in orbit: what of a gradiometer's threshold it reaches, and from where.

A gradiometer of two accelerometers a baseline b apart that sees the gradient Gamma tells accelerations of
``Gamma b`` apart. A mass m gives the gradient ``2 G m / r^3`` along the line to it, and the attraction ``G m / r^2``.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from scipy import optimize

from ....core.errors import DataError, UsageError
from ....core.key import Key, told_for
from ....core.results import Row
from ....core.units import factor, parse_quantity, same_dimension
from .settings import Constants, positive

TEST = "mass_attraction"
EOTVOS = 1e-9  # [1/s^2]


@dataclass(frozen=True)
class Orbit:
    """What a mass does to a gradiometer.

    Parameters
    ----------
    mass : float
        [kg].
    radius : float
        Of its sphere [m].
    gradient : float
        Smallest that is seen [1/s^2].
    acceleration : float
        Smallest difference over the baseline [m/s^2].
    distance : float
        Of the centre of the mass, where it gives that gradient [m].
    attraction : float
        There [m/s^2].
    from_nearer : float
        From the nearer accelerometer to its centre, on the line through both, where their difference is the smallest
        that is seen: nearer than where the gradient is, as it falls off over the baseline [m].
    near : float
        Attraction with its surface at the stand-off [m/s^2].
    """

    mass: float
    radius: float
    gradient: float
    acceleration: float
    distance: float
    attraction: float
    from_nearer: float
    near: float


def orbit_of(
    mass: float, density: float, threshold: str, baseline: str, stand_off: float, constants: Constants
) -> Orbit:
    """Return what a sphere of a mass does to a gradiometer.

    Parameters
    ----------
    mass : float
        [kg].
    density : float
        [kg/m^3].
    threshold : str
        Of the gradiometer, as a gradient (``"0.5 Eotvos"``), or of its accelerometers (``"1e-10 g"``).
    baseline : str
        Between them.
    stand_off : float
        From an accelerometer to the nearest point of the mass [m].
    constants : Constants
        Gravitational constant, and what a g is.

    Raises
    ------
    UsageError
        If the threshold is neither, or not above zero.
    """
    length = positive(baseline, "m", "baseline", "2 m")
    gradient = _gradient(threshold, length, constants)
    G = constants.gravitational_constant
    distance = (2.0 * G * mass / gradient) ** (1.0 / 3.0)
    radius = (3.0 * mass / (4.0 * math.pi * density)) ** (1.0 / 3.0)
    near = G * mass / (radius + stand_off) ** 2
    return Orbit(
        mass,
        radius,
        gradient,
        gradient * length,
        distance,
        G * mass / distance**2,
        _from_nearer(G * mass, gradient, length),
        near,
    )


def _from_nearer(pull: float, gradient: float, length: float) -> float:
    """Distance d of the nearer accelerometer where ``G m (1 / d^2 - 1 / (d + b)^2)`` is the smallest difference [m]."""
    most = (2.0 * pull / gradient) ** (1.0 / 3.0)  # where the gradient itself would be: the difference is less

    def over(d: float) -> float:
        return pull * (2.0 * d + length) / (d * (d + length)) ** 2 - gradient

    least = min(most, math.sqrt(pull / (gradient * length))) * 0.1
    return float(optimize.brentq(over, least, most, rtol=1e-12))


def _gradient(threshold: str, length: float, constants: Constants) -> float:
    """Return the threshold as a gradient [1/s^2]."""
    try:
        unit = parse_quantity(threshold).unit
    except DataError:
        unit = ""
    if unit and same_dimension(unit, "Eotvos"):
        return positive(threshold, "1/s^2", "threshold", "0.5 Eotvos")
    if unit and same_dimension(unit, "m/s^2"):
        return positive(threshold, "m/s^2", "threshold", "1e-10 g") * constants.scale(threshold) / length
    raise UsageError(
        f"threshold: {threshold!r}", do='Write a gradient, "0.5 Eotvos", or an acceleration, "1e-10 g"', code="no_unit"
    )


def orbit_rows(found: Orbit, stand_off: float, constants: Constants) -> list[Row]:
    """Return its figures; accelerations in the ng of the constants."""
    ng, u_relative = constants.ng, constants.u_gravitational_constant
    cm = factor("m", "cm")
    told = [
        ("mass", found.mass, "kg", "", 0.0),
        ("radius", cm * found.radius, "cm", "sphere", 0.0),
        ("smallest_gradient", found.gradient / EOTVOS, "Eotvos", "", 0.0),
        ("smallest_acceleration", found.acceleration / ng, "ng", "difference over the baseline", 0.0),
        ("distance", cm * found.distance, "cm", "of its centre, at that gradient", u_relative / 3.0),
        ("attraction", found.attraction / ng, "ng", "at that distance", u_relative / 3.0),
        ("distance", cm * found.from_nearer, "cm", "from the nearer accelerometer", 0.0),
        ("attraction", found.near / ng, "ng", f"surface at {cm * stand_off:g} cm", u_relative),
    ]
    return [
        Row(Key(name), value, value * u or None, unit, test=TEST, member=told_for(at))
        for name, value, unit, at, u in told
    ]

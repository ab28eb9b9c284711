"""Small source mass in orbit: from what distance a gradiometer sees it.

A gradiometer of two accelerometers a baseline b apart that resolves the gradient Gamma resolves a difference of
``Gamma b``. A mass m gives the gradient ``2 G m / r^3`` along the line to it, and the attraction ``G m / r^2``.
"""

from __future__ import annotations

import math

from scipy import optimize

from ....core.key import Key, told_for
from ....core.results import Row
from ....core.units import factor
from .settings import Constants, Orbit

TEST = "mass_attraction"
EOTVOS = 1e-9  # [1/s^2]


def orbit_rows(said: Orbit, constants: Constants) -> list[Row]:
    """Return its figures; accelerations in the ng of the constants."""
    pull, b = constants.gravitational_constant * said.mass, said.baseline
    gradient = said.gradient or 0.5 * EOTVOS
    if said.acceleration is not None:
        gradient = said.acceleration / b
    radius = (3.0 * said.mass / (4.0 * math.pi * said.density)) ** (1.0 / 3.0)
    distance = (2.0 * pull / gradient) ** (1.0 / 3.0)

    def over(d: float) -> float:  # G m (1 / d^2 - 1 / (d + b)^2) above the smallest difference, over b
        return pull * (2.0 * d + b) / (d * (d + b)) ** 2 - gradient

    least = min(distance, math.sqrt(pull / (gradient * b))) * 0.1
    from_nearer = float(optimize.brentq(over, least, distance, rtol=1e-12))  # nearer: the gradient falls off over b
    ng, u_relative, cm = constants.ng, constants.u_gravitational_constant, factor("m", "cm")
    figures = [
        ("mass", said.mass, "kg", "", 0.0),
        ("radius", cm * radius, "cm", "sphere", 0.0),
        ("smallest_gradient", gradient / EOTVOS, "Eotvos", "", 0.0),
        ("smallest_acceleration", gradient * b / ng, "ng", "difference over the baseline", 0.0),
        ("distance", cm * distance, "cm", "of its centre, at that gradient", u_relative / 3.0),
        ("attraction", pull / distance**2 / ng, "ng", "at that distance", u_relative / 3.0),
        ("distance", cm * from_nearer, "cm", "from the nearer accelerometer", 0.0),
        ("attraction", pull / (radius + said.stand_off) ** 2 / ng, "ng",
         f"surface at {cm * said.stand_off:g} cm", u_relative),
    ]  # fmt: skip
    return [
        Row(Key(name), value, value * u or None, unit, test=TEST, member=told_for(at))
        for name, value, unit, at, u in figures
    ]

"""Constants of nature and of the documents, each with its source.

Values of the three documents keep the document's own units and digits, so that a published figure can be
repeated as it was computed; they are no substitute for the modern value beside them.

References
----------
.. [1] 3rd CGPM (1901), declaration on the unit of mass and the definition of weight.
.. [2] NIMA TR8350.2, World Geodetic System 1984, 3rd edition (2000), Tables 3.1 and 3.4.
.. [3] CODATA recommended values of the fundamental physical constants: 2022.
.. [4] IEEE Std 952-1997, Annex C (bias instability).
.. [5] Reinel, NASA TM X-53857, 1969.
"""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class Constant:
    """One constant."""

    name: str  # What it is, in words
    value: float  # In ``unit``
    unit: str  # As ``core.units`` prints it
    source: str  # Citation
    # Standard uncertainty in ``unit``; 0 where the value is exact, defined, or a printed figure that is to be
    # repeated as it stands
    u: float = 0.0


_WGS84 = "NIMA TR8350.2, 3rd ed. (2000)"

STANDARD_GRAVITY = Constant("standard gravity", 9.80665, "m/s^2", "3rd CGPM, 1901 (exact)")

EARTH_ROTATION_RATE = Constant("rotation rate of the earth", 7.292115e-5, "rad/s", f"{_WGS84}, Table 3.1 (defining)")
WGS84_SEMI_MAJOR_AXIS = Constant(
    "semi-major axis of the WGS 84 ellipsoid", 6378137.0, "m", f"{_WGS84}, Table 3.1 (defining)"
)
WGS84_FLATTENING = Constant(
    "flattening of the WGS 84 ellipsoid", 1.0 / 298.257223563, "1", f"{_WGS84}, Table 3.1 (defining, as 1/f)"
)
WGS84_GM = Constant(
    "gravitational constant times the mass of the earth with its atmosphere",
    3.986004418e14,
    "m^3/s^2",
    f"{_WGS84}, Table 3.1 (defining)",
    u=8e5,
)
NORMAL_GRAVITY_EQUATOR = Constant(
    "normal gravity at the equator on the ellipsoid", 9.7803253359, "m/s^2", f"{_WGS84}, Table 3.4"
)
NORMAL_GRAVITY_POLE = Constant(
    "normal gravity at the pole on the ellipsoid", 9.8321849378, "m/s^2", f"{_WGS84}, Table 3.4"
)
SOMIGLIANA_CONSTANT = Constant(
    "k of Somigliana's formula for normal gravity", 0.00193185265241, "1", f"{_WGS84}, Table 3.4"
)

GRAVITATIONAL_CONSTANT = Constant(
    "Newtonian constant of gravitation", 6.67430e-11, "m^3/s^2/kg", "CODATA 2022: 6.674 30(15)e-11", u=1.5e-15
)

BIAS_INSTABILITY_FACTOR = Constant(
    "flat part of the Allan deviation of flicker noise over its coefficient, sqrt(2 ln 2 / pi)",
    math.sqrt(2.0 * math.log(2.0) / math.pi),
    "1",
    "IEEE Std 952-1997, Annex C; Badescu, NPS thesis, 2011, eq. (22) prints 0.664",
)

REINEL_GRAVITATIONAL_CONSTANT = Constant(
    "gamma of Reinel's mass-attraction formulas",
    6.67e-8,
    "cm^3/s^2/gram",
    "Reinel, NASA TM X-53857, 1969 (as printed)",
)
REINEL_GRAVITY = Constant(
    "g of Reinel's mass-attraction formulas", 981.0, "cm/s^2", "Reinel, NASA TM X-53857, 1969 (as printed)"
)

CONSTANTS = (
    STANDARD_GRAVITY,
    EARTH_ROTATION_RATE,
    WGS84_SEMI_MAJOR_AXIS,
    WGS84_FLATTENING,
    WGS84_GM,
    NORMAL_GRAVITY_EQUATOR,
    NORMAL_GRAVITY_POLE,
    SOMIGLIANA_CONSTANT,
    GRAVITATIONAL_CONSTANT,
    BIAS_INSTABILITY_FACTOR,
    REINEL_GRAVITATIONAL_CONSTANT,
    REINEL_GRAVITY,
)

"""Units of a level: spectral density of acceleration as people write it.

``g2/Hz``, ``G^2/Hz``, ``(m/s2)2/Hz``, ``grms²/Hz``: in a profile G is standard gravity, not gauss. A level in
``g/sqrt(Hz)`` is the root of a density, and is squared; its slope in decibels is the same.
"""

from __future__ import annotations

import re
from typing import NamedTuple

from ...core.errors import DataError
from ...core.units import Quantity, normalise, parse_quantity, same_dimension

DENSITY, ROOT = "(m/s^2)^2/Hz", "m/s^2/sqrt(Hz)"
GRAVITY = re.compile(r"(?<![A-Za-z])[gG](?:_?rms)?(?![A-Za-z_])", re.IGNORECASE)
GLUED = {"g2hz": "g^2/Hz", "g2_hz": "g^2/Hz", "m2_s4_hz": DENSITY, "m2_s3": DENSITY}  # ends of a column's name
EXPECTED = "g^2/Hz, (m/s^2)^2/Hz, or g/sqrt(Hz), which is squared"


class DensityUnit(NamedTuple):
    """Unit of a level; its square is a density where ``root``."""

    unit: str  # Of the density
    scale: float  # (m/s^2)^2/Hz a unit of it
    root: bool

    def density(self, level: float) -> float:
        """Return a level in SI."""
        return self.scale * (level**2 if self.root and level > 0.0 else level)


def plain(text: str) -> str:
    """Return a text with ``G``, ``grms`` and ``Grms`` written as g."""
    return GRAVITY.sub("g", text)


def density_unit(text: str) -> DensityUnit:
    """Return the unit that a text means.

    Raises
    ------
    DataError
        ``wrong_unit`` where it is no density of acceleration, nor its root.
    """
    try:
        unit = normalise(plain(GLUED.get(text.lower().replace("_per_", "_"), text)))
    except DataError:
        unit = ""
    if unit and same_dimension(unit, DENSITY):
        return DensityUnit(unit, Quantity(1.0, unit).to(DENSITY), root=False)
    if unit and same_dimension(unit, ROOT):
        squared = normalise(f"({unit})^2")
        return DensityUnit(squared, Quantity(1.0, squared).to(DENSITY), root=True)
    raise DataError(
        f"unit {text!r} is not a spectral density of acceleration", do=f"Write {EXPECTED}", code="wrong_unit"
    )


def level_of(text: str) -> tuple[float, DensityUnit]:
    """Return a level in SI, and its unit.

    Raises
    ------
    DataError
        ``wrong_unit``; as a quantity.
    """
    found = parse_quantity(plain(text))
    unit = density_unit(found.unit)
    return unit.density(found.value), unit


__all__ = ["DENSITY", "DensityUnit", "density_unit", "level_of", "plain"]

"""[standards] of campaign.toml: influences that may be stated, and how their uncertainty is said."""

from __future__ import annotations

import math
from typing import Literal

from pydantic import Field, model_validator

from ..influence import Influence, Redrawn
from ..units import parse_quantity
from .quantities import Strict, Text

LARGEST = 1e9  # uncertainty of a standard, SI: beyond it a digit or a unit is wrong
# Influences that may stand under [standards.NAME], with the unit that they are read into.
STANDARDS: dict[str, dict[str, str]] = {
    "rate_table": {"rate": "1", "mounting": "rad"},
    "turn": {"angle": "rad", "axis": "rad"},
    "converter": {"reference": "1", "zero": "m/s^2"},
    "sensor": {"scale_factor": "1", "misalignment": "rad", "hysteresis": "rad/s"},
    "thermometer": {"temperature": "degC"},
    "supply_meter": {"voltage": "1", "resolution": "V"},
    "pressure_gauge": {"pressure": "1"},
    "site": {"latitude": "rad"},
    "source_mass": {"density": "1", "placing": "1", "gravitational_constant": "1"},
    "turned_mass": {"mass": "kg", "radius": "m", "height": "m"},
    "satellite": {"mass": "kg"},
    "orbit": {"rate": "1"},
    "tilt_meter": {"mercury": "rad"},
    "pad": {"tilt": "rad"},
    "gravity": {"value": "m/s^2"},
    "fixture": {"orientation": "rad", "repeatability": "rad", "mounting": "rad"},
    "clock": {"rate": "1"},
    "control_accelerometer": {"scale_factor": "1"},
    "magnetometer": {"mounting": "rad"},
    "earth_field": {"uniform": "T"},
}
# An uncertainty in each of these units, as it may be written.
WRITTEN = {"1": "0.1 %", "rad": "0.01 deg", "m/s^2": "10 ug", "rad/s": "0.01 deg/s", "degC": "0.1 K", "V": "1 mV",
           "kg": "1 gram", "m": "0.1 mm", "T": "30 nT"}  # fmt: skip

# What draws the error of an influence anew; where nothing is said here it is a certificate.
REDRAWN: dict[str, Redrawn] = {
    "rate_table.mounting": "mounting", "turn.axis": "mounting", "fixture.mounting": "mounting",
    "source_mass.placing": "mounting", "source_mass.gravitational_constant": "never", "site.latitude": "never",
    "gravity.value": "never", "fixture.repeatability": "dwell", "sensor.hysteresis": "power_up", "pad.tilt": "day",
    "magnetometer.mounting": "never", "earth_field.uniform": "day",
}  # fmt: skip


class StandardEntry(Strict):
    """Uncertainty of a standard: one of ``u``, ``expanded`` with ``k``, ``half_width``; ``reason`` where it is zero."""

    u: str | None = None
    expanded: str | None = None
    k: float | None = Field(default=None, gt=0)
    half_width: str | None = None
    dof: float | None = Field(default=None, gt=0)
    certificate: Text = ""
    valid: Text = ""
    reason: Text = ""
    redrawn_by: Literal["never", "certificate", "day", "mounting", "power_up", "dwell"] | None = None

    @model_validator(mode="after")
    def _one_form(self) -> StandardEntry:
        given = [name for name in ("u", "expanded", "half_width") if getattr(self, name) is not None]
        if len(given) != 1:
            raise ValueError(f"needs one of u, expanded (with k) or half_width; given: {', '.join(given) or 'none'}")
        if (self.expanded is None) != (self.k is None):
            raise ValueError("expanded and k go together: U = k u")
        return self

    def influence(self, unit: str, standard: str = "", name: str = "") -> Influence:
        """Return the standard uncertainty in ``unit``, of a quantity of that name of a standard.

        Raises
        ------
        DataError
            If the text is no quantity of that kind, or not positive.
        """
        text, divisor = (self.u, 1.0) if self.u is not None else (self.expanded, self.k or 1.0)
        if self.half_width is not None:
            text, divisor = self.half_width, math.sqrt(3.0)
        quantity = parse_quantity(text or "")
        u = quantity.to(unit, difference=True) / divisor
        if not 0.0 <= u <= LARGEST:
            raise ValueError(f"{text!r}: an uncertainty is positive and finite, and no larger than {LARGEST:g} {unit}")
        shape = "rectangular" if self.half_width is not None else "normal"
        dof = math.inf if self.dof is None else self.dof
        stated = (quantity.value / divisor, quantity.unit)
        redrawn = self.redrawn_by or REDRAWN.get(f"{standard}.{name}", "certificate")
        return Influence(
            u, unit, dof, shape, self.certificate, stated, standard, name, redrawn, self.valid, self.reason
        )

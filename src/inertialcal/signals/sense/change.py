"""One change of what a record holds, and the factors by which a change of unit multiplies it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from ...core.remarks import Remark

DEG = 180.0 / np.pi
Factors = Mapping[float, tuple[str, str]]
FACTORS: Mapping[str, Factors] = {  # what a change of unit multiplies by: (before, after)
    "angular_rate": {
        DEG: ("rad/s", "deg/s"), 3600.0: ("deg/s", "deg/h"), DEG * 3600.0: ("rad/s", "deg/h"),
        1e3: ("a unit", "its thousandth"), DEG * 1e3: ("rad/s", "mdeg/s"), 1e6: ("a unit", "its millionth"),
    },
    "acceleration": {
        9.80665: ("g", "m/s^2"), 1e3: ("a unit", "its thousandth"), 1e6: ("a unit", "its millionth"),
        1e3 / 9.80665: ("m/s^2", "mg"), 1e6 / 9.80665: ("m/s^2", "ug"),
    },
}  # fmt: skip
ANY: Factors = {
    DEG: ("rad", "deg"), 9.80665: ("g", "m/s^2"), 1e3: ("a unit", "its thousandth"), 1e6: ("a unit", "its millionth"),
}  # fmt: skip


@dataclass(frozen=True)
class Change:
    """One change of what is recorded."""

    code: str  # unit_changed, sign_changed, scale_changed, axes_changed
    index: int  # first sample after it
    channels: tuple[str, ...]  # that change
    factor: float = 1.0  # after over before; of a sign or scale
    units: tuple[str, str] | None = None  # before and after
    sources: tuple[str, ...] = ()  # channels whose readings these channels show after an exchange

    def remark(self, place: Callable[[int], str]) -> Remark:
        """Return what to say of it."""
        names = ", ".join(self.channels)
        if self.code == "unit_changed" and self.units is not None:
            what = f"{names}: the unit changes from {self.units[0]} to {self.units[1]} (factor {self.factor:.4g})"
        elif self.code == "sign_changed":
            what = f"{names}: the sign of the readings turns"
        elif self.code == "axes_changed":
            pairs = ", ".join(f"{a} goes on as {b}" for a, b in zip(self.channels, self.sources, strict=True) if a != b)
            what = f"the axes change places: {pairs}; likely another sensor, or columns in another order"
        else:
            what = f"{names}: the scale changes by the factor {self.factor:.4g}"
        do = "Split the recording here, and state the two parts as they are"
        return Remark(self.code, "error", what, place(self.index), do=do, subject=names, index=self.index)


def unit_of(factor: float, factors: Factors, tolerance: float) -> tuple[float, tuple[str, str]] | None:
    """Return the factor of two units that is meant, with the units before and after."""
    if not factor > 0.0:
        return None
    known = list(factors.items()) + [(1.0 / one, pair[::-1]) for one, pair in factors.items()]
    best, units = min(known, key=lambda one: abs(np.log(factor / one[0])))
    return (best, (units[0], units[1])) if abs(np.log(factor / best)) <= tolerance else None

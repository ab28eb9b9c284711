"""Units of noise parameters: SI inside, those of data sheets at the edge, by unit algebra.

The unit of a coefficient follows from that of the samples: quantisation unit s, white noise unit sqrt(s), random walk
of the rate unit/sqrt(s), ramp unit/s. Of an unknown unit ("file unit") the same algebra holds, and nothing converts.
"""

from __future__ import annotations

from fractions import Fraction
from functools import lru_cache

from ...core.axes import Kind
from ...core.errors import DataError
from ...core.units import factor, kind, multiply, power

HALF = Fraction(1, 2)
POWERS_OF_TIME: dict[str, Fraction] = {
    "quantization": Fraction(1),
    "random_walk": HALF,
    "bias_instability": Fraction(0),
    "rate_random_walk": -HALF,
    "rate_ramp": Fraction(-1),
}
SHOWN: dict[str, dict[str, tuple[str, ...]]] = {
    "gyro": {
        "quantization": ("arcsec",),
        "random_walk": ("deg/sqrt(h)", "deg/s/sqrt(Hz)"),
        "bias_instability": ("deg/h",),
        "rate_random_walk": ("deg/h/sqrt(h)",),
        "rate_ramp": ("(deg/h)/h",),
        "sigma": ("deg/h",),
        "amplitude": ("deg/h",),
    },
    "accelerometer": {
        "quantization": ("m/s",),
        "random_walk": ("ug/sqrt(Hz)", "m/s/sqrt(h)"),
        "bias_instability": ("ug",),
        "rate_random_walk": ("ug/sqrt(s)",),
        "rate_ramp": ("ug/h",),
        "sigma": ("ug",),
        "amplitude": ("ug",),
    },
}
KINDS = {"angular_rate": "gyro", "acceleration": "accelerometer"}


def kind_of_unit(unit: str) -> Kind | None:
    """Return the kind of sensor whose samples have that unit; None where it is neither."""
    found = KINDS.get(kind(unit)) if unit else None
    return found if found is None else ("gyro" if found == "gyro" else "accelerometer")


def sample_unit(kind: Kind | None, file_unit: str = "") -> str:
    """Return the unit of samples inside: SI of the kind, else that of the file."""
    if kind is None:
        return file_unit
    return {"gyro": "rad/s", "accelerometer": "m/s^2"}[kind]


@lru_cache(256)
def parameter_unit(term: str, parameter: str, unit: str) -> str:
    """Return the unit of a parameter of noise whose samples have that unit."""
    if parameter in {"sigma", "amplitude"}:
        return unit
    if parameter == "correlation_time":
        return "s"
    if parameter == "frequency":
        return "Hz"
    exponent = POWERS_OF_TIME[term]
    return unit if exponent == 0 else multiply(unit, power("s", exponent))


def shown_units(term: str, parameter: str, kind: Kind | None) -> tuple[str, ...]:
    """Return the units of data sheets for a parameter, the usual one first; none where the kind is not known."""
    if kind is None:
        return ()
    return SHOWN[kind].get(term if parameter == "coefficient" else parameter, ())


def converted(value: float, unit: str, wanted: str) -> float:
    """Return a parameter in another unit: N of 1 deg/s/sqrt(Hz) is 60 deg/sqrt(h).

    Raises
    ------
    DataError
        With code ``unit_mismatch``, if the units measure different things.
    """
    if unit in {"", "-"}:
        raise DataError("the samples have no unit", do="Say which: --unit gyro=deg/s", code="unit_mismatch")
    return value * factor(unit, wanted)

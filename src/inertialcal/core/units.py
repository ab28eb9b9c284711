"""Units: what people write, one spelling that is printed, factors between them.

The only place with factors; its parts are ``unit.atoms`` (the list of units), ``unit.parse`` and ``unit.spelling``.
In this field ``g``, ``mg``, ``ug`` and ``ng`` are accelerations.

Angles and counts have dimensions of their own, so that ``deg/s`` is no frequency. A temperature alone is a
point on its scale (degC, degF and K differ by an offset); inside a product, as in ``V/degC``, it is a
difference.

>>> normalise("µg/√Hz"), normalise("m s-2"), normalise("mdps/LSB")
('ug/sqrt(Hz)', 'm/s^2', 'mdeg/s/count')
>>> factor("deg/s/sqrt(Hz)", "deg/sqrt(h)")
60.0
>>> parse_quantity("10 V / 2^16").to("uV")
152.587890625
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from typing import TYPE_CHECKING, Any

from .errors import DataError
from .key import Kind
from .unit.atoms import NONE, PREFIXES, Factor, Powers, by_symbol, kind_of, merged, product, quotient, raised
from .unit.magnitudes import CODE, LARGEST, SMALLEST, is_possible
from .unit.parse import can_read_unit, read_quantity, read_unit
from .unit.spelling import spell

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import ArrayLike, NDArray

    from .estimate import Array

FILE_UNIT = "file unit"  # of samples whose unit nobody stated
_REMEMBERED = 4096  # texts

_KINDS = {
    "dimensionless": "1",
    "angular_rate": "rad/s",
    "acceleration": "m/s^2",
    "angle": "rad",
    "velocity": "m/s",
    "voltage": "V",
    "temperature": "K",
    "time": "s",
    "frequency": "1/s",
    "count": "count",
    "pressure": "Pa",
    "length": "m",
    "mass": "kg",
}


@dataclass(frozen=True)
class Quantity:
    """A number with its unit."""

    value: float  # In ``unit``
    unit: str  # As ``normalise`` prints it

    def to(self, unit: str, difference: bool = False) -> float:
        """Return the number in another unit of the same dimension.

        Parameters
        ----------
        unit : str
            Of the same dimension.
        difference : bool
            Whether a temperature is a difference (an uncertainty, a step), not a point on its scale:
            0.1 K is then 0.1 degC.

        Raises
        ------
        DataError
            If the dimensions differ.
        """
        if difference:
            return self.value * factor(self.unit, unit, difference=True)
        return float(convert(self.value, self.unit, unit))

    def __str__(self) -> str:
        """Return number and unit, as ``parse_quantity`` reads them."""
        number = repr(float(self.value)).removesuffix(".0")
        return number if self.unit == "1" else f"{number} {self.unit}"


@lru_cache(_REMEMBERED)
def normalise(text: str) -> str:
    """Return the spelling of a unit that is printed everywhere.

    Parameters
    ----------
    text : str
        As people write it: ``"m s-2"``, ``"°/s"``, ``"µg/√Hz"``, ``"LSB"``; nothing is dimensionless.

    Returns
    -------
    str
        Plain ASCII, unchanged by a second pass: ``"m/s^2"``, ``"deg/s"``, ``"ug/sqrt(Hz)"``, ``"count"``.

    Raises
    ------
    DataError
        With code ``unknown_unit``, if it is not known or has two readings; the message names the nearest
        known spellings, or the two readings.
    """
    return spell(read_unit(text))


def is_unit(text: str) -> bool:
    """Return whether `normalise` takes a text, without what it would advise."""
    return can_read_unit(text)


def known_units() -> tuple[str, ...]:
    """Return the printed symbol of every unit that others are made of, prefixed ones included."""
    return tuple(by_symbol())


@lru_cache(_REMEMBERED)
def parse_quantity(text: str) -> Quantity:
    """Return the quantity that a text gives, number first.

    Parameters
    ----------
    text : str
        ``"0.05 %"``, ``"-36.4 deg"``, ``"0.5 V/(deg/s)"``, ``"5 V / 4095"``; a bare number has unit 1.

    Raises
    ------
    DataError
        With code ``unknown_quantity``, if it cannot be read or is not finite; ``impossible_value``, if nothing that
        is measured is so large or so small.
    """
    value, unit = read_quantity(text)
    if not (is_possible(value) and is_possible(value * _in_base_units(unit)[0])):
        raise DataError(
            f"{text!r} is beyond any physical range",
            why=f"in SI, a quantity is 0 or from {SMALLEST:g} to {LARGEST:g}",
            do="Correct the exponent or the unit",
            code=CODE,
        )
    return Quantity(value, spell(unit))


@lru_cache(_REMEMBERED)
def factor(from_unit: str, to_unit: str, difference: bool = False) -> float:
    """Return the number that a value in one unit is multiplied by to be in another.

    Parameters
    ----------
    from_unit, to_unit : str
        Of one dimension.
    difference : bool
        Whether temperatures are differences (uncertainties, steps), not points on their scales.

    Raises
    ------
    DataError
        With code ``unit_mismatch``, if the dimensions differ, or if no number does it because the zero of
        the scales differs (degC and K); ``unknown_unit`` if one is not known.
    """
    source, target = read_unit(from_unit), read_unit(to_unit)
    if source == target:
        return 1.0
    if _in_base_units(source)[1] != _in_base_units(target)[1]:
        raise DataError(
            f"{from_unit!r} cannot be expressed in {to_unit!r}",
            why=f"one is {_in_words(from_unit)}, the other {_in_words(to_unit)}",
            do=f"Give a unit like {si_unit(to_unit)}",
            code="unit_mismatch",
        )
    if not difference and _zero_points_differ(source, target):
        raise DataError(
            f"no factor from {from_unit!r} to {to_unit!r}: the zero points differ",
            do="Use convert for temperatures, factor(..., difference=True) for differences of them",
            code="unit_mismatch",
        )
    number = _in_base_units(quotient(source, target))[0]
    if not (math.isfinite(number) and number > 0.0):
        raise DataError(
            f"the factor from {from_unit!r} to {to_unit!r} is too large or too small for a number",
            code="unit_mismatch",
        )
    return number


def convert(values: ArrayLike, from_unit: str, to_unit: str) -> Array:
    """Return values in another unit of the same dimension, temperatures with the offset of their scales.

    Parameters
    ----------
    values : array_like
        In ``from_unit``.
    from_unit, to_unit : str
        Of one dimension.

    Returns
    -------
    ndarray
        As float64, of the shape of ``values``; the same memory where nothing is to be done.

    Raises
    ------
    DataError
        With code ``unit_mismatch``, if the dimensions differ.
    """
    import numpy as np  # noqa: PLC0415 - help of a command reads units, and needs no arrays

    numbers: Array = np.asarray(values, dtype=np.float64)
    source, target = read_unit(from_unit), read_unit(to_unit)
    if source == target:
        return numbers
    if _zero_points_differ(source, target):
        zero, to_zero = (by_symbol()[unit[0][0]][0].offset for unit in (source, target))
        kelvins = numbers * _in_base_units(source)[0] + zero
        return np.asarray((kelvins - to_zero) / _in_base_units(target)[0], dtype=np.float64)
    return np.asarray(numbers * factor(from_unit, to_unit), dtype=np.float64)


def convert_as_wide(values: NDArray[Any], from_unit: str, to_unit: str) -> NDArray[Any]:
    """Return values in another unit, 32 bits wide where they were, so that a day of readings stays as large as it is.

    Raises
    ------
    DataError
        With code ``unit_mismatch``, if the dimensions differ.
    """
    import numpy as np  # noqa: PLC0415 - help of a command reads units, and needs no arrays

    if values.dtype != np.float32:
        return convert(values, from_unit, to_unit)
    scaled: NDArray[np.float32] = np.empty_like(values)
    with np.errstate(over="ignore"):  # beyond 32 bits it is no reading, and infinite
        np.multiply(values, factor(from_unit, to_unit), out=scaled, dtype=np.float64, casting="same_kind")
    return scaled


@lru_cache(_REMEMBERED)
def kind(unit: str) -> str:
    """Return what a unit measures: ``"angular_rate"``, ``"acceleration"``, ..., else ``"other"``."""
    return next((name for name, known in _KINDS.items() if same_dimension(unit, known)), "other")


@lru_cache(_REMEMBERED)
def same_dimension(a: str, b: str) -> bool:
    """Return whether values in one unit can be expressed in the other."""
    return _in_base_units(read_unit(a))[1] == _in_base_units(read_unit(b))[1]


@lru_cache(_REMEMBERED)
def si_unit(unit: str) -> str:
    """Return the unit of that dimension used inside the project: SI, radians, degC.

    Each factor is replaced by its own: ``"mV/(deg/s)"`` gives ``"V/(rad/s)"``, ``"ug/sqrt(Hz)"`` gives
    ``"m/s^2/sqrt(Hz)"``.

    Raises
    ------
    DataError
        With code ``unknown_unit``, if it is not known, or an exponent would be beyond ±12.
    """
    return _algebra(lambda: _inside(read_unit(unit)), f"the SI unit of {unit!r}")


def multiply(a: str, b: str) -> str:
    """Return the unit of a product of values in units ``a`` and ``b``."""
    return _algebra(lambda: product(read_unit(a), read_unit(b)), f"{a!r} times {b!r}")


def divide(a: str, b: str) -> str:
    """Return the unit of a quotient: ``divide("V", "deg/s")`` is ``"V/(deg/s)"``."""
    return _algebra(lambda: quotient(read_unit(a), read_unit(b)), f"{a!r} divided by {b!r}")


def power(unit: str, exponent: float | Fraction) -> str:
    """Return the unit of a power: ``power("h", -0.5)`` is ``"1/sqrt(h)"``.

    Raises
    ------
    DataError
        With code ``unknown_unit``, if an exponent of the result is no multiple of 1/4 within ±12.
    """
    return _algebra(lambda: raised(read_unit(unit), _simple(exponent)), f"{unit!r} to the power {exponent}")


def _simple(exponent: float | Fraction) -> Fraction:
    """Nearest simple fraction: 1/3 as a float is meant as 1/3."""
    if not math.isfinite(float(exponent)):
        raise ValueError("the exponent is not finite")
    simple = Fraction(exponent).limit_denominator(12)
    if abs(float(simple - Fraction(exponent))) > 1e-12:
        raise ValueError("the exponent is not a simple fraction")
    return simple


def _algebra(operation: Callable[[], Powers], what: str) -> str:
    try:
        return spell(operation())
    except ValueError as error:
        raise DataError(f"{what} is not a unit: {error}", code="unknown_unit") from None


def _inside(unit: Powers) -> Powers:
    result = NONE
    for symbol, exponent in unit:
        result = product(result, raised(read_unit(by_symbol()[symbol][0].si), exponent))
    return result


@lru_cache(_REMEMBERED)
def _in_base_units(unit: Powers) -> tuple[float, tuple[Factor, ...]]:
    """Return the value of a unit in base units, and these; equal numbers above and below cancel exactly."""
    numbers: dict[float, Fraction] = {}
    base: list[Factor] = []
    left = [*reversed(unit)]
    while left:
        symbol, exponent = left.pop()
        atom, prefix = by_symbol()[symbol]
        value = PREFIXES[prefix][1] if prefix else atom.value
        numbers[value] = numbers.get(value, Fraction(0)) + exponent
        if prefix:
            left.append((atom.symbol, exponent))
        elif atom.of == symbol:
            base.append((symbol, exponent))
        else:
            left += [(one, exponent * own) for one, own in reversed(read_unit(atom.of))]
    number = 1.0
    for value, exponent in sorted(numbers.items(), key=lambda one: one[1] < 0):  # divisors last
        number *= value ** float(exponent)
    return number, tuple(sorted(merged(base).items()))


def _zero_points_differ(source: Powers, target: Powers) -> bool:
    if not (_is_temperature(source) and _is_temperature(target)):
        return False
    return any(by_symbol()[unit[0][0]][0].offset for unit in (source, target))


def _is_temperature(unit: Powers) -> bool:
    return len(unit) == 1 and unit[0][1] == 1 and kind_of(unit[0][0]) == "temperature"


def _in_words(unit: str) -> str:
    known = kind(unit)
    return f"measured in {si_unit(unit)}" if known == "other" else f"of kind {known}"


def kind_of_unit(unit: str) -> Kind | None:
    """Return the kind of sensor that reads in a unit; None where it is neither gyro nor accelerometer."""
    sensors: dict[str, Kind] = {"angular_rate": "gyro", "acceleration": "accelerometer"}
    return sensors.get(kind(unit)) if unit else None

"""Error of a single sensor without temperature, code by code.

With one code there is one rounding of each product and one of the sum after it, and they are not free of each other:
bounds that let each have its worst are up to twice too large. So every code is tried. Where the sensor is linear this
is done in whole numbers of 64 bits that wrap: they hold x, C and W d modulo 2^64 units, and so does the difference,
which is known to be smaller than 2^63 of them.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from .codes import Codes, with_differences
from .design import Arithmetic, Constants, Values
from .exact import Ideal
from .truth import SCALE, errors
from .twin import run

MOST_STRAIGHT = 2**26  # codes above the reference that are tried
MOST_BENT = 2**18  # the same where each has the true inverse of a curve
CHUNK = 2**18
WORD = 64


@dataclass(frozen=True, eq=False)
class Worst:
    """Bound on the error over all codes [output unit], and the codes where it is met, shape (1, 1)."""

    bound: Fraction
    codes: Codes


def can_enumerate(ideal: Ideal) -> bool:
    """Whether every code can be tried."""
    if len(ideal.axes) > 1 or ideal.temperatures is not None:
        return False
    lowest, highest = ideal.signals[0]
    return highest - lowest < (MOST_STRAIGHT if ideal.bends is None else MOST_BENT)


def worst_of_all(ideal: Ideal, how: Arithmetic, constants: Constants, bound: Fraction) -> Worst:
    """Return the worst error of all codes.

    Parameters
    ----------
    bound : Fraction
        On the error, however loose.
    """
    lowest, highest = ideal.signals[0]
    worst, at = Fraction(-1), lowest
    for start in range(lowest, highest + 1, CHUNK):
        away = np.arange(start, min(start + CHUNK, highest + 1))[:, np.newaxis]
        codes = with_differences(ideal, away, None)
        if ideal.bends is None:
            size, place = _straight(ideal, how, run(constants, how, codes)[0][:, 0], away[:, 0], bound)
        else:
            found, off = errors(ideal, how, constants, 0, codes)
            place = int(np.abs(found).argmax())
            size = (abs(int(found[place])) + off) / SCALE
        if size > worst:
            worst, at = size, start + place
    return Worst(worst, with_differences(ideal, np.array([[at]]), None))


def _straight(
    ideal: Ideal, how: Arithmetic, values: Values, away: NDArray[np.int64], bound: Fraction
) -> tuple[Fraction, int]:
    """Largest error of some codes, a little above, and where."""
    unit_bits = WORD - 3 - (bound.numerator.bit_length() - bound.denominator.bit_length())  # bound < 2^62 units
    weight, constant = (round(one * Fraction(2) ** unit_bits) for one in (ideal.weights[0][0], ideal.constant[0]))
    truth = _word(weight) * away.astype(np.uint64) + _word(constant)
    error = (_modulo(values, how, unit_bits) - truth).view(np.int64)
    size = np.abs(error)
    place = int(size.argmax())
    off = Fraction(int(np.max(np.abs(away))) + 3, 2)  # W d, C and x, each to the next unit
    return (int(size[place]) + off) / Fraction(2) ** unit_bits, place


def _word(value: int) -> np.uint64:
    return np.uint64(value % 2**WORD)


def _modulo(values: Values, how: Arithmetic, unit_bits: int) -> NDArray[np.uint64]:
    """Give outputs in units of 2^-unit_bits, cut to whole ones, modulo 2^64."""
    if how.fixed:
        digits, shift = values.astype(np.int64), np.full(values.shape, unit_bits - how.bits)
    else:
        mantissa, exponent = np.frexp(values.astype(float))
        digits, shift = np.ldexp(mantissa, 53).astype(np.int64), exponent.astype(np.int64) - 53 + unit_bits
    right = digits >> np.clip(-shift, 0, WORD - 1)
    left = digits.astype(np.uint64) << np.clip(shift, 0, WORD - 1).astype(np.uint64)
    left = np.where(shift >= WORD, np.uint64(0), left)
    return np.where(shift < 0, right.astype(np.uint64), left)

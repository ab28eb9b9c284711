"""Magnitudes that a quantity can have: beyond them a digit, a unit or the file is wrong.

The limits lie far outside anything that is measured, and far inside what float64 holds (2e-308 to 2e308):

- The largest number that a file holds for a reason is a counter of 64 bits, 2^63 = 9e18; the least quantity is a power
  density near 1e-23 (a quiet accelerometer in (m/s^2)^2/Hz) or a physical constant (1.4e-23 J/K).
- Fits take fourth powers (squares of second-order terms, products of variances), and sums over up to 1e9 samples.
  Between 1e-30 and 1e30 the eighth power times 1e9 is 1e249 and the inverse of the eighth power 1e240: all of it is
  finite, and nothing falls to zero.

Not a number, infinite and zero have no magnitude: whoever reads them says what they are.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from ..errors import DataError

if TYPE_CHECKING:
    from numpy.typing import NDArray

LARGEST = 1e30  # in the unit of the file, and in SI
SMALLEST = 1e-30  # not zero
MOST = 1_000_000_000  # that a whole number of a setting counts
DERIVED = 1e100  # of what was computed and is read back, like a covariance: its square is finite
SAMPLE_RATES = (1e-10, 1e9)  # [Hz]: one sample in 300 years, all that our time holds; one a nanosecond, its step
CODE = "impossible_value"
FEW = 1000  # readings that are looked at once more sooner than looked up


def is_possible(number: float) -> bool:
    """Return whether a number is finite and zero, or of a size that a quantity can have."""
    return math.isfinite(number) and (number == 0.0 or SMALLEST <= abs(number) <= LARGEST)


def are_possible(values: NDArray[Any]) -> bool:
    """Return whether `check_readings` refuses none of several channels, shape (k, n), all of finite readings."""
    import numpy as np  # noqa: PLC0415 - help of a command reads quantities, and needs no arrays

    if not values.size:
        return True
    size = np.abs(values).max(axis=1)
    return bool(((size == 0.0) | ((size >= SMALLEST) & (size <= LARGEST))).all())


def check_readings(name: str, values: NDArray[Any], unit: str | None, place: Callable[[int], str]) -> None:
    """Refuse a channel with a reading that no sensor gives, or whose readings are all too small for one.

    Parameters
    ----------
    name : str
        Of the channel, for the message.
    values : ndarray, shape (n,)
        Readings; whole numbers and what is not finite always pass.
    unit : str or None
        Of them.
    place : callable
        Index of a reading -> ``"file:row"``.

    Raises
    ------
    DataError
        ``impossible_value``, with the first place.
    """
    import numpy as np  # noqa: PLC0415 - help of a command reads quantities, and needs no arrays

    from ..batches import extremes  # noqa: PLC0415 - the same

    if values.dtype.kind != "f" or not len(values):
        return
    if len(values) <= FEW and is_possible(float(np.abs(values).max())):
        return
    low, high = extremes(values)
    if not (math.isfinite(low) and math.isfinite(high)):
        values = np.where(np.isfinite(values), values, 0.0)
        low, high = float(values.min()), float(values.max())
    size = max(-low, high)
    if is_possible(size):
        return
    large = size > LARGEST
    index = int(np.argmax(np.abs(values) > LARGEST if large else values != 0.0))
    value = f"{float(values[index]):.3g}{f' {unit}' if unit else ''}"
    limit = f"larger than {LARGEST:g}" if large else f"no reading larger than {SMALLEST:g}"
    raise DataError(
        f"column {name!r}: {value}, {limit}" if large else f"column {name!r}: {limit}, like {value}",
        where=place(index),
        why="no sensor gives that: a unit, an exponent or the file is wrong",
        do="Correct the value or leave the cell empty" if large else "Check the column and its unit",
        code=CODE,
    )


def check_sample_rate(sample_rate: float) -> str:
    """Return what is wrong with a sample rate [Hz]; empty where nothing is."""
    low, high = SAMPLE_RATES
    if low <= sample_rate <= high:
        return ""
    return f"a sample rate of {sample_rate:g} Hz: need {low:g} to {high:g} Hz"

"""Printed figures with the rounding of their last digit, and what follows from them with the rounding carried on.

A printed figure stands for every number that rounds to it: half a unit of its last digit on either side. Zeros at the
end of an integer do not count as digits (4700 is 47 hundred), unless the figure is a count; a power of ten with one
digit reaches down to half a unit of the digit below (0.95e-3 is printed 1e-3, 0.6e-3 is not).
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

_NUMBER = re.compile(r"([+-]?)(\d*)\.?(\d*)(?:[eE]([+-]?\d+))?")
EXACT = 1e-9
MANY = 3.0  # standard deviations of the sum of many roundings


@dataclass(frozen=True)
class Printed:
    """A figure as it is printed: its text, its number, the unit of its last digit, and the rounding on either side."""

    text: str
    value: float
    step: float
    below: float
    above: float
    digits: int

    @property
    def half(self) -> float:
        """Largest rounding."""
        return self.above


@dataclass(frozen=True)
class Recomputed:
    """What follows from other printed figures, and how far their rounding can move it."""

    value: float
    tolerance: float = 0.0


Input = Printed | Recomputed | float


def printed(text: str, count: bool = False) -> Printed:
    """Return the figure that a text prints.

    Parameters
    ----------
    text : str
        As printed: ``"-0.0545"``, ``"1.4e24"``, ``"4700"``.
    count : bool
        A number of things: every digit counts.
    """
    found = _NUMBER.fullmatch(text)
    if not found or not (found[2] or found[3]):
        raise ValueError(f"no printed figure: {text!r}")
    digits, exponent = found[2] + found[3], int(found[4] or 0) - len(found[3])
    if not count and not found[3]:
        bare = digits.rstrip("0") or "0"
        digits, exponent = bare, exponent + (len(digits) - len(bare) if bare != "0" else 0)
    significant = digits.lstrip("0")
    step = 10.0**exponent
    power_of_ten = significant == "1" and not found[3] and exponent != 0
    below = 0.05 * step if power_of_ten else 0.5 * step
    return Printed(text, float(text), step, below, 0.5 * step, len(significant))


def exactly(value: int) -> Printed:
    """Return a number that is no rounded result: it must come out as it is."""
    return Printed(str(value), float(value), EXACT, 0.0, 0.0, len(str(value)))


def recompute(function: Callable[..., float], *inputs: Input) -> Recomputed:
    """Return a function of printed figures, with what their rounding can do to it.

    The tolerance is the sum of the shifts that the half units of the inputs make, or, where there are many,
    three standard deviations of the sum of independent roundings, whichever is smaller.
    """
    values = [_value(one) for one in inputs]
    centre = float(function(*values))
    shifts = []
    for i, one in enumerate(inputs):
        half = _half(one)
        if half > 0.0:
            sides = [float(function(*values[:i], values[i] + d, *values[i + 1 :])) - centre for d in (half, -half)]
            shifts.append(max(abs(s) for s in sides))
    root = math.sqrt(float(np.sum(np.square(shifts))) / 3.0)
    return Recomputed(centre, min(float(np.sum(shifts)), MANY * root))


def _value(one: Input) -> float:
    return one.value if isinstance(one, Printed | Recomputed) else float(one)


def _half(one: Input) -> float:
    if isinstance(one, Printed):
        return one.half
    return one.tolerance if isinstance(one, Recomputed) else 0.0

"""Units as products of powers: ``deg/sqrt(h)`` is ``(("deg", 1), ("h", -1/2))``.

Exponents are exact. They stay within what a unit of this field can need, so that no text can ask for a
number that does not fit.
"""

from __future__ import annotations

from collections.abc import Iterable
from fractions import Fraction

Factor = tuple[str, Fraction]
Powers = tuple[Factor, ...]

LARGEST_EXPONENT = 12
DENOMINATORS = (1, 2, 4)  # whole powers and roots; also exact as floats
NONE: Powers = ()


def merged(factors: Iterable[tuple[str, Fraction | int]]) -> dict[str, Fraction]:
    """Return the exponent of each symbol in a product of factors, without those to the power 0."""
    total: dict[str, Fraction] = {}
    for symbol, exponent in factors:
        total[symbol] = total.get(symbol, Fraction(0)) + exponent
    return {symbol: exponent for symbol, exponent in total.items() if exponent}


def powers(factors: Iterable[tuple[str, Fraction | int]]) -> Powers:
    """Return the product of the factors: sorted by symbol, each symbol once, none to the power 0.

    Raises
    ------
    ValueError
        If an exponent is beyond ±12 or no multiple of 1/4.
    """
    total = merged(factors)
    for symbol, exponent in total.items():
        if abs(exponent) > LARGEST_EXPONENT or exponent.denominator not in DENOMINATORS:
            raise ValueError(f"{symbol} to the power {exponent}: need a multiple of 1/4 within ±{LARGEST_EXPONENT}")
    return tuple(sorted(total.items()))


def product(a: Powers, b: Powers) -> Powers:
    """Return a times b."""
    return powers((*a, *b))


def quotient(a: Powers, b: Powers) -> Powers:
    """Return a divided by b."""
    return powers((*a, *((symbol, -exponent) for symbol, exponent in b)))


def raised(a: Powers, exponent: Fraction) -> Powers:
    """Return a to a power."""
    return powers((symbol, own * exponent) for symbol, own in a)

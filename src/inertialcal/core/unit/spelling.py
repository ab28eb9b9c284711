"""How a unit is printed: one spelling for each unit, plain ASCII, that reads back as the same unit.

Divisors stand one after the other, as the field writes them: ``deg/h/sqrt(Hz)``. A count rate, an angular
rate or an acceleration that is divided by, or raised to a power, stays whole: ``V/(deg/s)``,
``count/s/(m/s^2)``, ``(m/s^2)^2/Hz``.
Times come first among the divisors: ``V/deg/s`` has two readings and is neither printed nor read.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from itertools import product

from .atoms import Factor, Powers, kind_of, merged

LONGEST = 80  # characters of a unit, read or printed
_REMEMBERED = 4096  # units

_NUMERATOR = (
    "count",
    "dimensionless",
    "mass",
    "voltage",
    "pressure",
    "other",
    "length",
    "acceleration",
    "angle",
    "temperature",
    "frequency",
    "time",
)
_DENOMINATOR = (
    "time",
    "count",
    "dimensionless",
    "mass",
    "voltage",
    "pressure",
    "other",
    "length",
    "acceleration",
    "angle",
    "temperature",
    "frequency",
)

# Kind of the numerator of a whole, and the power of time that it is divided by.
_KINDS_OF_WHOLES = (("count", 1), ("angle", 1), ("length", 2))


@dataclass(frozen=True)
class _Whole:
    """``(symbol/time^order)^exponent``, as ``(m/s^2)^-1``."""

    symbol: str
    time: str
    order: int
    exponent: Fraction

    @property
    def times(self) -> Fraction:
        """Exponent of the time that it takes."""
        return -self.order * self.exponent

    def written(self) -> list[str]:
        inner = "/".join([self.symbol, *_written(self.time, Fraction(self.order))])
        return _written(f"({inner})", abs(self.exponent))


@lru_cache(_REMEMBERED)
def spell(unit: Powers) -> str:
    """Return the spelling of a unit; ``"1"`` for the dimensionless one.

    Raises
    ------
    ValueError
        If the spelling is longer than 80 characters.
    """
    wholes = _wholes(unit)
    taken = [f for w in wholes for f in ((w.symbol, -w.exponent), (w.time, -w.times))]
    rest = merged((*unit, *taken)).items()
    above = [text for symbol, e in _sorted(rest, _NUMERATOR) if e > 0 for text in _written(symbol, e)]
    below = [text for symbol, e in _sorted(rest, _DENOMINATOR) if e < 0 for text in _written(symbol, -e)]
    above += [text for whole in wholes if whole.exponent > 0 for text in whole.written()]
    below += [text for whole in wholes if whole.exponent < 0 for text in whole.written()]
    text = "/".join(["*".join(above) or "1", *below])
    if len(text) > LONGEST:
        raise ValueError(f"it takes {len(text)} characters, more than {LONGEST}")
    return text


def _sorted(factors: Iterable[Factor], order: tuple[str, ...]) -> list[Factor]:
    """By kind, whole powers before roots, then by symbol."""
    return sorted(factors, key=lambda f: (order.index(kind_of(f[0])), f[1].denominator > 1, f))


def _written(base: str, exponent: Fraction) -> list[str]:
    """Factors that make a positive power: ``h^(3/2)`` is ``h`` and ``sqrt(h)``."""
    whole, part = divmod(exponent, 1)
    factors = [base if whole == 1 else f"{base}^{whole}"] if whole else []
    if part == Fraction(1, 2):
        factors.append(f"sqrt({base})")
    elif part:
        factors.append(f"{base}^({part})")
    return factors


def _wholes(unit: Powers) -> list[_Whole]:
    """Wholes to powers other than 1 that, with those to the power 1, use up the times that they take."""
    times = {symbol: exponent for symbol, exponent in unit if kind_of(symbol) == "time"}
    candidates: list[list[_Whole | None]] = []
    for kind, order in _KINDS_OF_WHOLES:  # a whole with each of the times, and none; none for two symbols of a kind
        found = [(symbol, exponent) for symbol, exponent in unit if kind_of(symbol) == kind]
        alone = found if len(found) == 1 and found[0][1].denominator == 1 else []
        candidates.append(
            [*(_Whole(symbol, time, order, exponent) for symbol, exponent in alone for time in times), None]
        )
    for choice in product(*candidates):
        chosen = [whole for whole in choice if whole is not None]
        spent = {time: sum(w.times for w in chosen if w.time == time) for time in (w.time for w in chosen)}
        if all(times[time] == exponent for time, exponent in spent.items()):
            break  # at the latest with nothing chosen
    return [whole for whole in chosen if whole.exponent != 1]

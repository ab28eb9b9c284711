r"""Units as the Digital System of Units writes them: ``deg/s`` is ``\degree\second\tothe{-1}``.

It holds the SI and what is used beside it. ``g`` (standard gravity), ``Torr`` and the like are not in it: who wants to
state such a figure converts it first. A count and an octave are numbers: ``\one``.

References
----------
.. [1] D. Hutzschenreuter et al., SmartCom Digital System of Units (D-SI), 2nd edition, 2020, tables 1 to 5.
.. [2] BIPM, The International System of Units, 9th edition, tables 4 and 8.
"""

from __future__ import annotations

from fractions import Fraction

from ..errors import DataError
from .atoms import PREFIXES, by_symbol
from .parse import read_unit

CODE = "not_in_d_si"
ONE = r"\one"
WORDS = {
    "%": "percent", "ppm": "ppm", "kg": "kilogram", "gram": "gram", "m": "metre", "s": "second", "min": "minute",
    "h": "hour", "day": "day", "rad": "radian", "deg": "degree", "arcmin": "arcminute", "arcsec": "arcsecond",
    "A": "ampere", "V": "volt", "VAC": "volt", "ohm": "ohm", "W": "watt", "T": "tesla", "N": "newton",
    "Pa": "pascal", "K": "kelvin",
    "degC": "degreecelsius", "Hz": "hertz", "dB": "decibel",
}  # fmt: skip
NUMBERS = ("count", "octave")  # of dimension one
NO_PREFIX = ("deg", "arcmin", "arcsec", "degC")


def d_si(unit: str) -> str:
    r"""Return a unit in the Digital System of Units.

    Parameters
    ----------
    unit : str
        As ``core.units`` reads it.

    Raises
    ------
    DataError
        ``not_in_d_si``, if it cannot say it; ``unknown_unit``.

    Examples
    --------
    >>> print(d_si("deg/sqrt(h)"), d_si("V/(m/s^2)"), d_si("1"))
    \degree\hour\tothe{-0.5} \volt\second\tothe{2}\metre\tothe{-1} \one
    """
    parts = []
    for symbol, exponent in sorted(read_unit(unit), key=lambda one: (one[1] < 0, one[0] == "s")):
        atom, prefix = by_symbol()[symbol]
        if atom.symbol in NUMBERS:
            continue
        if atom.symbol not in WORDS or (prefix and atom.symbol in NO_PREFIX):
            raise DataError(
                f"unit {unit!r}: the Digital System of Units has no {symbol}",
                do="Convert it to SI first",
                code=CODE,
            )
        word = f"\\{PREFIXES[prefix][0]}" if prefix else ""
        parts.append(f"{word}\\{WORDS[atom.symbol]}{_power(exponent)}")
    return "".join(parts) or ONE


def _power(exponent: Fraction) -> str:
    if exponent == 1:
        return ""
    return f"\\tothe{{{exponent if exponent.denominator == 1 else float(exponent)}}}"

"""The known units: what each is worth, how it is written, which prefixes it takes; a unit is a product of powers.

``deg/sqrt(h)`` is ``(("deg", 1), ("h", -1/2))``, with exact exponents within what a unit of this field can need.

The list is closed: any other spelling is refused, because the general unit libraries read ``mgal`` as a milligallon,
``mg`` as a mass and ``G`` as either of two things. In this field ``g``, ``mg``, ``ug``, ``ng`` and ``pg`` are
accelerations (standard gravity); masses are ``kg``, ``gram`` and ``lb``.

Angle and count are dimensions of their own: ``deg/s`` is no frequency, ``count`` is no pure number; so are decibel and
octave, logarithms of ratios.

Factors are those of the SI brochure and of NIST SP 811, Appendix B.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction
from functools import cache

from ..constants import STANDARD_GRAVITY

Factor = tuple[str, Fraction]
Powers = tuple[Factor, ...]

LARGEST_EXPONENT = 12
DENOMINATORS = (1, 2, 4)  # whole powers and roots; also exact as floats
NONE: Powers = ()

PREFIXES = {
    "p": ("pico", 1e-12),
    "n": ("nano", 1e-9),
    "u": ("micro", 1e-6),
    "m": ("milli", 1e-3),
    "c": ("centi", 1e-2),
    "h": ("hecto", 1e2),
    "k": ("kilo", 1e3),
    "M": ("mega", 1e6),
    "G": ("giga", 1e9),
}
TWO_CASES = ("m", "M", "p")  # the other case is another prefix


@dataclass(frozen=True)
class Atom:
    """A unit whose spelling is not made of others."""

    symbol: str  # As printed
    name: str  # Its name in full, which is also a spelling, as is its plural
    kind: str  # What it measures; sets the order in print
    value: float  # One of it, in the unit ``of``; a base unit is 1 of itself
    of: str  # A product of other units
    si: str  # The unit of that kind inside the project
    # Those that may stand before ``symbol``, ``symbols`` (letters) and ``name``, ``words`` (in full)
    prefixes: str = ""
    symbols: tuple[str, ...] = ()  # Other spellings; case counts in symbols of one or two letters only
    words: tuple[str, ...] = ()  # Other spellings; case counts in symbols of one or two letters only
    offset: float = 0.0  # Zero of a temperature scale. [K]


ATOMS = (
    Atom("count", "count", "count", 1.0, "count", "count", "", ("ct", "cts", "LSB", "LSBs"), ("pulse", "digit")),
    Atom("%", "percent", "dimensionless", 0.01, "1", "1", symbols=("pct",)),
    Atom("ppm", "ppm", "dimensionless", 1e-6, "1", "1"),
    Atom("ppb", "ppb", "dimensionless", 1e-9, "1", "1"),
    Atom("kg", "kilogram", "mass", 1.0, "kg", "kg"),
    Atom("gram", "gram", "mass", 1e-3, "kg", "kg"),
    Atom("lb", "pound", "mass", 0.45359237, "kg", "kg", symbols=("lbm",)),
    Atom("m", "meter", "length", 1.0, "m", "m", "numck", words=("metre",)),
    Atom("inch", "inch", "length", 0.0254, "m", "m", symbols=("in", "inches")),
    Atom("ft", "foot", "length", 0.3048, "m", "m", symbols=("feet",)),
    Atom("s", "second", "time", 1.0, "s", "s", "pnum", ("sec", "secs")),
    Atom("min", "minute", "time", 60.0, "s", "s", symbols=("mins",)),
    Atom("h", "hour", "time", 3600.0, "s", "s", symbols=("hr", "hrs")),
    Atom("day", "day", "time", 86400.0, "s", "s", symbols=("d",)),
    Atom("year", "year", "time", 365.25, "day", "s", symbols=("yr",)),
    Atom("rad", "radian", "angle", 1.0, "rad", "rad", "pnum"),
    Atom("deg", "degree", "angle", math.pi / 180, "rad", "rad", "um"),
    Atom("arcmin", "arcminute", "angle", 1 / 60, "deg", "rad"),
    Atom("arcsec", "arcsecond", "angle", 1 / 3600, "deg", "rad", "um"),
    Atom("rev", "revolution", "angle", 360.0, "deg", "rad", words=("turn",)),
    Atom(
        "g",
        "standard_gravity",
        "acceleration",
        STANDARD_GRAVITY.value,
        "m/s^2",
        "m/s^2",
        "pnum",
        ("gn", "g_n", "g0"),
        ("gee", "g"),
    ),
    Atom("Gal", "galileo", "acceleration", 1e-2, "m/s^2", "m/s^2", "num", ("gal",)),
    Atom("Eotvos", "eotvos", "other", 1e-9, "1/s^2", "1/s^2"),
    Atom("A", "ampere", "other", 1.0, "A", "A", "pnum", words=("amp",)),
    Atom("V", "volt", "voltage", 1.0, "kg*m^2/s^3/A", "V", "numk", ("VDC", "DCV")),
    Atom("VAC", "volt_rms", "other", 1.0, "VAC", "VAC", "um", ("Vrms", "ACV")),  # of an alternating voltage: no sign
    Atom("ohm", "ohm", "other", 1.0, "V/A", "ohm", "mkM"),
    Atom("W", "watt", "other", 1.0, "V*A", "W", "numk"),
    Atom("T", "tesla", "other", 1.0, "V*s/m^2", "T", "num"),
    Atom("gauss", "gauss", "other", 1e-4, "T", "T", "um", ("Ga",)),
    Atom("N", "newton", "other", 1.0, "kg*m/s^2", "N", "numk"),
    Atom("Pa", "pascal", "pressure", 1.0, "N/m^2", "Pa", "umhkM"),
    Atom("bar", "bar", "pressure", 1e5, "Pa", "Pa", "um"),
    Atom("atm", "atmosphere", "pressure", 101325.0, "Pa", "Pa"),
    Atom("Torr", "torr", "pressure", 1 / 760, "atm", "Pa", "um"),
    Atom("mmHg", "millimeter_Hg", "pressure", 133.322387415, "Pa", "Pa"),
    Atom("inHg", "inch_Hg", "pressure", 25.4, "mmHg", "Pa"),
    Atom("psi", "psi", "pressure", 1.0, "lb*g/inch^2", "Pa"),
    Atom("K", "kelvin", "temperature", 1.0, "K", "degC", "um"),
    Atom("degC", "celsius", "temperature", 1.0, "K", "degC", offset=273.15),
    Atom("degF", "fahrenheit", "temperature", 5 / 9, "K", "degC", offset=233.15 + 200 / 9),
    Atom("Hz", "hertz", "frequency", 1.0, "1/s", "Hz", "umkMG"),
    Atom("dB", "decibel", "other", 1.0, "dB", "dB", symbols=("db",)),
    Atom("octave", "octave", "other", 1.0, "octave", "octave", symbols=("oct",)),
)

# Spellings that stand for a product; a prefix goes to its first factor.
COMPOUNDS: dict[str, tuple[str, tuple[tuple[str, int], ...]]] = {
    "dps": ("um", (("deg", 1), ("s", -1))),
    "dph": ("m", (("deg", 1), ("h", -1))),
    "deg_s": ("", (("deg", 1), ("s", -1))),
    "deg_h": ("", (("deg", 1), ("h", -1))),
    "rad_s": ("", (("rad", 1), ("s", -1))),
    "rpm": ("", (("rev", 1), ("min", -1))),
    "mps": ("", (("m", 1), ("s", -1))),
    "mps2": ("", (("m", 1), ("s", -2))),
    "m_s2": ("", (("m", 1), ("s", -2))),
    "pps": ("", (("count", 1), ("s", -1))),
    "hz": ("", (("Hz", 1),)),
    "HZ": ("", (("Hz", 1),)),
    "sps": ("k", (("Hz", 1),)),
    "mADC": ("", (("mA", 1),)),
    "uADC": ("", (("uA", 1),)),
}

_GAUSS = ("G is gauss as well as standard gravity", "Write g for the acceleration, gauss for the field")
_REVOLUTIONS = ("rps is radians as well as revolutions per second", "Write rad/s or rev/s")

# Two meanings, each in use: never guessed.
REFUSED = {
    "C": ("C is coulomb as well as degree Celsius", "Write degC for the temperature"),
    "F": ("F is farad as well as degree Fahrenheit", "Write degF for the temperature"),
    "G": _GAUSS,
    "mG": _GAUSS,
    "uG": _GAUSS,
    "rps": _REVOLUTIONS,
    "RPS": _REVOLUTIONS,
    "ADC": ("ADC is amperes of direct current as well as codes of a converter", "Write A or count"),
    "rads": ("rads is radians as well as radians per second", "Write rad or rad/s"),
    "degs": ("degs is degrees as well as degrees per second", "Write deg or deg/s"),
    "cps": ("cps is counts as well as cycles per second", "Write count/s or Hz"),
}


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


@dataclass(frozen=True)
class _Spelling:
    """One way to write a unit; ``prefix`` is the letter that it begins with, where that is a prefix."""

    text: str
    meaning: Powers
    prefix: str = ""


@cache
def _spellings() -> tuple[_Spelling, ...]:
    known = [_Spelling("dimensionless", NONE), _Spelling("unitless", NONE)]
    for atom in ATOMS:
        words = (atom.name, *atom.words)
        words += tuple(f"{word}s" for word in words if len(word) > 2)
        for prefix in ("", *atom.prefixes):
            meaning = powers([(prefix + atom.symbol, 1)])
            in_full = PREFIXES[prefix][0] if prefix else ""
            known += [_Spelling(prefix + symbol, meaning, prefix) for symbol in (atom.symbol, *atom.symbols)]
            known += [_Spelling(in_full + word, meaning) for word in words]
    for text, (prefixes, ((symbol, exponent), *rest)) in COMPOUNDS.items():
        for prefix in ("", *prefixes):
            known.append(_Spelling(prefix + text, powers([(prefix + symbol, exponent), *rest]), prefix))
    return tuple(known)


@cache
def by_symbol() -> dict[str, tuple[Atom, str]]:
    """Return every printed symbol, prefixed or not, with its atom and prefix letter."""
    return {prefix + atom.symbol: (atom, prefix) for atom in ATOMS for prefix in ("", *atom.prefixes)}


@cache
def spellings() -> dict[str, Powers]:
    """Return every spelling that is accepted as it stands, with what it means."""
    return {spelling.text: spelling.meaning for spelling in _spellings()}


@cache
def _by_lower_case() -> dict[str, list[_Spelling]]:
    found: dict[str, list[_Spelling]] = {}
    for spelling in _spellings():
        if len(spelling.text) > 2:
            found.setdefault(spelling.text.lower(), []).append(spelling)
    return found


def meaning(text: str) -> Powers | None:
    """Return what a spelling means, or None where it is not known.

    Case is passed over in spellings of three letters or more where that leaves one meaning and does not
    touch a prefix: ``DPS`` is ``deg/s``; ``mhz`` may be mHz or MHz, ``Mrad`` is no mrad: not known.
    """
    exact = spellings().get(text)
    if exact is not None or text in REFUSED:
        return exact
    found = _by_lower_case().get(text.lower(), [])
    one_meaning = len({spelling.meaning for spelling in found}) == 1
    prefix_kept = all(s.prefix not in TWO_CASES or text.startswith(s.prefix) for s in found)
    return found[0].meaning if one_meaning and prefix_kept else None


def kind_of(symbol: str) -> str:
    """Return what a printed symbol measures: ``kind_of("mdeg")`` is ``"angle"``."""
    return by_symbol()[symbol][0].kind

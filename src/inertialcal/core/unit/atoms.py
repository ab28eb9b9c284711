"""The units that are known: what each is worth, how it is written, which prefixes it takes.

The list is closed: a spelling that is not on it is refused, because the general unit libraries read
``mgal`` as a milligallon, ``mg`` as a mass and ``G`` as either of two things. In this field ``g``, ``mg``,
``ug``, ``ng`` and ``pg`` are accelerations (standard gravity); masses are ``kg``, ``gram`` and ``lb``.

Angle and count are dimensions of their own: ``deg/s`` is no frequency, ``count`` is no pure number.

The values stand as right-hand sides in the language of pint, in terms of the units above them; factors
are those of the SI brochure and of NIST SP 811, Appendix B.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from functools import cache

from ..constants import STANDARD_GRAVITY
from .powers import NONE, Powers, powers

PREFIXES = {
    "p": ("pico", "1e-12"),
    "n": ("nano", "1e-9"),
    "u": ("micro", "1e-6"),
    "m": ("milli", "1e-3"),
    "c": ("centi", "1e-2"),
    "h": ("hecto", "1e2"),
    "k": ("kilo", "1e3"),
    "M": ("mega", "1e6"),
    "G": ("giga", "1e9"),
}
TWO_CASES = ("m", "M", "p")  # the other case is another prefix


@dataclass(frozen=True)
class Atom:
    """One unit that is not made of others in its spelling.

    Parameters
    ----------
    symbol : str
        As it is printed.
    name : str
        Its name in the registry, which is also a spelling, as is its plural.
    kind : str
        What it measures; sets the order in print.
    value : str
        Dimension, or value in units above it.
    si : str
        The unit of that kind inside the project.
    prefixes : str
        Those that may stand before ``symbol``, ``symbols`` (letters) and ``name``, ``words`` (in full).
    symbols, words : tuple of str
        Other spellings; case counts in symbols of one or two letters only.
    """

    symbol: str
    name: str
    kind: str
    value: str
    si: str
    prefixes: str = ""
    symbols: tuple[str, ...] = ()
    words: tuple[str, ...] = ()


_GRAVITY = f"{STANDARD_GRAVITY.value!r} * meter / second**2"

ATOMS = (
    Atom("count", "count", "count", "[count]", "count", "", ("ct", "cts", "LSB", "LSBs"), ("pulse", "digit")),
    Atom("%", "percent", "dimensionless", "0.01", "1", symbols=("pct",)),
    Atom("ppm", "ppm", "dimensionless", "1e-6", "1"),
    Atom("ppb", "ppb", "dimensionless", "1e-9", "1"),
    Atom("kg", "kilogram", "mass", "[mass]", "kg"),
    Atom("gram", "gram", "mass", "1e-3 * kilogram", "kg"),
    Atom("lb", "pound", "mass", "0.45359237 * kilogram", "kg", symbols=("lbm",)),
    Atom("m", "meter", "length", "[length]", "m", "numck", words=("metre",)),
    Atom("inch", "inch", "length", "0.0254 * meter", "m", symbols=("in", "inches")),
    Atom("ft", "foot", "length", "0.3048 * meter", "m", symbols=("feet",)),
    Atom("s", "second", "time", "[time]", "s", "pnum", ("sec", "secs")),
    Atom("min", "minute", "time", "60 * second", "s", symbols=("mins",)),
    Atom("h", "hour", "time", "3600 * second", "s", symbols=("hr", "hrs")),
    Atom("day", "day", "time", "86400 * second", "s", symbols=("d",)),
    Atom("year", "year", "time", "365.25 * day", "s", symbols=("yr",)),
    Atom("rad", "radian", "angle", "[angle]", "rad", "pnum"),
    Atom("deg", "degree", "angle", f"{math.pi!r} / 180 * radian", "rad", "um"),
    Atom("arcmin", "arcminute", "angle", "degree / 60", "rad"),
    Atom("arcsec", "arcsecond", "angle", "degree / 3600", "rad", "um"),
    Atom("rev", "revolution", "angle", "360 * degree", "rad", words=("turn",)),
    Atom("g", "standard_gravity", "acceleration", _GRAVITY, "m/s^2", "pnum", ("gn", "g_n", "g0"), ("gee", "g")),
    Atom("Gal", "galileo", "acceleration", "1e-2 * meter / second**2", "m/s^2", "num", ("gal",)),
    Atom("Eotvos", "eotvos", "other", "1e-9 / second**2", "1/s^2"),
    Atom("A", "ampere", "other", "[current]", "A", "pnum", words=("amp",)),
    Atom("V", "volt", "voltage", "kilogram * meter**2 / second**3 / ampere", "V", "numk"),
    Atom("ohm", "ohm", "other", "volt / ampere", "ohm", "mkM"),
    Atom("W", "watt", "other", "volt * ampere", "W", "numk"),
    Atom("T", "tesla", "other", "volt * second / meter**2", "T", "num"),
    Atom("gauss", "gauss", "other", "1e-4 * tesla", "T", "um"),
    Atom("N", "newton", "other", "kilogram * meter / second**2", "N", "numk"),
    Atom("Pa", "pascal", "pressure", "newton / meter**2", "Pa", "umhkM"),
    Atom("bar", "bar", "pressure", "1e5 * pascal", "Pa", "um"),
    Atom("atm", "atmosphere", "pressure", "101325 * pascal", "Pa"),
    Atom("Torr", "torr", "pressure", "atmosphere / 760", "Pa", "um"),
    Atom("mmHg", "millimeter_Hg", "pressure", "133.322387415 * pascal", "Pa"),
    Atom("inHg", "inch_Hg", "pressure", "25.4 * millimeter_Hg", "Pa"),
    Atom("psi", "psi", "pressure", "pound * standard_gravity / inch**2", "Pa"),
    Atom("K", "kelvin", "temperature", "[temperature]", "degC", "um"),
    Atom("degC", "celsius", "temperature", "kelvin; offset: 273.15", "degC"),
    Atom("degF", "fahrenheit", "temperature", "5 / 9 * kelvin; offset: 233.15 + 200 / 9", "degC"),
    Atom("Hz", "hertz", "frequency", "1 / second", "Hz", "umkMG"),
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
    "rads": ("rads is radians as well as radians per second", "Write rad or rad/s"),
    "degs": ("degs is degrees as well as degrees per second", "Write deg or deg/s"),
    "cps": ("cps is counts as well as cycles per second", "Write count/s or Hz"),
}


@dataclass(frozen=True)
class _Spelling:
    """One way to write a unit; ``prefix`` is the letter that it begins with, where that is a prefix."""

    text: str
    meaning: Powers
    prefix: str = ""


def _atom_spellings(atom: Atom) -> Iterator[_Spelling]:
    words = (atom.name, *atom.words)
    plurals = tuple(f"{word}s" for word in words if len(word) > 2)
    for prefix in ("", *atom.prefixes):
        meaning = powers([(prefix + atom.symbol, 1)])
        in_full = PREFIXES[prefix][0] if prefix else ""
        for symbol in (atom.symbol, *atom.symbols):
            yield _Spelling(prefix + symbol, meaning, prefix)
        for word in (*words, *plurals):
            yield _Spelling(in_full + word, meaning)


def _compound_spellings() -> Iterator[_Spelling]:
    for text, (prefixes, ((symbol, exponent), *rest)) in COMPOUNDS.items():
        for prefix in ("", *prefixes):
            yield _Spelling(prefix + text, powers([(prefix + symbol, exponent), *rest]), prefix)


@cache
def _spellings() -> tuple[_Spelling, ...]:
    atoms = (spelling for atom in ATOMS for spelling in _atom_spellings(atom))
    return (*atoms, *_compound_spellings(), _Spelling("dimensionless", NONE), _Spelling("unitless", NONE))


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


def registry_name(symbol: str) -> str:
    """Return the registry's name of a printed symbol: ``registry_name("mV")`` is ``"millivolt"``."""
    atom, prefix = by_symbol()[symbol]
    return (PREFIXES[prefix][0] if prefix else "") + atom.name


def definitions() -> list[str]:
    """Return all prefixes and units, in the language of pint."""
    return [f"{name}- = {value}" for name, value in PREFIXES.values()] + [
        f"{atom.name} = {atom.value}" for atom in ATOMS
    ]


def exponents_of(unit: Powers, kind: str) -> list[tuple[str, Fraction]]:
    """Return those factors of a unit that measure one kind of thing."""
    return [(symbol, exponent) for symbol, exponent in unit if kind_of(symbol) == kind]

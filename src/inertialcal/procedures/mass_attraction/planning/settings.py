"""What a user says of a source mass, as words and numbers with units, turned into SI.

``ng`` and its family are accelerations of standard gravity, unless a document's own ``gravity`` is given: then they are
multiples of that.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal, TypeVar

from ....core.constants import GRAVITATIONAL_CONSTANT, STANDARD_GRAVITY
from ....core.errors import DataError, UsageError
from ....core.units import parse_quantity
from ....physics.budget import Doubts
from ....sensors.noise import BiasInstability, Quantization, RandomWalk, RateRamp, RateRandomWalk, Term, parameter_unit

Moved = Literal["along", "across"]
W = TypeVar("W", bound=str)
WANTED = ("attraction", "change")
G_UNIT = "m^3/s^2/kg"
LEAD = "11.34 g/cm^3"
LETTERS: dict[str, type[Any]] = {
    "Q": Quantization, "N": RandomWalk, "B": BiasInstability, "K": RateRandomWalk, "R": RateRamp,
}  # fmt: skip
LETTER = re.compile(r"\b([A-Za-z]\w*)\s*=\s*")
GRID = re.compile(r"\s*(\d{1,4})\s*[xX]\s*(\d{1,4})\s*[xX]\s*(\d{1,4})\s*", re.ASCII)
PIECES = re.compile(r"\s*(\d{1,7})\s*[xX]\s*(.+)", re.ASCII)
OF_GRAVITY = re.compile(r"[pnum]?g\b")
OF_WEIGHT = re.compile(r"(?<=\d)\s*g\s*/\s*(?=[cm]?m)|(?<=\d)\s*g\s*$")  # "11.34 g/cm^3": here a gram, no acceleration
QUIETEST, LOUDEST = 1e-20, 1e3  # SI, of a coefficient of noise
LONGEST_NOISE = 400  # characters


@dataclass(frozen=True)
class Constants:
    """Constants of a document, or today's.

    Parameters
    ----------
    gravitational_constant : float
        [m^3/s^2/kg].
    u_gravitational_constant : float
        Relative.
    gravity : float
        What a g is [m/s^2].
    """

    gravitational_constant: float = GRAVITATIONAL_CONSTANT.value
    u_gravitational_constant: float = GRAVITATIONAL_CONSTANT.u / GRAVITATIONAL_CONSTANT.value
    gravity: float = STANDARD_GRAVITY.value

    @property
    def ng(self) -> float:
        """A nano-g [m/s^2]."""
        return 1e-9 * self.gravity

    @property
    def told(self) -> dict[str, str]:
        """What a file says of them."""
        return {
            "gravitational constant": f"{self.gravitational_constant!r} {G_UNIT}",
            "gravity": f"{self.gravity!r} m/s^2",
        }

    def acceleration(self, text: str, what: str) -> float:
        """Return an acceleration that was written [m/s^2]; multiples of g are those of this gravity."""
        return number(text, "m/s^2", what, "74 ng") * self.scale(text)

    def scale(self, text: str) -> float:
        """Return what a text in multiples of standard gravity is to be multiplied by."""
        unit = parse_quantity(text).unit
        return self.gravity / STANDARD_GRAVITY.value if OF_GRAVITY.match(unit) else 1.0


def constants_of(big_g: str | None, gravity: str | None) -> Constants:
    """Return the constants; those of a document are taken as they stand.

    Raises
    ------
    UsageError
        If one has no unit, or cannot be what it is said to be.
    """
    found: dict[str, float] = {}
    if big_g is not None:
        value = number(big_g, G_UNIT, "big_g", "6.67e-8 cm^3/s^2/gram")
        _within(value / GRAVITATIONAL_CONSTANT.value, 0.9, 1.1, f"big_g: {big_g}", "6.674e-11 m^3/s^2/kg")
        found |= {"gravitational_constant": value, "u_gravitational_constant": 0.0}
    if gravity is not None:
        value = number(gravity, "m/s^2", "gravity", "981 cm/s^2")
        _within(value, 9.7, 9.9, f"gravity: {gravity}", "9.80665 m/s^2")
        found["gravity"] = value
    return Constants(**found)


def _within(value: float, low: float, high: float, what: str, like: str) -> None:
    if not low <= value <= high:
        raise UsageError(f"{what} is not what it is said to be", do=f"It is about {like}", code="wrong_value")


def number(text: str, unit: str, what: str, like: str) -> float:
    """Return a number in a unit.

    Parameters
    ----------
    text : str
        By the user: ``"5.08 cm"``.
    unit : str
        Of the number.
    what : str
        Name of the setting, for the message.
    like : str
        How to write it.

    Raises
    ------
    UsageError
        If it has no unit, or another one.
    """
    try:
        return float(parse_quantity(text).to(unit))
    except DataError as error:
        do = f'Write a number with its unit, like "{like}"'
        raise UsageError(f"{what}: {text!r}", why=error.problems[0].what, do=do, code="no_unit") from None


def positive(text: str, unit: str, what: str, like: str) -> float:
    """Return a number above zero in a unit; errors as `number`."""
    value = number(text, unit, what, like)
    if not value > 0.0:
        raise UsageError(f"{what}: {text!r} is not above zero", do=f'Write it like "{like}"', code="wrong_value")
    return value


def density_of(text: str) -> float:
    """Return a density [kg/m^3]; ``g`` is a gram here, because nothing else is left for it to be."""
    return positive(OF_WEIGHT.sub(" gram/", text), "kg/m^3", "density", LEAD)


def mass_of(text: str) -> float:
    """Return a mass [kg]."""
    return positive(OF_WEIGHT.sub(" gram", text), "kg", "mass", "1338 kg")


def grid_of(text: str) -> tuple[int, int, int]:
    """Return the cells of a grid along x (the input axis), y and z; they are written across, across, along.

    Raises
    ------
    UsageError
        If there are not three numbers above zero.
    """
    match = GRID.fullmatch(text)
    sides = tuple(int(side) for side in match.groups()) if match else ()
    if len(sides) != len("xyz") or min(sides) < 1:
        do = "Write cells twice across the input axis, and along it: 20x20x10"
        raise UsageError(f"grid: {text!r}", do=do, code="wrong_value")
    return sides[2], sides[0], sides[1]


def inventory_of(text: str) -> list[tuple[int, float]]:
    """Return count and edge [m] of each size of cubes.

    Raises
    ------
    UsageError
        If an entry is not a count and a length.
    """
    found = []
    for part in text.split(","):
        match = PIECES.fullmatch(part)
        if match is None or int(match[1]) < 1:
            do = 'Write counts and edges: "100x10.2 cm,100x5.1 cm"'
            raise UsageError(f"inventory: {part.strip()!r}", do=do, code="wrong_value")
        found.append((int(match[1]), positive(match[2], "m", "inventory", "5.1 cm")))
    return found


def range_of(text: str, what: str) -> tuple[float, float]:
    """Return two ends, the smaller first [m].

    Raises
    ------
    UsageError
        If there are not two different lengths with a colon between.
    """
    ends = [number(part, "m", what, "12.7 cm:43.2 cm") for part in text.split(":")]
    if len(ends) != 2 or ends[0] == ends[1]:
        do = 'Write two ends: "12.7 cm:43.2 cm"'
        raise UsageError(f"{what}: {text!r}", do=do, code="wrong_value")
    return min(ends), max(ends)


def one_of(given: str, words: tuple[W, ...], what: str) -> W:
    """Return a word that is known.

    Raises
    ------
    UsageError
        If it is not.
    """
    for one in words:
        if one == given.lower():
            return one
    raise UsageError(f"{what}: {given!r}", do=f"There are: {', '.join(words)}", code="wrong_value")


def noise_of(text: str, constants: Constants) -> tuple[Term, ...]:
    """Return the terms of noise that are written with their letters, SI.

    Parameters
    ----------
    text : str
        ``"N=5 ug/sqrt(Hz) B=0.02 ug K=1e-4 ug/sqrt(s)"``: Q quantisation, N white noise, B flicker, K random walk,
        R ramp.
    constants : Constants
        Whose g is meant.

    Raises
    ------
    UsageError
        If a letter is none, comes twice, or a number has no unit or another one.
    """
    parts = LETTER.split(text[:LONGEST_NOISE].strip())
    if parts[0].strip(" ,;") or len(parts) < 3:
        raise UsageError(f"noise: {text!r}", do=_how_noise(), code="wrong_value")
    letters, values = parts[1::2], [value.strip(" ,;") for value in parts[2::2]]
    if len(set(letters)) < len(letters):
        raise UsageError(f"noise: {text!r} has a term twice", do=_how_noise(), code="wrong_value")
    return tuple(_term(letter, value, constants) for letter, value in zip(letters, values, strict=True))


def _term(letter: str, value: str, constants: Constants) -> Term:
    if letter not in LETTERS:
        raise UsageError(f"noise: no term {letter!r}", do=_how_noise(), code="unknown_name")
    kind = LETTERS[letter]
    unit = parameter_unit(kind.name, "coefficient", "m/s^2")
    size = positive(value, unit, f"noise: {letter}", _like(letter)) * constants.scale(value)
    if not QUIETEST < size < LOUDEST:
        raise UsageError(f"noise: {letter}: {value!r} is of no sensor", do=_how_noise(), code="wrong_value")
    found: Term = kind(size)
    return found


def _like(letter: str) -> str:
    return {"Q": "1e-6 m/s", "N": "5 ug/sqrt(Hz)", "B": "0.02 ug", "K": "1e-4 ug/sqrt(s)", "R": "0.1 ug/h"}[letter]


def _how_noise() -> str:
    return 'Write terms with their units: "N=5 ug/sqrt(Hz) B=0.02 ug K=1e-4 ug/sqrt(s)"'


RELATIVE = {"density": "0.3 %", "piece_density": "0.5 %"}
LENGTHS = {"position": "0.5 mm", "stop": "1 mm", "piece_place": "0.5 mm"}


def doubts_of(given: Mapping[str, str | None], constants: Constants) -> tuple[Doubts, tuple[str, ...]]:
    """Return the doubts of a source mass, and the names of those that nobody stated.

    Parameters
    ----------
    given : mapping of str to str or None
        ``density``, ``piece_density``, ``position``, ``stop``, ``piece_place``, ``angle``.
    constants : Constants
        With the doubt of the gravitational constant.

    Raises
    ------
    UsageError
        If one has no unit, or another one, or is below zero.
    """
    units = dict.fromkeys(RELATIVE, "1") | dict.fromkeys(LENGTHS, "m") | {"angle": "rad"}
    like = RELATIVE | LENGTHS | {"angle": "2 mrad"}
    value = {
        name: _not_below(number(text, units[name], f"u_{name}", like[name]), f"u_{name}: {text!r}")
        for name, text in given.items()
        if text is not None
    }
    place = value.pop("position", 0.0)
    doubts = Doubts(place=(place, place, place), gravitational_constant=constants.u_gravitational_constant, **value)
    return doubts, tuple(name for name, text in given.items() if text is None)


def _not_below(value: float, what: str) -> float:
    if not value >= 0.0:
        raise UsageError(f"{what} is below zero", why="an uncertainty has no sign", code="wrong_value")
    return value

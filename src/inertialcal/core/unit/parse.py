"""Reading of units and quantities as people write them.

A text is a chain of factors with ``*`` and ``/``, read from left to right; a blank or a dot multiplies too.
``sqrt``, ``rt``, ``root`` and the root sign take the factor that follows them; ``^``, ``**``, raised digits
or a digit right behind a name (``s2``, ``s-2``) or a bracket of units (``(m/s2)2``) are exponents; ``per`` divides.
Nothing else is evaluated.

What has two readings is refused, and both are spelled out: a product after a division without a sign
(``deg/s g``), division by an angle or a length and then by a time (``mV/deg/s``), ``ms-2``, ``m/s-2``.

Before that the many ways to write a sign become plain ASCII: both micro signs, three degree signs, dots, dashes,
raised digits and the root sign.
"""

from __future__ import annotations

import difflib
import math
import re
import unicodedata
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from typing import Literal, NoReturn

from ..errors import DataError
from .atoms import NONE, REFUSED, Powers, kind_of, meaning, product, quotient, raised, spellings
from .spelling import LONGEST, spell

Code = Literal["unknown_unit", "unknown_quantity"]

EXAMPLES: dict[Code, str] = {
    "unknown_unit": "Examples of units: deg/s, m/s^2, ug/sqrt(Hz), V/(deg/s), count, degC, %",
    "unknown_quantity": "Write a number and a unit, like '0.5 V/(deg/s)', '5 V / 4095', '0.05 %'",
}

_SIGNS = str.maketrans(
    {
        **dict.fromkeys("\N{MICRO SIGN}\N{GREEK SMALL LETTER MU}", "u"),
        **dict.fromkeys("\N{DEGREE SIGN}\N{MASCULINE ORDINAL INDICATOR}\N{RING ABOVE}", "deg"),
        **dict.fromkeys("\N{MINUS SIGN}\N{EN DASH}\N{HYPHEN}\N{NON-BREAKING HYPHEN}", "-"),
        **dict.fromkeys("\N{MIDDLE DOT}\N{DOT OPERATOR}\N{BULLET}\N{BULLET OPERATOR}\N{MULTIPLICATION SIGN}", "."),
        **dict.fromkeys("\N{DIVISION SLASH}\N{FRACTION SLASH}", "/"),
        "\N{SQUARE ROOT}": " sqrt ",
        "\N{GREEK CAPITAL LETTER OMEGA}": "ohm",
    }
)
_RAISED = re.compile("[⁰¹²³⁴⁵⁶⁷⁸⁹⁺⁻]+")
_RAISED_SIGNS = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁺⁻", "0123456789+-")
_DEGREES = re.compile(r"\bdeg(?:rees?)?\s+(c|f|celsius|fahrenheit)\b", re.IGNORECASE)
_HYPHEN = re.compile(r"\b(pico|nano|micro|milli|kilo)-(?=[a-z])", re.IGNORECASE)
_TOKEN = re.compile(
    r"(?P<number>(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?)"
    r"|(?P<per>\bper\b)|(?P<name>[A-Za-z_%]+)|(?P<sign>\*\*|[*/^().+-])|(?P<blank>\s+)|(?P<other>.)",
    re.IGNORECASE,
)
_ONE_SIGN = {"**": "^", "per": "/"}
DEEPEST = 8  # brackets inside brackets
_REMEMBERED = 4096  # texts

_ROOT = re.compile(r"(?:sqrt|root|rt)_?(.*)", re.IGNORECASE)
_EXPONENT = re.compile(r"[0-9]{1,2}(\.[0-9]{1,2})?|\.[0-9]{1,2}")  # no size that could cost time or memory
_DIGIT = re.compile(r"[1-9]")


@dataclass(frozen=True)
class Token:
    """A number, a name or a sign; ``touches`` where no blank stands before it."""

    kind: str
    text: str
    touches: bool


_END = Token("end", "", False)


@dataclass
class Cursor:
    """A place in the tokens of a text; beyond the last is an empty token."""

    source: str
    code: Code
    tokens: list[Token]
    at: int = 0
    suggests: bool = True  # Whether a refusal names the nearest known spellings, which takes a hundred times longer

    @property
    def with_number(self) -> bool:
        """Whether a quantity is read, not a unit."""
        return self.code == "unknown_quantity"

    def peek(self, ahead: int = 0) -> Token:
        """Return a token and stay."""
        at = self.at + ahead
        return self.tokens[at] if at < len(self.tokens) else _END

    def take(self) -> Token:
        """Return the next token and pass it."""
        token = self.peek()
        self.at += 1
        return token

    def put_back(self, name: str) -> None:
        """Make a name the next token, in place of the last one taken."""
        self.at -= 1
        self.tokens[self.at] = Token("name", name, False)

    def expect(self, sign: str) -> None:
        """Pass a sign that must follow."""
        if self.take().text != sign:
            self.refuse(f"{sign!r} is missing")

    def refuse(self, reason: str, do: str = "") -> NoReturn:
        """Raise the DataError of a text that cannot be read, naming it."""
        shown = self.source if len(self.source) <= LONGEST else self.source[:LONGEST] + "..."
        what = f"{self.code.removeprefix('unknown_')} {shown!r}: {reason}"
        raise DataError(what, do=do or EXAMPLES[self.code], code=self.code)


def cursor(text: str, code: Code, suggests: bool = True) -> Cursor:
    """Return a cursor before the first token of a text.

    Raises
    ------
    DataError
        If the text is longer than 80 characters or has a character that no unit has.
    """
    at = Cursor(text, code, [], suggests=suggests)
    if len(text) > LONGEST:
        at.refuse(f"it has {len(text)} characters, more than {LONGEST}")
    touches = False
    for found in _TOKEN.finditer(_plain(text)):
        kind, written = str(found.lastgroup), found[0]
        if kind == "other":
            advice = "Use a decimal point" if written == "," else ""
            at.refuse(f"the character {written!r} does not belong here", advice)
        if kind != "blank":
            at.tokens.append(Token(kind, _ONE_SIGN.get(written.lower(), written), touches))
        touches = kind != "blank"
    return at


def _plain(text: str) -> str:
    """Return the text in plain ASCII, as far as its signs have a meaning."""
    text = _RAISED.sub(lambda found: f"^({found[0].translate(_RAISED_SIGNS)})", text.strip())
    text = unicodedata.normalize("NFKC", text.translate(_SIGNS)).translate(_SIGNS)
    text = _HYPHEN.sub(r"\1", text.replace("_per_", "/").replace("sqrt_", "sqrt "))
    return _DEGREES.sub(lambda found: "deg" + found[1][0].upper(), text)


@dataclass(frozen=True)
class _Factor:
    """A number times a unit.

    ``name`` is its spelling where it was written as one name; ``inverse`` says that this name had a
    negative exponent.
    """

    value: float = 1.0
    unit: Powers = NONE
    name: str = ""
    inverse: bool = False

    def __mul__(self, other: _Factor) -> _Factor:
        return _Factor(self.value * other.value, product(self.unit, other.unit))


@lru_cache(_REMEMBERED)
def read_unit(text: str) -> Powers:
    """Return the unit that a text means; nothing and ``-`` are dimensionless.

    Raises
    ------
    DataError
        With code ``unknown_unit``, if it is not known or has two readings.
    """
    if text.strip() in {"", "-"}:
        return NONE
    return _read(cursor(text, "unknown_unit")).unit


@lru_cache(_REMEMBERED)
def can_read_unit(text: str) -> bool:
    """Return whether `read_unit` can read a text."""
    try:
        return text.strip() in {"", "-"} or bool(_read(cursor(text, "unknown_unit", suggests=False)))
    except DataError:
        return False


def read_quantity(text: str) -> tuple[float, Powers]:
    """Return the number and the unit that a text means.

    Raises
    ------
    DataError
        With code ``unknown_quantity``, if it must begin with a number, its unit is not known, it has
        two readings, or the value is not finite.
    """
    at = cursor(text, "unknown_quantity")
    sign = -1.0 if at.peek().text == "-" else 1.0
    if at.peek().text in {"+", "-"}:
        at.tokens.pop(0)
    if at.peek().kind != "number":
        at.refuse("it must begin with a number")
    factor = _read(at)
    if not math.isfinite(factor.value):
        at.refuse("the value is not finite")
    return sign * factor.value, factor.unit


def _read(at: Cursor) -> _Factor:
    try:
        factor = _chain(at, 0)
        spell(factor.unit)
    except ValueError as error:  # an exponent, or the length
        at.refuse(str(error))
    if at.peek().text:
        at.refuse(f"{at.peek().text!r} does not belong here")
    return factor


def _chain(at: Cursor, depth: int) -> _Factor:
    """Read factors up to a closing bracket or the end."""
    if depth > DEEPEST:
        at.refuse(f"more than {DEEPEST} brackets or roots inside each other")
    total, last_divisor, divided = _operand(at, depth), _Factor(), False
    while True:
        if at.peek().text == "/":
            at.take()
            divisor = _operand(at, depth)
            _check_divisors(at, last_divisor, divisor)
            if divisor.value == 0.0:
                at.refuse("it divides by zero")
            total = _Factor(total.value / divisor.value, quotient(total.unit, divisor.unit))
            last_divisor, divided = divisor, True
        elif _multiplies(at, divided):
            total, last_divisor = total * _operand(at, depth), _Factor()
        else:
            return total


def _check_divisors(at: Cursor, last: _Factor, divisor: _Factor) -> None:
    """Refuse ``x/deg/s``, ``x/m/s^2`` and ``x/s-2``."""
    if divisor.inverse:
        at.refuse("division by a negative exponent is ambiguous", "Write m/s^2 or m s-2")
    if not (last.name and divisor.name):
        return
    first, second = (kind_of(factor.unit[0][0]) for factor in (last, divisor))
    if first in {"angle", "length"} and second == "time":
        head = "".join(token.text for token in at.tokens).split("/")[0].lstrip("(")
        a, b = last.name, divisor.name
        at.refuse(
            f"it can mean {head}/({a}/{b}) or {head}/({a}*{b})",
            f"Write {head}/({a}/{b}), if that is meant",
        )


def _multiplies(at: Cursor, divided: bool) -> bool:
    """Whether a factor follows; takes the sign before it."""
    token = at.peek()
    if token.text == "*":
        at.take()
        return True
    follows = at.peek(1) if token.text == "." else token
    if follows.kind not in {"number", "name"} and follows.text != "(":
        return False
    last = at.peek(-1)
    if follows.kind == "number":
        one_over = at.with_number and at.at == 1 and follows.text == "1" and at.peek(1).text == "/"
        if not one_over:  # "5 1/s" is five per second
            at.refuse(f"the number {follows.text} follows {last.text!r} without a sign between")
    elif follows.text == "(" and last.kind == "name" and at.peek().text != ".":
        at.refuse(f"a bracket follows {last.text!r} without a sign between", "Write * or / before the bracket")
    if divided:
        at.refuse(
            f"{follows.text!r} after a division may be a factor or a divisor",
            "Put brackets around what is divided by, or write * or / before it",
        )
    if token.text == ".":
        at.take()
    return True


def _operand(at: Cursor, depth: int) -> _Factor:
    """Read a number, a name, a root or a bracket, with its exponent."""
    token = at.take()
    if token.kind == "number":
        if not at.with_number and token.text != "1":
            at.refuse(f"it contains the number {token.text}")
        return _raise(at, _Factor(float(token.text)))
    if token.text == "(":
        inner = _chain(at, depth + 1)
        at.expect(")")
        return _raise(at, _Factor(inner.value, inner.unit), power=bool(inner.unit) and inner.value == 1.0)
    if token.kind != "name":
        at.refuse(f"a unit is missing before {token.text!r}" if token.text else "a unit is missing at the end")
    root = _ROOT.fullmatch(token.text)
    if not root or meaning(token.text) is not None:
        return _name(at, token)
    if depth > DEEPEST:
        at.refuse(f"more than {DEEPEST} brackets or roots inside each other")
    if root[1]:  # written together with the sign
        at.put_back(root[1])
    inner = _operand(at, depth + 1)
    return _Factor(math.sqrt(inner.value), raised(inner.unit, Fraction(1, 2)))


def _name(at: Cursor, token: Token) -> _Factor:
    text, follows = token.text, at.peek()
    if follows.kind == "number" and follows.touches and meaning(text + follows.text) is not None:
        text += at.take().text
    unit = meaning(text)
    if unit is None:
        if text in REFUSED:
            at.refuse(*REFUSED[text])
        if not at.suggests:
            at.refuse(f"{text!r} is not known")
        near = [known for known in spellings() if known.lower() == text.lower()]
        near += [known for known in difflib.get_close_matches(text, spellings(), n=5) if known not in near]
        hint = f"Nearest known: {', '.join(near)}. " if near else ""
        at.refuse(f"{text!r} is not known", hint + EXAMPLES[at.code])
    factor = _raise(at, _Factor(1.0, unit), text)
    if len(factor.unit) != 1:
        return factor
    return _Factor(1.0, factor.unit, spell(factor.unit), factor.unit[0][1] < 0)


def _raise(at: Cursor, factor: _Factor, name: str = "", *, power: bool = False) -> _Factor:
    """Apply the exponent that follows, if one does; ``power`` of a bracket of units: ``(m/s2)2``."""
    exponent = read_exponent(at, named=bool(name) or power)
    if exponent is None:
        return factor
    if name == "ms" and exponent < 0:
        at.refuse("ms may mean milliseconds or m and s", "Write m/s, m/s^2, or 1/ms, 1/ms^2")
    try:
        return _Factor(factor.value ** float(exponent), raised(factor.unit, exponent))
    except ArithmeticError:
        at.refuse("the value is not finite")


def read_exponent(cursor: Cursor, named: bool) -> Fraction | None:
    """Return the exponent that follows, or None.

    Parameters
    ----------
    cursor : Cursor
        Behind what is raised.
    named : bool
        Whether that is a name, so that a digit right behind it is an exponent.

    Raises
    ------
    DataError
        If it is no number of one or two digits, with up to two decimals.
    """
    token = cursor.peek()
    if token.text == "^":
        cursor.take()
        return _in_brackets(cursor) if cursor.peek().text == "(" else _signed(cursor, _EXPONENT)
    signed = token.text in {"+", "-"} and cursor.peek(1).touches
    if named and token.touches and (token.kind == "number" or signed):
        return _signed(cursor, _DIGIT)
    return None


def _in_brackets(cursor: Cursor) -> Fraction:
    cursor.expect("(")
    value = _signed(cursor, _EXPONENT)
    if cursor.peek().text == "/":
        cursor.take()
        below = _signed(cursor, _EXPONENT)
        if not below:
            cursor.refuse("its exponent divides by zero")
        value /= below
    cursor.expect(")")
    return value


def _signed(cursor: Cursor, allowed: re.Pattern[str]) -> Fraction:
    token = cursor.take()
    sign = -1 if token.text == "-" else 1
    if token.text in {"+", "-"}:
        token = cursor.take()
    if not allowed.fullmatch(token.text):
        cursor.refuse(f"{token.text!r} is not an exponent", "Examples of exponents: ^2, ^-0.5, ^(1/2)")
    return sign * Fraction(token.text)

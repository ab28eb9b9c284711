"""Tokens of a unit or a quantity, after the many ways to write a sign are made one.

Both micro signs, three degree signs, dots, dashes, raised digits and the root sign become plain ASCII.
"""

from __future__ import annotations

import re
import unicodedata
from dataclasses import dataclass
from typing import Literal, NoReturn

from ..errors import DataError
from .spelling import LONGEST

Code = Literal["unknown_unit", "unknown_quantity"]

EXAMPLES: dict[Code, str] = {
    "unknown_unit": "Units are written like deg/s, m/s^2, ug/sqrt(Hz), V/(deg/s), count, degC, %",
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
        refuse(self.source, self.code, reason, do)


def cursor(text: str, code: Code) -> Cursor:
    """Return a cursor before the first token of a text.

    Raises
    ------
    DataError
        If the text is longer than 80 characters or has a character that no unit has.
    """
    return Cursor(text, code, _tokens(text, code))


def refuse(text: str, code: Code, reason: str, do: str = "") -> NoReturn:
    """Raise the DataError of a unit or quantity that cannot be read, naming it."""
    shown = text if len(text) <= LONGEST else text[:LONGEST] + "..."
    raise DataError(f"{code.removeprefix('unknown_')} {shown!r}: {reason}", do=do or EXAMPLES[code], code=code)


def _tokens(text: str, code: Code) -> list[Token]:
    if len(text) > LONGEST:
        refuse(text, code, f"it has {len(text)} characters, more than {LONGEST}")
    tokens, touches = [], False
    for found in _TOKEN.finditer(plain(text)):
        kind, written = str(found.lastgroup), found[0]
        if kind == "other":
            advice = "Write the decimal sign as a point" if written == "," else ""
            refuse(text, code, f"the character {written!r} does not belong there", advice)
        if kind != "blank":
            tokens.append(Token(kind, _ONE_SIGN.get(written.lower(), written), touches))
        touches = kind != "blank"
    return tokens


def plain(text: str) -> str:
    """Return the text in plain ASCII, as far as its signs have a meaning."""
    text = _RAISED.sub(lambda found: f"^({found[0].translate(_RAISED_SIGNS)})", text.strip())
    text = unicodedata.normalize("NFKC", text.translate(_SIGNS)).translate(_SIGNS)
    text = _HYPHEN.sub(r"\1", text.replace("_per_", "/").replace("sqrt_", "sqrt "))
    return _DEGREES.sub(lambda found: "deg" + found[1][0].upper(), text)

"""Reading of units and quantities as people write them.

A text is a chain of factors with ``*`` and ``/``, read from left to right; a blank or a dot multiplies too.
``sqrt``, ``rt``, ``root`` and the root sign take the factor that follows them; ``^``, ``**``, raised digits
or a digit right behind a name (``s2``, ``s-2``) are exponents; ``per`` divides. Nothing else is evaluated.

What has two readings is refused, and both are spelled out: a product after a division without a sign
(``deg/s g``), division by an angle or a length and then by a time (``mV/deg/s``), ``ms-2``, ``m/s-2``.
"""

from __future__ import annotations

import difflib
import math
import re
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from typing import NoReturn

from .atoms import REFUSED, kind_of, meaning, spellings
from .exponent import read_exponent
from .powers import NONE, Powers, product, quotient, raised
from .spelling import spell
from .tokens import EXAMPLES, Cursor, Token, cursor

DEEPEST = 8  # brackets inside brackets
_REMEMBERED = 4096  # texts

_ROOT = re.compile(r"(?:sqrt|root|rt)_?(.*)", re.IGNORECASE)
_HALF = Fraction(1, 2)


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


def read_quantity(text: str) -> tuple[float, Powers]:
    """Return the number and the unit that a text means.

    Raises
    ------
    DataError
        With code ``unknown_quantity``, if it does not begin with a number, its unit is not known, it has
        two readings, or its value is not finite.
    """
    at = cursor(text, "unknown_quantity")
    sign = -1.0 if at.peek().text == "-" else 1.0
    if at.peek().text in {"+", "-"}:
        at.tokens.pop(0)
    if at.peek().kind != "number":
        at.refuse("it does not begin with a number")
    factor = _read(at)
    if not math.isfinite(factor.value):
        at.refuse("its value is not finite")
    return sign * factor.value, factor.unit


def _read(at: Cursor) -> _Factor:
    try:
        factor = _chain(at, 0)
        spell(factor.unit)
    except ValueError as error:  # an exponent, or the length
        at.refuse(str(error))
    if at.peek().text:
        at.refuse(f"{at.peek().text!r} does not belong there")
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
            total, last_divisor, divided = _divide(at, total, divisor), divisor, True
        elif _multiplies(at, divided):
            total, last_divisor = total * _operand(at, depth), _Factor()
        else:
            return total


def _divide(at: Cursor, a: _Factor, b: _Factor) -> _Factor:
    if b.value == 0.0:
        at.refuse("it divides by zero")
    return _Factor(a.value / b.value, quotient(a.unit, b.unit))


def _check_divisors(at: Cursor, last: _Factor, divisor: _Factor) -> None:
    """Refuse ``x/deg/s``, ``x/m/s^2`` and ``x/s-2``."""
    if divisor.inverse:
        at.refuse("division by a negative exponent can be meant either way", "Write m/s^2 or m s-2")
    if not (last.name and divisor.name):
        return
    first, second = (kind_of(factor.unit[0][0]) for factor in (last, divisor))
    if first in {"angle", "length"} and second == "time":
        head = "".join(token.text for token in at.tokens).split("/")[0].lstrip("(")
        a, b = last.name, divisor.name
        at.refuse(
            f"it can be meant as {head}/({a}/{b}) or as {head}/({a}*{b})",
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
    _check_juxtaposed(at, follows, divided)
    if token.text == ".":
        at.take()
    return True


def _check_juxtaposed(at: Cursor, follows: Token, divided: bool) -> None:
    """Refuse what is not clearly a product, where no ``*`` stands before it."""
    last = at.peek(-1)
    if follows.kind == "number":
        one_over = at.with_number and at.at == 1 and follows.text == "1" and at.peek(1).text == "/"
        if not one_over:  # "5 1/s" is five per second
            at.refuse(f"the number {follows.text} follows {last.text!r} without a sign between")
    elif follows.text == "(" and last.kind == "name" and at.peek().text != ".":
        at.refuse(f"a bracket follows {last.text!r} without a sign between", "Write * or / before the bracket")
    if divided:
        at.refuse(
            f"{follows.text!r} after a division can be meant as a factor or as a divisor",
            "Put brackets around what is divided by, or write * or / before it",
        )


def _operand(at: Cursor, depth: int) -> _Factor:
    """Read a number, a name, a root or a bracket, with its exponent."""
    token = at.take()
    if token.kind == "number":
        return _raise(at, _Factor(_number(at, token)))
    if token.text == "(":
        inner = _chain(at, depth + 1)
        at.expect(")")
        return _raise(at, _Factor(inner.value, inner.unit))
    if token.kind != "name":
        at.refuse(f"a unit is missing before {token.text!r}" if token.text else "a unit is missing at the end")
    root = _ROOT.fullmatch(token.text)
    if root and meaning(token.text) is None:
        return _root(at, depth, root[1])
    return _name(at, token)


def _number(at: Cursor, token: Token) -> float:
    if not at.with_number and token.text != "1":
        at.refuse(f"there is a number in it, {token.text}")
    return float(token.text)


def _root(at: Cursor, depth: int, rest: str) -> _Factor:
    """Read what a root is taken of; ``rest`` is what was written together with the sign."""
    if depth > DEEPEST:
        at.refuse(f"more than {DEEPEST} brackets or roots inside each other")
    if rest:
        at.put_back(rest)
    inner = _operand(at, depth + 1)
    return _Factor(math.sqrt(inner.value), raised(inner.unit, _HALF))


def _name(at: Cursor, token: Token) -> _Factor:
    text, follows = token.text, at.peek()
    if follows.kind == "number" and follows.touches and meaning(text + follows.text) is not None:
        text += at.take().text
    unit = meaning(text)
    if unit is None:
        _unknown(at, text)
    factor = _raise(at, _Factor(1.0, unit), text)
    if len(factor.unit) != 1:
        return factor
    return _Factor(1.0, factor.unit, spell(factor.unit), factor.unit[0][1] < 0)


def _unknown(at: Cursor, text: str) -> NoReturn:
    if text in REFUSED:
        at.refuse(*REFUSED[text])
    near = [known for known in spellings() if known.lower() == text.lower()]
    near += [known for known in difflib.get_close_matches(text, spellings(), n=5) if known not in near]
    hint = f"Nearest known: {', '.join(near)}. " if near else ""
    at.refuse(f"{text!r} is not known", hint + EXAMPLES[at.code])


def _raise(at: Cursor, factor: _Factor, name: str = "") -> _Factor:
    """Apply the exponent that follows, if one does."""
    exponent = read_exponent(at, named=bool(name))
    if exponent is None:
        return factor
    if name == "ms" and exponent < 0:
        at.refuse("ms can be meant as milliseconds or as m and s", "Write m/s, m/s^2, or 1/ms, 1/ms^2")
    try:
        return _Factor(factor.value ** float(exponent), raised(factor.unit, exponent))
    except ArithmeticError:
        at.refuse("its value is not finite")

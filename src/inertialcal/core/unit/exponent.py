"""Reading of exponents: ``^2``, ``**2``, ``^-0.5``, ``^(1/2)``; behind a name also ``2`` and ``-2``."""

from __future__ import annotations

import re
from fractions import Fraction

from .tokens import Cursor

_NUMBER = re.compile(r"[0-9]{1,2}(\.[0-9]{1,2})?|\.[0-9]{1,2}")  # no size that could cost time or memory
_DIGIT = re.compile(r"[1-9]")


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
        return _in_brackets(cursor) if cursor.peek().text == "(" else _signed(cursor, _NUMBER)
    signed = token.text in {"+", "-"} and cursor.peek(1).touches
    if named and token.touches and (token.kind == "number" or signed):
        return _signed(cursor, _DIGIT)
    return None


def _in_brackets(cursor: Cursor) -> Fraction:
    cursor.expect("(")
    value = _signed(cursor, _NUMBER)
    if cursor.peek().text == "/":
        cursor.take()
        below = _signed(cursor, _NUMBER)
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
        cursor.refuse(f"{token.text!r} is no exponent", "Exponents are written like ^2, ^-0.5 or ^(1/2)")
    return sign * Fraction(token.text)

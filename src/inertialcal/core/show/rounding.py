"""Figures for people, by one rule: an uncertainty has two significant digits, and its value ends where it ends.

The ends of an interval stand at the same decimal place; at one more where a place fewer would make them alike, or an
end zero that is not. Degrees of freedom have three digits, from 1000 on those of a whole number (JCGM 100:2008, 7.2.6).

Inside ``digits_shown`` (``--digits``) the figures of results stand with as many digits as said: tables of results take
their cells from `settled`, `settled_ends`, `settled_u`, `settled_number` and `near`, and nothing else does, so that
texts stay as they are.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from decimal import ROUND_FLOOR, Context, Decimal
from typing import NamedTuple

from ..errors import UsageError

DIGITS = 2  # significant digits of an uncertainty
PLAIN = 6  # significant digits of a figure without uncertainty
SMALLEST, LARGEST = -4, 6  # decades written without an exponent
MOST = 17  # significant digits that a double has
MANY = 1e5  # degrees of freedom that make no difference to infinitely many
FULL = "full"
_EXACT = Context(prec=1100)  # digits that any double needs
_digits: ContextVar[int | None] = ContextVar("digits", default=None)


@contextmanager
def digits_shown(said: str | None) -> Iterator[None]:
    """Show the figures of results inside with so many significant digits: ``"9"``, or ``"full"``; None as usual.

    Raises
    ------
    UsageError
        ``wrong_value``.
    """
    if said is not None and said != FULL and not (said.isdecimal() and 1 <= int(said) <= MOST):
        do = f"Give 1 to {MOST} significant digits, or {FULL}"
        raise UsageError(f"--digits {said}", do=do, code="wrong_value")
    token = _digits.set(None if said is None else MOST + 1 if said == FULL else int(said))
    try:
        yield
    finally:
        _digits.reset(token)


def settled(value: float | None, u: float | None) -> str:
    """Return a figure of a result and its uncertainty: as `with_uncertainty`, or with the digits that were asked for.

    Examples
    --------
    >>> with digits_shown("full"):
    ...     settled(1.001247, 0.000418)
    '1.001247 ± 0.000418'
    """
    if _digits.get() is None or value is None or not math.isfinite(value):
        return with_uncertainty(value, u)
    if u is None or not math.isfinite(u) or u <= 0.0:
        return settled_number(value)
    return f"{settled_number(value)} ± {settled_number(u)}"


def settled_number(value: float | None, digits: int = PLAIN) -> str:
    """Return a figure of a result without its uncertainty: as `number`, or with the digits that were asked for."""
    asked = _digits.get()
    if asked is None or value is None or not math.isfinite(value):
        return number(value, digits)
    return repr(float(value)).removesuffix(".0") if asked > MOST else f"{value:.{asked}g}"


class Place(NamedTuple):
    """Where figures end."""

    last: int  # Decade of the last digit
    decade: int | None  # Taken out as a power of ten; None: written without


def place(value: float, u: float) -> Place:
    """Return where a value with a standard uncertainty ends: two significant digits of it."""
    last = _decade(float(f"{u:.{DIGITS - 1}e}")) - DIGITS + 1
    decade = max(_decade(float(_at(value, last))), last + DIGITS - 1)
    return Place(last, None if SMALLEST <= decade < LARGEST and last <= 0 else decade)


def _at(value: float, last: int, decade: int = 0) -> str:
    """Return a value rounded at a decade, half to even, over a power of ten; zero has no sign."""
    found = _EXACT.quantize(Decimal(value), Decimal(1).scaleb(last, _EXACT)).scaleb(-decade, _EXACT)
    return f"{abs(found) if found.is_zero() else found:f}"


def with_uncertainty(value: float | None, u: float | None) -> str:
    """Return ``"1.00125 ± 0.00042"``, or the value alone with six digits where it has no uncertainty.

    Examples
    --------
    >>> with_uncertainty(1.001247, 0.000418)
    '1.00125 ± 0.00042'
    >>> with_uncertainty(-3.2e-7, 4.1e-8)
    '(-3.20 ± 0.41)e-07'
    >>> with_uncertainty(None, None)
    '-'
    """
    if value is None or not math.isfinite(value):
        return "-"
    if u is None or not math.isfinite(u) or u <= 0.0:
        return f"{value:.{PLAIN}g}"
    last, decade = place(value, u)
    shown, shown_u = (_at(one, last, decade or 0) for one in (value, u))
    return f"{shown} ± {shown_u}" if decade is None else f"({shown} ± {shown_u})e{decade:+03d}"


def rounded_down(u: float) -> float:
    """Return the largest uncertainty of two significant digits that is no larger.

    Examples
    --------
    >>> rounded_down(0.0198)
    0.019
    """
    return float(Context(prec=DIGITS, rounding=ROUND_FLOOR).create_decimal(Decimal(u)))


def ends(value: float | None, u: float | None, lo: float | None, hi: float | None) -> str:
    """Return the ends of the interval of a value, at its decimal place; of one without ``u``, by a quarter of it.

    Examples
    --------
    >>> ends(-1255.991791, 0.00096, -1255.993672, -1255.989909)
    '-1255.99367 .. -1255.98991'
    >>> ends(0.51, 0.32, 0.003, 1.1)
    '0.003 .. 1.100'
    """
    known = [one for one in (lo, hi) if one is not None and math.isfinite(one)]
    if len(known) == 2 and not (u is not None and 0.0 < u < math.inf):
        u = (known[1] - known[0]) / 4.0
    if not known or u is None or not 0.0 < u < math.inf:
        return " .. ".join(number(one) for one in (lo, hi))
    middle = value if value is not None and math.isfinite(value) else max(known, key=abs)
    last, decade = place(middle, u)
    shown = [_at(one, last) for one in known]
    if len(set(shown)) < len(known) or any(one and not float(text) for one, text in zip(known, shown, strict=True)):
        last -= 1
    texts = ["-" if one not in known else _at(one, last, decade or 0) for one in (lo, hi)]
    found = " .. ".join(texts)
    return found if decade is None else f"({found})e{decade:+03d}"


def uncertainty(u: float | None) -> str:
    """Return a standard uncertainty that stands without its value.

    Examples
    --------
    >>> uncertainty(0.1), uncertainty(0.012345), uncertainty(2.04e-7)
    ('0.10', '0.012', '2.0e-07')
    """
    if u is None or not math.isfinite(u) or u <= 0.0:
        return number(u)
    last, decade = place(u, u)
    return _at(u, last) if decade is None else f"{_at(u, last, decade)}e{decade:+03d}"


def settled_u(u: float | None) -> str:
    """Return a standard uncertainty of a result: as `uncertainty`, or with the digits that were asked for."""
    return uncertainty(u) if _digits.get() is None else settled_number(u)


def settled_ends(value: float | None, u: float | None, lo: float | None, hi: float | None) -> str:
    """Return the ends of the interval of a result: as `ends`, or with the digits that were asked for."""
    if _digits.get() is None:
        return ends(value, u, lo, hi)
    return " .. ".join(settled_number(one) for one in (lo, hi))


def near(value: float | None, u: float | None) -> str:
    """Return a value with one digit more than an uncertainty has, which is not its own; with six where there is none.

    Examples
    --------
    >>> near(979.0512, 0.724)
    '979.051'
    """
    if _digits.get() is not None:
        return settled(value, None)
    if value is None or u is None or not (math.isfinite(u) and math.isfinite(value) and u > 0.0):
        return with_uncertainty(value, None)
    last, decade = place(value, u)
    return _at(value, last - 1) if decade is None else f"{_at(value, last - 1, decade)}e{decade:+03d}"


def dof(value: float | None) -> str:
    """Return degrees of freedom; None, and a number beyond any difference, is ``"inf"``.

    Examples
    --------
    >>> dof(4.2849), dof(49912.0), dof(None)
    ('4.28', '49912', 'inf')
    """
    if value is None or not value <= MANY:
        return "inf"
    return f"{value:.0f}" if value > 999.0 else f"{value:.3g}"


def number(value: float | None, digits: int = PLAIN) -> str:
    """Return a figure with significant digits, or ``"-"`` where it is absent."""
    return "-" if value is None or not math.isfinite(value) else f"{value:.{digits}g}"


def items(n: int, noun: str) -> str:
    """Return a count with its noun: ``items(1, "cube")`` is ``"1 cube"``."""
    return f"{n} {noun}{'' if n == 1 else 's'}"


def freedom(dof: float, digits: int = PLAIN) -> str:
    """Return degrees of freedom in words.

    Examples
    --------
    >>> freedom(1), freedom(2.5)
    ('1 degree of freedom', '2.5 degrees of freedom')
    """
    text = number(dof, digits)
    return f"{text} degree{'' if text == '1' else 's'} of freedom"


def _decade(value: float) -> int:
    return math.floor(math.log10(abs(value))) if value else -300

"""Figures for people: a value rounded to its uncertainty, two digits of it (JCGM 100, 7.2.6).

Inside ``digits_shown`` (``--digits``) the figures of results stand with as many digits as said: tables of results take
their cells from `settled`, `settled_number` and `near`, and nothing else does, so that texts stay as they are.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar

from ..errors import UsageError

DIGITS = 2  # significant digits of an uncertainty
PLAIN = 6  # significant digits of a figure without uncertainty
SMALLEST, LARGEST = -4, 6  # decades written without an exponent
MOST = 17  # significant digits that a double has
FULL = "full"
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
    decade = max(_decade(value), _decade(u))
    last = _decade(float(f"{u:.{DIGITS - 1}e}")) - DIGITS + 1  # decade of the last digit shown
    if SMALLEST <= decade < LARGEST and last <= 0:
        return f"{value:.{-last}f} ± {u:.{-last}f}"
    places = max(decade - last, 0)
    scale = 10.0**-decade
    return f"({value * scale:.{places}f} ± {u * scale:.{places}f})e{decade:+03d}"


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
    last = _decade(float(f"{u:.{DIGITS - 1}e}")) - DIGITS
    if SMALLEST <= max(_decade(value), last) < LARGEST and last <= 0:
        return f"{value:.{-last}f}"
    return f"{value:.{max(_decade(value) - last, 0)}e}"


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

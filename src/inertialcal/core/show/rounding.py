"""Figures for people: a value rounded to its uncertainty, two digits of it (JCGM 100, 7.2.6)."""

from __future__ import annotations

import math

DIGITS = 2  # significant digits of an uncertainty
PLAIN = 6  # significant digits of a figure without uncertainty
SMALLEST, LARGEST = -4, 6  # decades written without an exponent


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
    if value is None or u is None or not (math.isfinite(u) and math.isfinite(value) and u > 0.0):
        return with_uncertainty(value, None)
    last = _decade(float(f"{u:.{DIGITS - 1}e}")) - DIGITS
    if SMALLEST <= max(_decade(value), last) < LARGEST and last <= 0:
        return f"{value:.{-last}f}"
    return f"{value:.{max(_decade(value) - last, 0)}e}"


def number(value: float | None, digits: int = PLAIN) -> str:
    """Return a figure with significant digits, or ``"-"`` where it is absent."""
    return "-" if value is None or not math.isfinite(value) else f"{value:.{digits}g}"


def _decade(value: float) -> int:
    return math.floor(math.log10(abs(value))) if value else -300

"""What a sensor can read at all: limits by kind of unit, and by the range that is stated for it.

A reading beyond them is none: it is counted, and the figures are made without it. Where more than a tenth of a channel
is impossible, its unit or its scale is wrong, and the likely cause is named.

The limits are far outside any test bench. They are there for wrong units, codes of missing values and raw codes of a
converter, not for weak sensors; what lies inside them may be wrong all the same.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...core.batches import batches, changed, count, every, extremes, kept, zeros
from ...core.batches.summaries import median, moments
from ...core.remarks import Remark, Severity
from ...core.units import convert, factor, kind
from ..time.samples import Flags

MOST = 0.1  # of a channel: where more of it is impossible, its unit or scale is wrong
OVERRANGE = 2.0  # times its stated range, from the middle: no sensor reads so far beyond
STANDARD_GRAVITY = 9.80665  # [m/s^2]


@dataclass(frozen=True)
class Limit:
    """What a kind of channel can read, SI."""

    kind: str  # Of unit, as ``core.units.kind`` has it
    low: float
    high: float
    unit: str  # SI
    why_low: str  # Why nothing reads less ...
    why_high: str  # ... and nothing more


_G, _DEG = STANDARD_GRAVITY, np.pi / 180.0

LIMITS = {
    one.kind: one
    for one in (
        Limit("temperature", -273.15, 250.0, "degC", "absolute zero", "electronics for boreholes end at 225 degC"),
        Limit(
            "acceleration", -2.5e5 * _G, 2.5e5 * _G, "m/s^2",
            "shock sensors end at 200,000 g", "shock sensors end at 200,000 g",
        ),
        Limit(
            "angular_rate", -1e5 * _DEG, 1e5 * _DEG, "rad/s",
            "the fastest gyros end at 50,000 deg/s", "the fastest gyros end at 50,000 deg/s",
        ),
        Limit("pressure", -200.0, 1e9, "Pa", "absolute pressure is positive", "deep boreholes: 0.2 GPa"),
        Limit("voltage", -1e3, 1e3, "V", "no converter of a sensor takes 1 kV", "no converter of a sensor takes 1 kV"),
        Limit("frequency", -1e12, 1e12, "1/s", "no counter counts so fast", "no counter counts so fast"),  # less a zero
    )
}  # fmt: skip

HEAD_FULL_SCALE = 1.25 * _G  # [m/s^2]: microgravity heads of the archive, at gain 1
HEAD_RMS = 5e-3 * _G  # [m/s^2]: root sum square of the vibration limits of the space station, .01 to 300 Hz: 4.6 mg
SHAKEN = 10.0  # times that: nobody shakes a laboratory so, and the scale is wrong
ARCHIVE = "pad"  # reader of archive records

CODES_OF_MISSING = (-9999.0, -999.0, -99.0, 999.0, 9999.0, -32768.0, 32767.0, 65535.0)
NEAR = 1e-3  # relative distance from such a code


@dataclass(frozen=True, eq=False)
class Impossible:
    """Samples of a channel that cannot be readings, shape (n,), and what to say of them."""

    flags: Flags
    remarks: tuple[Remark, ...] = ()


def impossible(
    values: NDArray[Any],
    unit: str | None,
    name: str,
    place: Callable[[int], str],
    input_range: tuple[float, float] | None = None,
    archived: bool = False,
    shown: str = "",
) -> Impossible:
    """Return which samples of a channel cannot be readings.

    Parameters
    ----------
    values : ndarray, shape (n,)
        Samples, NaN where one is missing.
    unit : str or None
        Of them; where nobody said it, nothing is impossible.
    name : str
        Of the channel, for remarks.
    place : callable
        Index of a sample -> ``"file:row"``.
    input_range : (float, float), optional
        That is stated for the sensor, SI.
    archived : bool
        Whether it is an acceleration of the microgravity archive.
    shown : str
        Unit that people speak; by default that of the samples.

    Returns
    -------
    Impossible
        With a remark ``impossible_temperature``, ..., ``beyond_range`` or ``implausible_acceleration``.

    Examples
    --------
    >>> temperature = np.full(20, 21.5)
    >>> temperature[7] = -400.0
    >>> found = impossible(temperature, "degC", "'temperature'", "row {}".format)
    >>> found.remarks[0].code, found.remarks[0].where, found.remarks[0].what
    ('impossible_temperature', 'row 7', "'temperature': -400 degC is impossible (absolute zero: -273.15 degC)")
    """
    none = Impossible(zeros(len(values), bool))
    known = LIMITS.get(kind(unit)) if unit else None
    if known is None or values.dtype.kind not in "iuf" or not len(values):
        return none
    assert unit is not None  # noqa: S101 - else it has no limit
    head = archived and known.kind == "acceleration"
    spoken = shown if shown and kind(shown) == known.kind else unit

    def said(value: float, of: str = unit) -> str:
        return f"{float(convert(value, of, spoken)):.6g} {spoken}"

    def remark(code: str, flags: Flags, why: str) -> Remark:
        first, many = _first(flags), count(flags, lambda part: part)
        grave: Severity = "error" if many > MOST * len(values) else "warning"
        cause = likely_cause(values, flags, unit)
        what = f"{name}: {said(values[first])} {why}" + (f"; {cause}" if cause else "")
        do = "Check the unit and the scale of this column" if grave == "error" else "Look at the logger"
        return Remark(code, grave, what, place(first), many, do, subject=name, index=first)

    ends = (-HEAD_FULL_SCALE, HEAD_FULL_SCALE) if head else (known.low, known.high)
    flags = _outside(values, ends, known.unit, unit)
    if flags is not None:
        below = bool(values[_first(flags)] < float(convert(ends[0], known.unit, unit)))
        why = "the range of microgravity heads" if head else known.why_low if below else known.why_high
        why = f"is impossible ({why}: {said(ends[0] if below else ends[1], known.unit)})"
        return Impossible(flags, (remark(f"impossible_{known.kind}", flags, why),))
    if input_range is not None:
        middle, half = 0.5 * (input_range[0] + input_range[1]), 0.5 * (input_range[1] - input_range[0])
        flags = _outside(values, (middle - OVERRANGE * half, middle + OVERRANGE * half), known.unit, unit)
        if flags is not None:
            low, high = (said(end, known.unit) for end in input_range)
            return Impossible(
                flags, (remark("beyond_range", flags, f"is far beyond the stated range, {low} to {high}"),)
            )
    rms = _rms(values) if head else 0.0
    if rms > float(convert(HEAD_RMS, known.unit, unit)):
        what = (
            f"{name}: vibration of {said(rms)} rms; the limits of the space station add up to "
            f"{said(HEAD_RMS, known.unit)}: a scale is wrong, or something shook the head"
        )
        do = "Check the unit and the scale of the data against the archive"
        severity: Severity = "error" if rms > SHAKEN * float(convert(HEAD_RMS, known.unit, unit)) else "warning"
        return replace(
            none, remarks=(Remark("implausible_acceleration", severity, what, place(0), do=do, subject=name),)
        )
    return none


@lru_cache(maxsize=256)
def _in_unit(ends: tuple[float, float], given: str, unit: str) -> tuple[float, float]:
    low, high = (float(one) for one in convert(list(ends), given, unit))
    return low, high


def _outside(values: NDArray[Any], ends: tuple[float, float], given: str, unit: str) -> Flags | None:
    """Return which samples lie outside; None where none does."""
    low, high = _in_unit(ends, given, unit)
    least, largest = extremes(values)
    if not (least < low or largest > high):  # also where nothing is there
        return None
    with np.errstate(invalid="ignore"):
        flags = changed(values, lambda part: (part < low) | (part > high), bool)
    return flags if _any(flags) else None


def _any(flags: Flags) -> bool:
    return not every(flags, lambda part: not part.any())


def _first(flags: Flags) -> int:
    return next(first + int(np.argmax(flags[first:stop])) for first, stop in batches(flags) if flags[first:stop].any())


def _rms(values: NDArray[Any]) -> float:
    """Return the standard deviation (n) of the samples that are there."""
    found = moments(values)
    return float(np.sqrt(found.squares / found.count)) if found.count else 0.0


def likely_cause(values: NDArray[Any], flags: Flags, unit: str) -> str:
    """Return what most probably made samples impossible; empty where nothing speaks for it."""
    bad = kept(values, flags)
    middle = median(bad)
    if any(abs(middle - code) <= NEAR * abs(code) for code in CODES_OF_MISSING) and every(
        bad, lambda x: np.all(x == bad[0])
    ):
        return f"{middle:g} is a code for a missing value"
    if len(bad) <= MOST * len(values):
        return ""
    if kind(unit) == "temperature":
        if 200.0 < middle < 525.0:
            return "likely kelvin, read as degC"
        if 10.0 <= abs(middle) / 1e3 < 150.0:
            return "likely thousandths of a degree"
    if abs(middle) > 2**8 and every(bad, lambda x: np.all(x == np.rint(x))):
        return "likely raw codes of a converter"
    return "likely a wrong unit"


def limits_table() -> list[tuple[str, str, str, str]]:
    """Return the limits as people read them: kind, least, largest, why."""
    shown = {"acceleration": "g", "angular_rate": "deg/s"}
    rows = []
    for one in LIMITS.values():
        unit = shown.get(one.kind, one.unit)
        scale = factor(one.unit, unit) if unit != one.unit else 1.0
        why = one.why_high if one.why_low == one.why_high else f"{one.why_low}; {one.why_high}"
        low, high = (f"{scale * end:.6g} {unit}" for end in (one.low, one.high))
        rows.append((one.kind.replace("_", " "), low, high, why))
    return rows

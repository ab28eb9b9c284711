"""Rows of a run: levels, deviations from the profile, time at level, kurtosis; and what was found in a sentence."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ...core.key import At, Key, Reason
from ...core.results import Interval, Row, WrittenRow
from ...core.show.rows import Cited, Sentence, estimated
from ...statistics.intervals import t_interval
from .plan import CONTROL, DEVIATION, DURATION, KURTOSIS, LEVEL, LEVEL_DEVIATION, RATE_LEVEL

if TYPE_CHECKING:
    from .reduction import Power, Result

P = 0.95
LINES = "frequency"  # what a place of a row is


def power_keys(result: Result) -> dict[Key, Power]:
    """Return the powers by the key of their row: the control together, each of several control channels, responses."""
    found = {Key(LEVEL, CONTROL): result.control}
    several = len(result.readings.controls) > 1
    for one in result.channels:
        if one.name in result.readings.axes or several:
            found[Key(LEVEL if one.power.unit == "m/s^2" else RATE_LEVEL, one.name)] = one.power
    return found


def rows(result: Result) -> list[Row]:
    """Return the rows, SI."""
    found = []
    for key, one in power_keys(result).items():
        shared = {one.influence: one.rms * one.u} if one.u else {}
        found.append(Row(key, one.rms, one.u_rms, one.unit, one.dof_rms, one.interval(P), shared=shared))
    return [*found, _level_deviation(result), *_deviations(result), _duration(result), *_kurtosis(result)]


def _level_deviation(result: Result) -> Row:
    """Return the overall level over that of the profile, less 1."""
    target, one = result.target.rms(*result.band), result.control
    value, u = one.rms / target - 1.0, one.u_rms / target
    interval = one.interval(P)
    assert interval.lo is not None and interval.hi is not None  # noqa: S101, PT018 - two-sided
    ends = Interval(interval.lo / target - 1.0, interval.hi / target - 1.0, P)
    shared = {one.influence: one.rms / target * one.u} if one.u else {}
    return Row(Key(LEVEL_DEVIATION, CONTROL), value, u, "1", one.dof_rms, ends, shared=shared)


def _deviations(result: Result) -> list[Row]:
    """Return the highest and the lowest deviation of a line; their intervals hold for all lines together."""
    one = result.deviation
    low, high = one.interval(one.together(P))
    places = {"highest": int(np.argmax(one.value)), "lowest": int(np.argmin(one.value))}
    count = len(one)
    return [
        Row(Key(DEVIATION, CONTROL, at=At(LINES, float(one.frequency[i]), "Hz")), float(one.value[i]),
            float(one.u_value[i]), "dB", None, Interval(float(low[i]), float(high[i]), P),
            reason=Reason("simultaneous", f"{word} of {count} lines; the interval holds for all of them together"))
        for word, i in places.items()
    ]  # fmt: skip


def _duration(result: Result) -> Row:
    value, u = result.levels.duration, result.levels.u_duration
    return Row(Key(DURATION, CONTROL), value, u, "s", None, t_interval(value, u, np.inf, P))


def _kurtosis(result: Result) -> list[Row]:
    found = []
    several = len(result.readings.controls) > 1
    for one in result.channels:
        name = one.name if several or one.name in result.readings.axes else CONTROL
        value, u = one.shape.kurtosis, one.shape.u_kurtosis
        found.append(Row(Key(KURTOSIS, name), value, u, "1", None, t_interval(value, u, np.inf, P)))
    return found


def finding(rows: Sequence[WrittenRow]) -> Sentence:
    """Say the level, how far it is from the profile, and the time."""
    said: Sentence = ()
    for quantity, before in ((LEVEL, ""), (LEVEL_DEVIATION, ", "), (DURATION, " for ")):
        row = next((one for one in estimated(rows, quantity) if one["axis"] == CONTROL), None)
        if row is not None:
            said = (*said, before if said else "", Cited(row))
            said = (*said, " from the profile") if quantity == LEVEL_DEVIATION else said
    return said or ("No level could be estimated",)


__all__ = ["finding", "power_keys", "rows"]

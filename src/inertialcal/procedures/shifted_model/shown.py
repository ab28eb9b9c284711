"""What a run prints beside its figures: each flight with its shifts from the old model and from the new one."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from ...core.recording import SECOND
from ...core.show.rounding import items, number, uncertainty, with_uncertainty
from ...core.show.tables import Table
from ...core.times import instant_text
from ...core.units import factor
from .curves import YEAR
from .later import predicted

if TYPE_CHECKING:
    from .model import AxisShift
    from .reduction import Result

HEAD = ("flight", "date", "axis", "degC", "off ground", "off new", "")


def summary(result: Result, unit: str) -> str:
    """Return how far the flights are off the old model and off the new one, in one line."""
    per = factor("m/s^2", unit)
    words = []
    for axis, one in result.shifts.items():
        left = one.fit.shift - one.fit.design @ one.fit.coefficients
        old, new = (uncertainty(float(np.sqrt(np.mean(values**2))) * per) for values in (one.fit.shift, left))
        words.append(f"{axis} by {old} {unit} rms from the ground model and by {new} {unit} from the new model")
    years = (max(one.time for one in result.readings.flips) - result.readings.flips[0].time) / SECOND / YEAR
    flights = f"{items(result.readings.runs, 'flight')} over {number(years, 3)} years, "
    return f"{flights}{items(len(result.readings), 'flip')} differ in {'; in '.join(words)}"


def flights_table(result: Result, unit: str = "ug") -> Table:
    """Return the flights with what they measured less what both models say, in a unit of acceleration."""
    per = factor("m/s^2", unit)
    rows: list[tuple[str, ...]] = []
    for axis, one in result.shifts.items():
        rows += _rows(axis, one, per)
    for each in predicted(result, result.later):
        old = with_uncertainty((each.measured - each.ground) * per, each.u_flips * per)
        known = math.isfinite(each.u)
        new = with_uncertainty(each.error * per, each.u * per) if known else number(each.error * per, 4)
        word = ("as predicted" if each.inside else "not as predicted") if known else "predicted"
        rows.append((each.flight, _day(each.time), each.axis, number(each.temperature, 4), old, new, word))
    return Table(HEAD, rows, f"Flights [{unit}]", (3, 4, 5))


def _rows(axis: str, one: AxisShift, per: float) -> list[tuple[str, ...]]:
    left = one.fit.shift - one.fit.design @ one.fit.coefficients
    u = np.array([flip.u * one.fit.widened for flip in one.flips])
    found: list[tuple[str, ...]] = []
    for at, name in enumerate(dict.fromkeys(flip.flight for flip in one.flips)):
        own = np.flatnonzero(one.fit.group == at)
        weights = 1.0 / u[own] ** 2
        total = float(weights.sum())
        temperature = float(np.mean([one.flips[i].temperature for i in own]))
        old, new = (float(weights @ values[own]) / total * per for values in (one.fit.shift, left))
        size = per / total**0.5
        found.append((name, _day(one.flips[own[0]].time), axis, number(temperature, 4), with_uncertainty(old, size),
                      with_uncertainty(new, size), ""))  # fmt: skip
    return found


def _day(time: int) -> str:
    return instant_text(time)[:10]

"""Linearity error: largest deviation of the mean reading at a rate from the best straight line.

In percent of the largest rate that was used (IEEE 528, linearity error; 1431, 12.9). The largest of k deviations
is large by chance alone, so it counts as seen only where it exceeds the simultaneous (Sidak) bound of k means;
otherwise that bound on top of the largest deviation is published as an upper limit.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ....core.errors import DataError, Problem
from ....core.key import Key, Reason
from ....core.results import Interval, Row, not_estimated
from ....statistics.intervals import band_factor, coverage_factor
from ..plan import Plan
from ..readings import Readings
from .regression import Line, dwell_variance


@dataclass(frozen=True)
class Deviation:
    """Largest deviation from the straight line: at which rate [rad/s], how much and how sure [rad/s]."""

    rate: float
    size: float
    u: float
    dof: float
    rates: int
    full_scale: float


def largest_deviation(straight: Line) -> Deviation | None:
    """Find the largest deviation of a rate's mean from the line; None where scatter or rates are too few."""
    readings = straight.readings
    own = readings.axis == straight.sensor
    rates = np.unique(readings.applied[own])
    variance = dwell_variance(straight.levels, len(readings) / readings.runs if readings.runs else 1.0)
    if variance is None or len(rates) < 3 or variance[1] < 1.0:
        return None
    means, sigmas = [], []
    for rate in rates:
        at = own & (readings.applied == rate)
        here = readings.take(at)
        count = here.runs if here.runs else len(here)
        means.append(float(np.mean(straight.fit.residuals[at])))
        leverage = float(np.mean(straight.fit.leverage[at]))
        sigmas.append(float(np.sqrt(variance[0] * max(1.0 / count - leverage, 0.0) + np.finfo(float).tiny)))
    worst = int(np.argmax(np.abs(means)))
    full_scale = float(np.max(np.abs(rates)))
    return Deviation(float(rates[worst]), abs(means[worst]), sigmas[worst], variance[1], len(rates), full_scale)


def linearity_row(straight: Line | None, sensor: str) -> Row:
    """Return the linearity error in percent of the largest rate used."""
    found = None if straight is None else largest_deviation(straight)
    key = Key("linearity_error", sensor)
    if found is None:
        reason = "needs three rates or more about the sensor's own axis, and repeated dwells"
        return not_estimated(key, "%", Reason("few_rates", reason))
    percent = 100.0 / found.full_scale
    bound = band_factor(found.rates, found.dof, 0.95) * found.u
    if found.size <= bound:
        value = (found.size + bound) * percent
        reason = f"no deviation stands out among {found.rates} rates: the largest plus its simultaneous bound"
        return Row(
            key,
            value,
            found.u * percent,
            "%",
            found.dof,
            Interval(0.0, value),
            "upper_limit",
            Reason("not_seen", reason),
        )
    half = coverage_factor(found.dof, 0.95) * found.u
    interval = Interval((found.size - half) * percent, (found.size + half) * percent)
    return Row(key, found.size * percent, found.u * percent, "%", found.dof, interval)


CLEAR = 0.5  # a matrix entry of this size is no misalignment


def check_agreement(plan: Plan, readings: Readings, lines: dict[str, Line]) -> None:
    """Refuse readings that do not follow the table.

    Raises
    ------
    DataError
        With one problem for each axis: inverted sense (``inverted``), another axis answers (``axes_mixed``), or
        the rates disagree (``rate_disagrees``).
    """
    problems = []
    for axis in np.unique(readings.axis):
        entries = {s: one.coefficient(f"M_{s}{axis}") for s, one in lines.items() if axis in one.axes}
        problem = _problem(plan, str(axis), entries, _doubt(lines, str(axis)))
        if problem is not None:
            problems.append(problem)
    if problems:
        raise DataError(problems)


def _doubt(lines: dict[str, Line], axis: str) -> float:
    """Return two standard errors of the sensor's own entry: low rates alone tell little of it."""
    one = lines.get(axis)
    if one is None or one.covariance is None or axis not in one.axes:
        return 0.0
    at = one.names.index(f"M_{axis}{axis}")
    return 2.0 * float(np.sqrt(one.covariance[at, at]))


def _problem(plan: Plan, axis: str, entries: dict[str, float], doubt: float) -> Problem | None:
    own = entries.get(axis)
    if own is None or abs(own - 1.0) <= plan.agreement + doubt:
        return None
    others = [s for s, entry in entries.items() if s != axis and abs(abs(entry) - 1.0) <= plan.agreement]
    if abs(own) < CLEAR and others:
        seen = f"{entries[others[0]]:+.3f} of the rate; {axis}: {own:+.3f}"
        what = f"{axis} is turned, but the {others[0]} sensor reads it ({seen})"
        return Problem(
            what, "", "axes are mixed up", "Check the axes turned, the columns and the mounting", "axes_mixed"
        )
    if abs(own + 1.0) <= plan.agreement:
        what = f"{axis} sensor: reads {own:+.3f} of the rate: the sense is inverted"
        return Problem(
            what, "", "a model would turn the wrong way", "Check the sign of the rates and the mounting", "inverted"
        )
    what = (
        f"{axis} sensor: reads {own:+.4g} of the rate of the table, more than {plan.agreement:.0%} from what it should"
    )
    return Problem(what, "", "this is no calibration error", "Check units, scale factor and columns", "rate_disagrees")

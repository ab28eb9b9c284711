"""Linearity error: largest deviation of the mean reading at a rate from the best straight line.

In percent of the largest rate that was used (IEEE 528, linearity error; 1431, 12.9). The largest of k deviations
is large by chance alone, so it counts as seen only where it exceeds the simultaneous (Sidak) bound of k means;
otherwise that bound on top of the largest deviation is published as an upper limit.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ....core.key import Key, Reason
from ....core.results import Interval, Row, not_estimated
from ....statistics.intervals import band_factor, coverage_factor
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

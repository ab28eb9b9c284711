"""The scale factor's uncertainty (Type B): it acts on all sizes of noise in proportion.

A size is as uncertain as the scale factor that turned readings into rates: one unknown factor for all terms and axes.
Intervals are widened by it on the logarithm, where it adds to what the fit has.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy import special

from ...core.estimate import Component, Estimate
from ...core.influence import Influence, Standards
from ...core.results import Interval, Row
from ...sensors.noise.terms import GaussMarkov, quantity_name

SCALE = "sensor.scale_factor"
SOURCE = "scale factor of the sensor"
TIME = quantity_name(GaussMarkov.name, "correlation_time", None)


def relative(standards: Standards) -> float:
    """Return the relative standard uncertainty of the scale factor; 0 where none is stated.

    Parameters
    ----------
    standards : mapping of Influence
        As stated.
    """
    influence: Influence | None = standards.get(SCALE)
    return 0.0 if influence is None else influence.u


def widened(row: Row, standards: Standards) -> Row:
    """Return the row with what the scale factor adds to its uncertainty and interval.

    Parameters
    ----------
    row : Row
        A size of noise.
    standards : mapping of Influence
        As stated.
    """
    own = relative(standards)
    if own == 0.0 or row.value is None:
        return row
    u = None if row.u is None else float(np.hypot(row.u, own * row.value))
    interval = _interval(row, own)
    value = interval.hi if row.status == "upper_limit" and interval is not None else row.value
    return replace(row, value=value, u=u, interval=interval)


def _interval(row: Row, own: float) -> Interval | None:
    interval, value = row.interval, row.value
    if interval is None or value is None:
        return interval
    more = float(special.ndtri(0.5 * (1.0 + interval.p))) * own

    def end(at: float | None) -> float | None:
        if at is None or at <= 0.0 or value <= 0.0:
            return at
        log = np.log(at / value)
        return float(value * np.exp(np.copysign(np.hypot(log, more), log if log else 1.0)))

    return Interval(end(interval.lo), end(interval.hi), interval.p)


def with_scale(estimate: Estimate, standards: Standards) -> Estimate:
    """Return the estimate with the scale factor as one more source, shared by all sizes; times do not feel it.

    Parameters
    ----------
    estimate : Estimate
        Of all axes.
    standards : mapping of Influence
        As stated.
    """
    influence = standards.get(SCALE)
    if influence is None or influence.u == 0.0:
        return estimate
    sized = np.array([0.0 if key.quantity == TIME else 1.0 for key in estimate.keys]) * estimate.values
    covariance = influence.u**2 * np.outer(sized, sized)
    component = Component(
        influence.origin(SOURCE), "B", covariance, influence.dof, influence.distribution, influence.stated
    )
    return replace(estimate, components=(*estimate.components, component))

"""Second- and third-order terms of a line: which the rates allow, which are seen, which may be there.

``K2`` bends the reading as the asymmetry does, ``K3`` as the scale factor does: at three sizes of rate, u of the
asymmetry is 3 to 6 times larger beside K2, that of the scale factor 2 to 3 times beside K3. So a term that is not there
is not fitted. Of the fit with all terms that the rates allow:

seen
    its t test, at 2 % for all terms of all sensors together (Bonferroni): the line has the term, and so has the model.
hinted at
    its own t test, at 10 %: the line has it not, and its root mean square size, sqrt(value^2 + u^2), times what one
    unit of it adds to each coefficient, is an uncertainty of them.
neither
    taken as 0.

Assumed: the scatter behind ``u`` of the terms. Not held: (1) a term of 0.5 to 2 times its own u is mostly taken as 0,
and no choice by the data can do better: the asymmetry's interval then holds the truth in 20 to 56 % (K2), that of the
scale factor in 50 to 84 % (K3); ``nonlinearity = "always"`` holds 95 % whatever the terms are; (2) terms above the
third order; (3) saturation, which looks like K3.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from scipy import special

from ....core.errors import DataError
from ....core.estimate import Array
from ....core.key import Reason
from ....statistics.random_offsets import whitened
from ..plan import Plan
from ..readings import Readings
from .regression import POWERS, Line, Unresolved, design, line, recordings_of

SEEN = 0.02  # false-alarm rate for all terms together
HINTED = 0.1  # of one term
APART = 0.02  # part of a term's column that the other columns do not explain, from which on it is told apart
NEEDS = {
    "K2": "needs three sizes of rate (rest counts) and a dwell more than coefficients: K2 and asymmetry look alike",
    "K3": "needs two sizes of rate in both senses and a dwell more than coefficients: K3 and scale factor look alike",
}


@dataclass(frozen=True, eq=False)
class Chosen:
    """A line with the terms that it needs, and the fit that decided it."""

    line: Line
    full: Line  # With all terms that the rates allow
    reasons: Mapping[str, Reason] = field(default_factory=dict[str, Reason])  # Why a term is not estimated


def with_nonlinearity(plan: Plan, readings: Readings, sensor: str, asymmetry: bool, sensors: int) -> Chosen:
    """Return the line of a sensor with the second- and third-order terms that are seen among so many sensors."""
    plain = line(plan, readings, sensor, asymmetry)
    if plan.nonlinearity == "none":
        return Chosen(plain, plain, dict.fromkeys(POWERS, Reason("by_plan", 'nonlinearity = "none" in the plan')))
    told = allowed(plain)
    reasons = {name: Reason("few_rates", NEEDS[name]) for name in POWERS if name not in told}
    full = _fitted(plan, readings, sensor, asymmetry, told)
    if full is None or full.covariance is None:
        return Chosen(plain, plain, reasons | {name: Reason("few_rates", NEEDS[name]) for name in told})
    if plan.nonlinearity == "always":
        unresolved = tuple(_unresolved(full, full, name, hinted=True) for name in told)
        return Chosen(replace(full, unresolved=unresolved), full, reasons)
    p = {name: _p_of(full, name) for name in told}
    seen = tuple(name for name in told if p[name] < SEEN / (len(POWERS) * sensors))
    own = full if seen == told else _fitted(plan, readings, sensor, asymmetry, seen) or plain
    unresolved = tuple(_unresolved(own, full, name, p[name] < HINTED) for name in told)
    return Chosen(replace(own, unresolved=unresolved), full, reasons)


def _fitted(plan: Plan, readings: Readings, sensor: str, asymmetry: bool, terms: tuple[str, ...]) -> Line | None:
    try:
        return line(plan, readings, sensor, asymmetry, terms)
    except DataError:
        return None


def allowed(plain: Line) -> tuple[str, ...]:
    """Return the terms that the rates tell apart from the coefficients of a line, and from each other."""
    readings = plain.readings
    found: tuple[str, ...] = ()
    if plain.sensor not in plain.axes:
        return found
    groups = recordings_of(readings)[0] if plain.fit.own else np.zeros(len(readings))
    numbers = np.unique(groups, return_inverse=True)[1]
    spare = plain.fit.dof
    for name in POWERS:
        columns = design(readings, plain.sensor, plain.axes, plain.asymmetry, (*found, name))[0][:, 1:]
        within = whitened(columns, np.ones(len(readings)), numbers, np.inf)
        size = np.linalg.norm(within, axis=0)
        if spare < 2.0 or not np.all(size > 0.0):
            continue
        unit = within / size
        left = unit[:, -1] - unit[:, :-1] @ np.linalg.lstsq(unit[:, :-1], unit[:, -1], rcond=None)[0]
        if np.linalg.norm(left) > APART:
            found, spare = (*found, name), spare - 1.0
    return found


def _p_of(full: Line, name: str) -> float:
    """Return the probability of a term so large where there is none."""
    at = full.names.index(name)
    assert full.covariance is not None  # noqa: S101 - as checked
    u = float(np.sqrt(full.covariance[at, at]))
    if not full.dof[at] > 0.0:
        return 1.0
    size = abs(full.fit.coefficients[at])
    if size <= _rounding(full, name):
        return 1.0
    with np.errstate(over="ignore", divide="ignore"):  # a term without scatter is infinitely far from 0
        return float(2.0 * special.stdtr(full.dof[at], -np.divide(size, u)))


def _rounding(full: Line, name: str) -> float:
    """Return the size of a term that is rounding of the readings."""
    rates = np.abs(full.readings.applied[full.readings.axis == full.sensor])
    return float(1e-12 * np.max(rates) ** (1 - POWERS[name]))


def _unresolved(own: Line, full: Line, name: str, hinted: bool) -> Unresolved:
    at = full.names.index(name)
    assert full.covariance is not None  # noqa: S101 - as checked
    column: Array = full.fit.design[:, at]
    size = float(np.sqrt(full.fit.coefficients[at] ** 2 + full.covariance[at, at])) if hinted else 0.0
    pattern = np.zeros(len(own.names)) if name in own.curvature else own.fit.solve @ column
    return Unresolved(name, size, pattern)

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

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from scipy import special

from ....core.errors import DataError
from ....core.estimate import Array
from ....core.key import Reason
from ..plan import Plan
from ..readings import Readings
from ..turned import POWERS
from .regression import Line, Unresolved, lines

SEEN = 0.02  # false-alarm rate for all terms together
HINTED = 0.1  # of one term
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


def with_nonlinearity(
    plan: Plan, units: Sequence[Readings], sensor: str, asymmetry: bool, sensors: int
) -> list[Chosen | DataError]:
    """Return the line of a sensor of each of several units with the second- and third-order terms that are seen.

    Parameters
    ----------
    plan : Plan
        Of all units: its ``nonlinearity``.
    units : sequence of Readings
        Their dwells.
    sensor : str
        Axis of the sensor.
    asymmetry : bool
        Whether the lines have a coefficient of it.
    sensors : int
        How many sensors of a unit are looked at.

    Returns
    -------
    list of Chosen or DataError
        Why a unit has no line, as `regression.line`.
    """
    plain = lines(units, sensor, asymmetry)
    if plan.nonlinearity == "none":
        why = dict.fromkeys(POWERS, Reason("by_plan", 'nonlinearity = "none" in the plan'))
        return [one if isinstance(one, DataError) else Chosen(one, one, why) for one in plain]
    told = [() if isinstance(one, DataError) else _allowed(one) for one in plain]
    full = _fitted(units, sensor, asymmetry, told, plain, plain)
    always = plan.nonlinearity == "always"
    p = [{} if isinstance(one, DataError) else _chances(one, always) for one in full]
    seen = [tuple(name for name in one if one[name] < SEEN / (len(POWERS) * sensors)) for one in p]
    own = _fitted(units, sensor, asymmetry, seen, plain, full)
    found: list[Chosen | DataError] = []
    for i, one in enumerate(plain):
        if isinstance(one, DataError):
            found.append(one)
            continue
        reasons = {name: Reason("few_rates", NEEDS[name]) for name in POWERS if name not in told[i]}
        whole, line = full[i], own[i]
        if isinstance(whole, DataError) or whole.covariance is None:
            found.append(Chosen(one, one, reasons | {name: Reason("few_rates", NEEDS[name]) for name in told[i]}))
            continue
        line = one if isinstance(line, DataError) else line
        unresolved = tuple(_unresolved(line, whole, name, p[i][name] < HINTED) for name in told[i])
        found.append(Chosen(replace(line, unresolved=unresolved), whole, reasons))
    return found


def _chances(full: Line, always: bool) -> dict[str, float]:
    """Return the probability of each term of a line to be so large where there is none; 0 where all are taken."""
    if full.covariance is None or not full.curvature:
        return {}
    if always:
        return dict.fromkeys(full.curvature, 0.0)
    at = [full.names.index(name) for name in full.curvature]
    u, dof, size = np.sqrt(full.covariance[at, at]), full.dof[at], np.abs(full.fit.coefficients[at])
    # Rounding of the readings makes a term, too
    largest = np.abs(full.readings.applied[full.readings.axis == full.sensor]).max()
    rounding = np.array([1e-12 * largest ** (1 - POWERS[name]) for name in full.curvature])
    told = (dof > 0.0) & ~(size <= rounding)
    with np.errstate(over="ignore", divide="ignore", invalid="ignore"):  # without scatter it is infinitely far from 0
        p = 2.0 * special.stdtr(np.where(told, dof, 1.0), -np.divide(size, u))
    return dict(zip(full.curvature, np.where(told, p, 1.0).tolist(), strict=True))


def _fitted(
    units: Sequence[Readings],
    sensor: str,
    asymmetry: bool,
    terms: Sequence[tuple[str, ...]],
    plain: Sequence[Line | DataError],
    full: Sequence[Line | DataError],
) -> list[Line | DataError]:
    """Return lines with terms, unit by unit: of those there are, or fitted; none without a plain one."""
    found = list(plain)
    missing: dict[tuple[str, ...], list[int]] = {}
    for i, (wanted, one, other) in enumerate(zip(terms, plain, full, strict=True)):
        if isinstance(one, DataError) or one.curvature == wanted:
            continue
        if not isinstance(other, DataError) and other.curvature == wanted:
            found[i] = other
        else:
            missing.setdefault(wanted, []).append(i)
    for wanted, at in missing.items():
        for i, line in zip(at, lines([units[i] for i in at], sensor, asymmetry, wanted), strict=True):
            found[i] = line
    return found


def _allowed(plain: Line) -> tuple[str, ...]:
    """Return the terms that the rates tell apart from the coefficients of a line, and from each other."""
    return plain.readings.turned.allowed(plain.sensor, plain.asymmetry, plain.fit.own, plain.fit.dof)


def _unresolved(own: Line, full: Line, name: str, hinted: bool) -> Unresolved:
    at = full.names.index(name)
    assert full.covariance is not None  # noqa: S101 - as checked
    column: Array = full.fit.design[:, at]
    size = float(np.sqrt(full.fit.coefficients[at] ** 2 + full.covariance[at, at])) if hinted else 0.0
    pattern = np.zeros(len(own.names)) if name in own.curvature else own.fit.solve @ column
    return Unresolved(name, size, pattern)

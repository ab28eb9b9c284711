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
from typing import NamedTuple

import numpy as np
from scipy import special

from ....core.errors import DataError
from ....core.estimate import Array
from ....core.key import Reason
from ....statistics.least_squares import times
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


class Chosen(NamedTuple):
    """A line with the terms that it needs, and the fit that decided it."""

    line: Line
    full: Line  # With all terms that the rates allow
    reasons: Mapping[str, Reason]  # Why a term is not estimated


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
    p = _chances(full, always)
    seen = [tuple(name for name in one if one[name] < SEEN / (len(POWERS) * sensors)) for one in p]
    own = _fitted(units, sensor, asymmetry, seen, plain, full)
    found: list[Chosen | DataError] = []
    bent: dict[tuple[int, int, tuple[str, ...]], list[tuple[int, Line, Line]]] = {}
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
        found.append(Chosen(line, whole, reasons))
        bent.setdefault((id(line.fit.design), id(whole.fit.design), told[i]), []).append((i, line, whole))
    for (*_, terms), alike in bent.items():
        each = _unresolved([(line, whole) for _, line, whole in alike], terms, [p[i] for i, *_ in alike])
        for (i, line, whole), unresolved in zip(alike, each, strict=True):
            made = found[i]
            if isinstance(made, Chosen):
                found[i] = Chosen(line.changed(unresolved=unresolved), whole, made.reasons)
    return found


def _chances(full: Sequence[Line | DataError], always: bool) -> list[dict[str, float]]:
    """Return of each line the probability of each of its terms to be so large where there is none; 0: all are taken."""
    found: list[dict[str, float]] = [{} for _ in full]
    alike: dict[tuple[int, tuple[str, ...], str], list[tuple[int, Line, Array]]] = {}
    for i, one in enumerate(full):
        if isinstance(one, DataError) or one.covariance is None or not one.curvature:
            continue
        if always:
            found[i] = dict.fromkeys(one.curvature, 0.0)
        else:
            kind = id(one.readings.turned), one.names, one.sensor
            alike.setdefault(kind, []).append((i, one, one.covariance.diagonal()))
    for group in alike.values():
        first = group[0][1]
        at = [first.names.index(name) for name in first.curvature]
        u = np.sqrt(np.array([own for *_, own in group])[:, at])
        dof, size = (np.array(each)[:, at] for each in zip(*((one.dof, np.abs(one.fit.coefficients))
                                                             for _, one, _ in group), strict=True))  # fmt: skip
        # Rounding of the readings makes a term, too
        largest = np.abs(first.readings.applied[first.readings.axis == first.sensor]).max()
        rounding = np.array([1e-12 * largest ** (1 - POWERS[name]) for name in first.curvature])
        told = (dof > 0.0) & ~(size <= rounding)
        with np.errstate(over="ignore", divide="ignore", invalid="ignore"):  # without scatter infinitely far from 0
            p = 2.0 * special.stdtr(np.where(told, dof, 1.0), -np.divide(size, u))
        for (i, one, _), own in zip(group, np.where(told, p, 1.0).tolist(), strict=True):
            found[i] = dict(zip(one.curvature, own, strict=True))
    return found


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


def _unresolved(
    lines: Sequence[tuple[Line, Line]], terms: tuple[str, ...], chances: Sequence[Mapping[str, float]]
) -> list[tuple[Unresolved, ...]]:
    """Return what lines of one design, each with its fit of all terms, may lack of some terms."""
    own, full = lines[0]
    found = []
    for name in terms:
        at = full.names.index(name)
        theta = np.array([whole.fit.coefficients[at] for _, whole in lines])
        variance = np.array([whole.covariance[at, at] for _, whole in lines if whole.covariance is not None])
        hinted = np.array([one[name] < HINTED for one in chances])
        size = np.where(hinted, np.sqrt(theta**2 + variance), 0.0)
        if name in own.curvature:
            pattern = np.zeros((len(lines), len(own.names)))
        else:
            pattern = times(np.array([line.fit.solve for line, _ in lines]), full.fit.design[:, at])
        found.append([Unresolved(name, *each) for each in zip(size.tolist(), pattern, strict=True)])
    return [*zip(*found, strict=True)] if found else [()] * len(lines)

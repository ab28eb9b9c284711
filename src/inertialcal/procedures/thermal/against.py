"""Bias in one condition less that in another: vacuum against air, after against before.

The difference of two laws at a temperature. What it is known by is what the power-ups disagree about, those of both
tests: the mean of five turn-ons in air and the mean of five in vacuum each have their run-to-run part, with degrees of
freedom of their own. Runs with one label in both tests (pumped down without a new power-up) are one power-up: then
both laws are taken together, and what they share cancels.

How the difference goes with temperature is told as a step of order 1, ``p (1 + e (T - T_ref))``: the line of least
squares through the difference of the two laws at `POINTS` temperatures of the range that both went through, evenly
spread. ``p`` and ``p e`` are linear in the coefficients of both laws: their covariance is of the same kind as that of a
difference at one temperature. ``e`` is their ratio, to first order. What the line does not follow is told beside.

What one power-up can differ from the mean offset by is told beside, ``..._run_to_run``: the root sum of squares of the
scatters of both.

The standards are those of one campaign: the thermometer acts by the difference of the slopes, the converter in
proportion to the difference, the latitude not at all at one place. How far the body stands from its stated attitude
cancels where both tests state one attitude and one mounting, or share all their power-ups; else the body counts as laid
anew in between (``statistics.difference``).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray
from scipy import linalg

from ...core.estimate import Array, Component, Estimate
from ...core.influence import Influence, Occasion
from ...core.key import AXES, Key, Origin, Reason
from ...core.results import Row, not_estimated
from ...core.units import factor
from ...statistics.clustered import clustered_contrasts
from ...statistics.difference import changes_left
from ...statistics.intervals import chi_square_interval, t_interval
from ...statistics.least_squares import fit
from .fit.law import Law
from .fit.quantities import ORDER, SOURCES, at_degrees, earth_along, power_unit
from .fit.sensor import OfSensor
from .rows import ONE_RUN, SAME, estimate_rows

if TYPE_CHECKING:
    from .reduction import Result

THERMOMETER, REFERENCE, EARTH = "thermometer.temperature", "converter.reference", "earth rate: "
WORDS = {THERMOMETER: "thermometer", REFERENCE: "converter reference"}  # as budgets call them
SHIFT, VACUUM = "bias_shift", "vacuum_offset"
STEPS = {SHIFT: "bias_shift_step", VACUUM: "vacuum_step"}  # the line through the difference over temperature
POINTS = 21  # of the range that both tests went through, that the line is laid through


def quantity_of(condition: str) -> str:
    """Return what the difference is called: the vacuum offset where this test is in vacuum, else a bias shift."""
    return VACUUM if condition == "vacuum" else SHIFT


def offset_rows(
    result: Result,
    other: Result,
    name: str,
    quantity: str,
    occasions: tuple[Occasion, Occasion] = (Occasion(), Occasion()),
) -> list[Row]:
    """Return the bias of `result` less that of `other`, at the reference temperature and where the plan asks.

    Parameters
    ----------
    result, other : Result
        This test, and the one that it is set against.
    name, quantity : str
        Of the other; what the difference is called.
    occasions : (Occasion, Occasion)
        What drew the errors of standards in each.
    """
    found: list[Row] = []
    for axis in AXES:
        if axis in result.sensors and axis in other.sensors:
            found += _of_axis(result, other, axis, name, quantity, occasions)
        elif axis in result.sensors or axis in other.sensors:
            reason = Reason("not_reduced", f"the {axis} sensor was not reduced in both tests")
            found.append(not_estimated(Key(quantity, axis), result.readings.unit, reason))
    return found


def _of_axis(
    result: Result, other: Result, axis: str, name: str, quantity: str, occasions: tuple[Occasion, Occasion]
) -> Iterator[Row]:
    one, two = result.sensors[axis], other.sensors[axis]
    unit = result.readings.unit
    key = Key(quantity, axis)
    wanted = {key: result.plan.reference_temperature}
    wanted |= {key._replace(at=at_degrees(one)): one for one in result.plan.at or ()}
    if not (one.law.midway and two.law.midway):
        yield not_estimated(key, unit, Reason("one_path", "one path only was seen in one of the tests"))
        return
    low, high = (max(one.law.domain[0], two.law.domain[0]), min(one.law.domain[1], two.law.domain[1]))
    inside = {own: place for own, place in wanted.items() if low <= place <= high}
    outside = Reason("outside", f"outside what both tests went through, {low:.4g} to {high:.4g} degC")
    yield from (not_estimated(own, unit, outside) for own in wanted if own not in inside)
    keys = list(inside)
    places = np.array(list(inside.values()))
    estimate, known = _difference(result, other, axis, places, np.eye(len(places)), keys, occasions)
    limits = Reason("limits", f"this test less {name}{_unsaid(result, other, occasions)}")
    rows = estimate_rows(estimate)
    for own, is_known in zip(keys, known, strict=True):
        if is_known and estimate is not None:
            yield rows[own].changed(reason=limits, shared=estimate.shared(own))
        else:
            yield not_estimated(own, unit, ONE_RUN)
    yield from _step(result, other, axis, quantity, limits, occasions)
    yield _run_to_run(result, other, Key(f"{quantity}_run_to_run", axis))


def _step(
    result: Result,
    other: Result,
    axis: str,
    quantity: str,
    limits: Reason,
    occasions: tuple[Occasion, Occasion],
) -> Iterator[Row]:
    """Rows of the line through the difference over temperature: step at the reference, its slope, their ratio."""
    laws = [one.sensors[axis].law for one in (result, other)]
    low, high = max(one.domain[0] for one in laws), min(one.domain[1] for one in laws)
    reference, unit = result.plan.reference_temperature, result.readings.unit
    keys = [Key(STEPS[quantity], axis), Key(f"{STEPS[quantity]}_temperature", axis)]
    relative = Key(f"{STEPS[quantity]}_relative_temperature", axis)
    units = [unit, power_unit(unit, "degC", 1)]
    if not low <= reference <= high or low == high:
        outside = Reason(
            "outside", f"both tests went through {low:.4g} to {high:.4g} degC, reference {reference:.4g} degC"
        )
        yield from (not_estimated(key, its, outside) for key, its in zip(keys, units, strict=True))
        return
    places = np.linspace(low, high, POINTS)
    line = np.column_stack([np.ones(POINTS), places - reference])
    weights = np.linalg.pinv(line)
    estimate, known = _difference(result, other, axis, places, weights, keys, occasions, units)
    if estimate is None or not all(known):
        yield from (not_estimated(key, its, ONE_RUN) for key, its in zip(keys, units, strict=True))
        return
    apart = laws[0].basis(places) @ laws[0].coefficients - laws[1].basis(places) @ laws[1].coefficients
    bend = float(np.max(np.abs(apart - line @ (weights @ apart))))
    shown = result.plan.unit or unit
    size = bend * (factor(unit, shown) if shown != unit else 1.0)
    told = f"{limits.text}; line over {low:.4g} to {high:.4g} degC, the laws leave it by up to {size:.2g} {shown}"
    rows = estimate_rows(estimate)
    for key in keys:
        yield rows[key].changed(reason=Reason("limits", told), shared=estimate.shared(key))
    yield _relative(estimate, keys, relative)


def _relative(estimate: Estimate, keys: list[Key], key: Key) -> Row:
    """Row of the slope over the step, to first order; none where the step may be nothing."""
    step, slope = (float(one) for one in estimate.values)
    covariance, dof = estimate.covariance, float(np.min(estimate.dof))
    own = t_interval(step, math.sqrt(float(covariance[0, 0])), dof)
    if own.lo is None or own.hi is None or own.lo <= 0.0 <= own.hi:
        return not_estimated(key, "1/degC", Reason("no_step", "the step may be nothing: its slope has no ratio to it"))
    ratio = slope / step
    gradient = np.array([-ratio, 1.0]) / step
    u = math.sqrt(max(float(gradient @ covariance @ gradient), 0.0))
    reason = Reason("limits", f"{keys[1]} over {keys[0]}, to first order")
    return Row(key, ratio, u, "1/degC", dof if math.isfinite(dof) else None, t_interval(ratio, u, dof), reason=reason)


def _difference(
    result: Result,
    other: Result,
    axis: str,
    places: Array,
    weights: Array,
    keys: list[Key],
    occasions: tuple[Occasion, Occasion],
    units: Sequence[str] = (),
) -> tuple[Estimate | None, list[bool]]:
    """Return combinations of the differences at temperatures that have an uncertainty, and which those are.

    Parameters
    ----------
    result, other : Result
        This test, and the one that it is set against.
    axis : str
        Of the sensor.
    places : ndarray, shape (g,)
        Temperatures [degC].
    weights : ndarray, shape (m, g)
        Of the differences there in each combination.
    keys : list of Key
        Of the m combinations.
    occasions : (Occasion, Occasion)
        What drew the errors of standards in each.
    units : sequence of str, optional
        Of the combinations; that of the readings by default.
    """
    laws = [one.sensors[axis].law for one in (result, other)]
    rows = [weights @ law.basis(places) if len(places) else np.zeros((0, law.order + 1)) for law in laws]
    values = rows[0] @ laws[0].coefficients - rows[1] @ laws[1].coefficients
    scatter, known = _scatter(result, other, laws, rows)
    if not known.any():
        return None, list(known)
    names = tuple(key for key, keep in zip(keys, known, strict=True) if keep)
    unit = result.readings.unit
    given = tuple(units) or (unit,) * len(keys)
    whole = weights.sum(axis=1)  # of what is the same at each temperature
    mine, its = (
        _changes(one, law, row, whole, axis, known) for one, law, row in zip((result, other), laws, rows, strict=True)
    )
    order = (weights @ (laws[0].changed(places) - laws[1].changed(places)))[known]
    chosen = [Component(ORDER, "A", np.outer(order, order))] if order.any() else []
    components = [*scatter, *chosen, *_type_b(mine, its, _shared(result, other, mine, occasions))]
    if unit == "rad/s":
        values = values - whole * (earth_along(result.plan)[0] - earth_along(other.plan)[0])[AXES.index(axis)]
    own = tuple(one for one, keep in zip(given, known, strict=True) if keep)
    return Estimate(names, values[known], own, tuple(components)), list(known)


def _scatter(
    result: Result, other: Result, laws: list[Law], rows: list[Array]
) -> tuple[list[Component], NDArray[np.bool_]]:
    """Type A parts: of each test by its own power-ups, or of both together where they share some."""
    pairs = zip(laws, ("this test", "the other"), strict=True)
    origins = [Origin(f"{SOURCES[law.level]}, {which}", level=law.level) for law, which in pairs]
    shared = set(result.readings.labels) & set(other.readings.labels)
    if shared and all(law.level == "run" for law in laws):
        found = [(Origin(SOURCES["run"], level="run"), *_joint(result, other, laws, rows))]
    else:
        found = [(origin, *law.contrasts(row)) for origin, law, row in zip(origins, laws, rows, strict=True)]
    known = np.all([dof > 0.0 for _, _, dof in found], axis=0)
    grid = np.ix_(known, known)
    return [Component(one, "A", _symmetric(c[grid]), dof[known], "t") for one, c, dof in found if known.any()], known


def _joint(result: Result, other: Result, laws: list[Law], rows: list[Array]) -> tuple[Array, Array]:
    """Covariance and degrees of freedom of the differences, a run of both tests being one cluster."""
    labels = [
        np.array([one.readings.labels[run] for run in law.clusters])
        for law, one in zip(laws, (result, other), strict=True)
    ]
    fits = [law.fit for law in laws]
    whitened = np.concatenate([one.design @ one.coefficients + one.residuals for one in fits])
    whole = fit(linalg.block_diag(*(one.design for one in fits)), whitened)
    spare = [np.zeros((len(row), one.coefficients.size - row.shape[1])) for one, row in zip(fits, rows, strict=True)]
    return clustered_contrasts(whole, np.concatenate(labels), np.hstack([rows[0], spare[0], -rows[1], spare[1]]))


def _symmetric(covariance: Array) -> Array:
    return 0.5 * (covariance + covariance.T)


Changes = dict[str, tuple[Influence, Array]]  # by source: what it rests on, and what it changes, shape (s, k)


def _changes(result: Result, law: Law, rows: Array, whole: Array, axis: str, known: NDArray[np.bool_]) -> Changes:
    """Return what one standard uncertainty of each source changes in combinations of the biases of one test."""
    found = {}
    thermometer, reference = (result.plan.standards.get(name) for name in (THERMOMETER, REFERENCE))
    if thermometer is not None:
        found[THERMOMETER] = thermometer, -(thermometer.u * (rows @ _slope(law)))[None, known]
    if reference is not None:
        found[REFERENCE] = reference, (reference.u * (rows @ law.coefficients))[None, known]
    if result.readings.unit == "rad/s":
        for source, one in earth_along(result.plan)[1].items():
            along = -one.patterns[:, [AXES.index(axis)]]
            if np.any(along):
                found[EARTH + source] = one.influence, along * whole[None, known]
    return found


def _laid_alike(result: Result, other: Result, occasions: tuple[Occasion, Occasion]) -> bool:
    """Whether the body lay the same in both tests: as stated, or because all power-ups are in both."""
    one, two = occasions
    stated = bool(one.mounting) and one.mounting == two.mounting
    return stated or set(result.readings.labels) == set(other.readings.labels)


def _unsaid(result: Result, other: Result, occasions: tuple[Occasion, Occasion]) -> str:
    """Say that errors of the attitude would cancel in one stated mounting; empty where that is no matter."""
    plan = result.plan
    known = result.readings.unit != "rad/s" or not any(one != "latitude" for one in earth_along(plan)[1])
    apart = plan.attitude != other.plan.attitude or occasions[0].remounted(occasions[1])
    if known or apart or _laid_alike(result, other, occasions):
        return ""
    return "; the body counts as laid anew: if it was not, state one mounting in both tests"


def _shared(result: Result, other: Result, changes: Changes, occasions: tuple[Occasion, Occasion]) -> set[str]:
    """Return the sources whose error is the same in both tests of a campaign."""
    plan, its = result.plan, other.plan
    laid_alike = _laid_alike(result, other, occasions)
    found = set()
    for name, (influence, _) in changes.items():
        if name == EARTH + "latitude":
            same = plan.latitude == its.latitude
        elif name not in WORDS:  # errors of the attitude
            same = laid_alike and plan.attitude == its.attitude and plan.latitude == its.latitude
        else:
            labels = [each.drew(influence.redrawn_by) for each in occasions]
            lasting = influence.redrawn_by in ("", "never", "certificate")
            same = lasting or (bool(labels[0]) and labels[0] == labels[1])
        if same:
            found.add(name)
    return found


def _type_b(mine: Changes, its: Changes, shared: set[str]) -> list[Component]:
    """Return the components of the differences: what both tests share cancels."""
    whose = {"mine": ", this test", "its": ", the other", "": ""}
    found = []
    own, others = ({name: change for name, (_, change) in one.items()} for one in (mine, its))
    left = changes_left(own, others, shared)
    for (name, side), change in left.items():
        if np.any(change):
            one = (its if side == "its" else mine)[name][0]
            what = f"{WORDS.get(name, name)}{whose[side]}"
            origin = Origin(what) if side or not one.standard else one.origin(what)
            covariance = _symmetric(change.T @ change)
            found.append(Component(origin, "B", covariance, one.dof, one.distribution, one.stated, change))
    return found


def _slope(law: Law) -> Array:
    """Chebyshev coefficients of the slope of P [unit/degC]."""
    if law.order == 0:
        return np.zeros(1)
    return np.append(chebyshev.chebder(law.coefficients), 0.0) * 2.0 / (law.domain[1] - law.domain[0])


def _run_to_run(result: Result, other: Result, key: Key) -> Row:
    """Row of what a single power-up scatters by about the mean difference."""
    one, two = result.sensors[key.axis], other.sensors[key.axis]
    unit = result.readings.unit
    if set(result.readings.labels) & set(other.readings.labels):
        return not_estimated(key, unit, Reason("shared_runs", "some power-ups are in both tests"))
    if min(len(one.run_offsets), len(two.run_offsets)) < 2:
        return not_estimated(key, unit, Reason("one_run", "one run in one of the tests: not repeated"))
    squares = [_variance(sensor) for sensor in (one, two)]
    total = sum(square for square, _ in squares)
    if not total > 0.0:
        return not_estimated(key, unit, SAME)
    dof = total**2 / sum(square**2 / free for square, free in squares)
    std = float(np.sqrt(total))
    reason = Reason("limits", "standard deviation from one pair of power-ups to another")
    return Row(key, std, std / float(np.sqrt(2.0 * dof)), unit, dof, chi_square_interval(std, dof),
               reason=reason)  # fmt: skip


def _variance(sensor: OfSensor) -> tuple[float, float]:
    offsets = sensor.run_offsets
    return float(np.var(offsets, ddof=1)), len(offsets) - 1.0

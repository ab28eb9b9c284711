"""Bias in one condition less that in another: vacuum against air, after against before.

The difference of two laws at a temperature. What it is known by is what the power-ups disagree about, those of both
tests: the mean of five turn-ons in air and the mean of five in vacuum each have their run-to-run part, with degrees of
freedom of their own. Runs with one label in both tests (pumped down without a new power-up) are one power-up: then
both laws are taken together, and what they share cancels.

What one power-up can differ from the mean offset by is told beside, ``..._run_to_run``: the root sum of squares of the
scatters of both.

Of the standards, the thermometer acts by the difference of the slopes, the converter in proportion to the difference;
earth rate cancels where both tests say the same attitude.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray
from scipy import linalg

from ...core.estimate import Array, Component, Estimate
from ...core.key import AXES, Key, Origin, Reason
from ...core.results import Row, not_estimated
from ...statistics.clustered import clustered_contrasts
from ...statistics.intervals import chi_square_interval
from ...statistics.least_squares import fit
from .fit.law import Law
from .fit.quantities import SOURCES, at_degrees, earth_along
from .fit.sensor import OfSensor
from .plan import Plan
from .rows import ONE_RUN, SAME, estimate_row

if TYPE_CHECKING:
    from .reduction import Result

SHIFT, VACUUM = "bias_shift", "vacuum_offset"


def quantity_of(condition: str) -> str:
    """Return what the difference is called: the vacuum offset where this test is in vacuum, else a bias shift."""
    return VACUUM if condition == "vacuum" else SHIFT


def offset_rows(result: Result, other: Result, name: str, quantity: str) -> list[Row]:
    """Return the bias of `result` less that of `other`, at the reference temperature and where the plan asks."""
    found: list[Row] = []
    for axis in AXES:
        if axis in result.sensors and axis in other.sensors:
            found += _of_axis(result, other, axis, name, quantity)
        elif axis in result.sensors or axis in other.sensors:
            reason = Reason("not_reduced", f"the {axis} sensor was not reduced in both tests")
            found.append(not_estimated(Key(quantity, axis), result.readings.unit, reason))
    return found


def _of_axis(result: Result, other: Result, axis: str, name: str, quantity: str) -> Iterator[Row]:
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
    estimate, known = _difference(result, other, axis, np.array(list(inside.values())), keys)
    for own, is_known in zip(keys, known, strict=True):
        if is_known and estimate is not None:
            yield estimate_row(estimate, own, Reason("limits", f"this test less {name}"))
        else:
            yield not_estimated(own, unit, ONE_RUN)
    yield _run_to_run(result, other, Key(f"{quantity}_run_to_run", axis))


def _difference(
    result: Result, other: Result, axis: str, places: Array, keys: list[Key]
) -> tuple[Estimate | None, list[bool]]:
    """Return the differences at temperatures that have an uncertainty, and which those are."""
    laws = [one.sensors[axis].law for one in (result, other)]
    rows = [law.basis(places) if len(places) else np.zeros((0, law.order + 1)) for law in laws]
    values = rows[0] @ laws[0].coefficients - rows[1] @ laws[1].coefficients
    scatter, known = _scatter(result, other, laws, rows)
    if not known.any():
        return None, list(known)
    names = tuple(key for key, keep in zip(keys, known, strict=True) if keep)
    unit = result.readings.unit
    components = [*scatter, *_type_b(result.plan, laws, rows, values, known)]
    if unit == "rad/s":
        values = values - (earth_along(result.plan)[0] - earth_along(other.plan)[0])[AXES.index(axis)]
        whole = np.ones((len(names), len(names)))
        components += [Component(source, "B", u**2 * whole) for source, u in _earth(result.plan, other.plan, axis)]
    return Estimate(names, values[known], (unit,) * len(names), tuple(components)), list(known)


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
    spare = [np.zeros((len(row), law.path_order + 1)) for law, row in zip(laws, rows, strict=True)]
    return clustered_contrasts(whole, np.concatenate(labels), np.hstack([rows[0], spare[0], -rows[1], spare[1]]))


def _symmetric(covariance: Array) -> Array:
    return 0.5 * (covariance + covariance.T)


def _type_b(plan: Plan, laws: list[Law], rows: list[Array], values: Array, known: NDArray[np.bool_]) -> list[Component]:
    found = []
    thermometer = plan.standards.get("thermometer.temperature")
    if thermometer is not None:
        slopes = [row @ _slope(law) for law, row in zip(laws, rows, strict=True)]
        change = (thermometer.u * (slopes[1] - slopes[0]))[known]
        found.append(("thermometer", thermometer, change))
    reference = plan.standards.get("converter.reference")
    if reference is not None:
        found.append(("converter reference", reference, (reference.u * values)[known]))
    return [
        Component(
            one.origin(source), "B", np.outer(change, change), one.dof, one.distribution, one.stated, change[None]
        )
        for source, one, change in found
    ]


def _slope(law: Law) -> Array:
    """Chebyshev coefficients of the slope of P [unit/degC]."""
    if law.order == 0:
        return np.zeros(1)
    return np.append(chebyshev.chebder(law.coefficients), 0.0) * 2.0 / (law.domain[1] - law.domain[0])


def _earth(plan: Plan, other: Plan, axis: str) -> list[tuple[str, float]]:
    """Return what is not known of the difference of earth rate, by source; none for one known attitude."""
    if plan.attitude is not None and plan.attitude == other.attitude and plan.latitude == other.latitude:
        return []
    found = []
    for which, one in (("this test", plan), ("the other", other)):
        for source, unknown in earth_along(one)[1].items():
            u = float(np.sqrt(np.sum(unknown.patterns[:, AXES.index(axis)] ** 2)))
            if u > 0.0:
                found.append((f"earth rate: {source}, {which}", u))
    return found


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

"""Gyros: bias and g-sensitivity at rest, matrix from the rotations, and every uncertainty of both in one.

What is wrong with bias and g-sensitivity is wrong in every rotation too, and what is wrong with the accelerometers
turns the ends of all: both are carried into the matrix with their covariance.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ....core.constants import EARTH_ROTATION_RATE
from ....core.estimate import Array
from ....core.influence import Influence
from ....core.key import Reason
from ..plan import Plan
from ..readings import Readings, Rotation, local_gravity
from .accelerometer import NOT_DETERMINED, UNKNOWN, Fitted, mounting_source
from .at_rest import AtRest, Carried, apart, at_rest, earth_in_g, sources_of
from .linear_sensor import (
    BIAS,
    G_SENSITIVITY,
    MATRIX,
    TAKES_PART,
    LinearSensor,
    Source,
    after_corrections,
    level_sources,
    propagated,
)
from .next_record import rests_of
from .rotations import BETWEEN, Packed, Problem, Rotated, angles, ends_of, packed, solve

DIRECTION = 0.01  # standard uncertainty of the direction of gravity, from which on no rotation is judged [rad]
NAMES = (*MATRIX, *BIAS, *G_SENSITIVITY)
MODEL = "uncertainty of the accelerometers"
NO_ROTATIONS = Reason("no_rotations", "no rotations: at rest, gyros show only their bias")
NOT_TOLD = Reason("not_told", "these rotations do not determine it")
NO_SCALE = Reason("no_scale_factor", "no scale factor is stated, and these rotations do not determine it")
NOTHING_LEFT = Reason(
    "nothing_left",
    "no rotation was repeated, and turn.angle and fixture.orientation are not both stated:"
    " the model holds what the turns give, without uncertainty",
)
NO_GRAVITY = Reason("no_gravity", "it rests on accelerometer figures that these positions do not determine")
ONE_PLACE = Reason("one_place", "as many positions as unknowns: no degrees of freedom left")


@dataclass(frozen=True, eq=False)
class FittedGyro:
    """Gyros, and how positions and rotations agree."""

    sensor: LinearSensor  # Matrix, bias and g-sensitivity: 21 numbers
    rest: AtRest  # The positions
    rotated: Rotated | None  # The rotations; None where there are none
    problem: Problem | None  # What they are
    angles: Array  # shape (k,): of each transition, from where gravity was carried to where it is [rad]


def fit_gyro(
    plan: Plan,
    readings: Readings,
    acc: Fitted,
    ideal: Array,
    zero: Array,
    start: Array,
    north: Carried | None = None,
) -> FittedGyro:
    """Return the gyros.

    Parameters
    ----------
    plan : Plan
        Standards, whether g-sensitivity is wanted.
    readings : Readings
        With gyros.
    acc : Fitted
        Accelerometers of the same readings.
    ideal, zero : ndarray, shape (3,)
        To which readings of the gyros are taken.
    start : ndarray, shape (3, 3)
        Inverse of the matrix to begin with.
    north : Carried, optional
        How the earth rate is carried through the positions; absent: they are not joined.
    """
    assert readings.gyro is not None  # noqa: S101 - the caller has looked
    force = acc.sensor.applied(readings.acc.mean)
    rest = at_rest(plan, readings.gyro, force, ideal, zero, north or apart(force), rests_of(readings))
    if not readings.transitions and not readings.turns:
        return FittedGyro(_sensor(plan, readings, acc, rest, None, force, ideal, zero), rest, None, None, np.empty(0))
    problem, rotated = _solved(plan, readings, acc, rest, ideal, zero, start)
    sensor = _sensor(plan, readings, acc, rest, rotated, force, ideal, zero)
    return FittedGyro(sensor, rest, rotated, problem, angles(problem, rotated.W))


def angles_left(plan: Plan, readings: Readings, acc: Fitted, ideal: Array, zero: Array, start: Array) -> Array:
    """Return what the gyros of a fit leave of each transition, shape (k,) [rad]; as ``fit_gyro`` takes them."""
    assert readings.gyro is not None  # noqa: S101 - the caller has looked
    force = acc.sensor.applied(readings.acc.mean)
    rest = at_rest(plan, readings.gyro, force, ideal, zero, apart(force), rests_of(readings))
    problem, rotated = _solved(plan, readings, acc, rest, ideal, zero, start)
    return angles(problem, rotated.W)


def _solved(
    plan: Plan, readings: Readings, acc: Fitted, rest: AtRest, ideal: Array, zero: Array, start: Array
) -> tuple[Problem, Rotated]:
    force = acc.sensor.applied(readings.acc.mean)
    problem = problem_of(plan, readings, acc, rest, ideal, zero)
    known = acc.observed.whole and float(np.max(_direction_u(acc, force))) < DIRECTION
    # Else errors of the accelerometers make the ends disagree
    return problem, solve(plan, problem, start, judge=known or not readings.transitions)


def problem_of(plan: Plan, readings: Readings, acc: Fitted, rest: AtRest, ideal: Array, zero: Array) -> Problem:
    """Return the rotations as what is to be solved."""
    assert readings.gyro is not None  # noqa: S101 - the caller has looked
    force = acc.sensor.applied(readings.acc.mean)
    up = force / np.linalg.norm(force, axis=1)[:, None]
    moves = _packed(readings.transitions, acc, rest, ideal, zero)
    turns = _packed(readings.turns, acc, rest, ideal, zero)
    turned = np.array(
        [one.angle * one.axis for one in readings.turns if one.axis is not None and one.angle is not None]
    )
    noise = np.median(readings.gyro.scatter / np.abs(ideal), axis=0)
    inside = np.mean((readings.acc.u / acc.sensor.ideal) ** 2, axis=1)
    variance = (inside + (acc.between or 0.0) ** 2) / local_gravity(plan) ** 2
    return Problem(moves, ends_of(readings.transitions, up), turns, turned.reshape(-1, 3), noise, variance)


def _packed(rotations: Sequence[Rotation], acc: Fitted, rest: AtRest, ideal: Array, zero: Array) -> Packed:
    empty = np.empty((0, 3))
    rate = (np.concatenate([empty, *(one.gyro for one in rotations)]) - zero) / ideal - rest.bias
    force = np.zeros_like(rate)
    if rest.g_sensitivity is not None:
        seen = np.repeat([one.acc is not None for one in rotations], [len(one.gyro) for one in rotations])
        read = [one.acc for one in rotations if one.acc is not None]
        force[seen.astype(bool)] = acc.sensor.applied(np.concatenate([empty, *read]))
        rate = rate - force @ rest.g_sensitivity.T
    return packed(rotations, [rate], [force])


def _sensor(
    plan: Plan,
    readings: Readings,
    acc: Fitted,
    rest: AtRest,
    rotated: Rotated | None,
    force: Array,
    ideal: Array,
    zero: Array,
) -> LinearSensor:
    """Gather values, sources and reasons."""
    A = np.eye(3) if rotated is None else np.asarray(np.linalg.inv(rotated.W), dtype=np.float64)
    seen_g = np.zeros((3, 3)) if rest.g_sensitivity is None else rest.g_sensitivity
    earth, unknown = earth_in_g(plan, A)
    G = seen_g - earth if rest.g_sensitivity is not None else seen_g
    values = np.concatenate([A.ravel(), rest.bias, G.ravel()])
    forward: Array = np.asarray(-np.kron(A, A.T), dtype=np.float64)  # dA = -A dW A, row by row
    found: list[Source] = []
    if rotated is not None and rotated.found is not None:
        by_rotations = np.zeros((21, rotated.observed.rank))
        by_rotations[:9] = forward @ rotated.observed.kept
        found += level_sources(rotated.found, by_rotations, plan.standards, BETWEEN)
    by_rest = np.zeros((21, 12))
    by_rest[9:] = np.eye(12)
    if rotated is not None:
        by_rest[:9] = forward @ rotated.by_rest
    found += sources_of(plan, rest, by_rest)
    found += _after_corrections(readings, rest, by_rest, ideal)
    if unknown is not None and rest.g_sensitivity is not None:
        covariance = np.zeros((21, 21))
        covariance[9:, 9:] = unknown.covariance
        found.append(replace(unknown, covariance=covariance))
    lost = np.eye(9) if rotated is None else np.eye(9) - rotated.observed.kept @ rotated.observed.kept.T
    open_ones = forward @ lost  # What combinations that stay at their nominal value do to the matrix
    if rest.fits is not None and np.any(open_ones):
        found.append(_not_determined(plan, rest, open_ones))
    moved = np.zeros(9)  # u by combinations of accelerometer figures that stay at their nominal value
    if rotated is not None:
        back = _by_accelerometers(acc, rotated, force, forward)
        dof = float(acc.free) if acc.free else np.inf
        found.append(Source(MODEL, "A", propagated(back, acc.sensor.covariance), dof))
        of_acc = [one.covariance for one in acc.sensor.sources if one.name == NOT_DETERMINED]
        moved = np.sqrt(sum((np.diag(propagated(back, one))[:9] for one in of_acc), moved))
    clock, gravity = plan.standards.get("clock.rate"), plan.standards.get("gravity.value")
    if clock is not None and rotated is not None:
        change = np.concatenate([values[:9] * clock.u, np.zeros(12)])
        found.append(Source("clock.rate", "B", np.outer(change, change), clock.dof, clock, changes=change[None]))
    if gravity is not None:
        change = np.concatenate([np.zeros(12), values[12:] * gravity.u / local_gravity(plan)])
        found.append(Source("gravity.value", "B", np.outer(change, change), gravity.dof, gravity, changes=change[None]))
    if "fixture.mounting" in plan.standards and readings.turns and not readings.transitions and rotated is not None:
        found.append(mounting_source(values, plan.standards["fixture.mounting"].u, plan))
    told = np.linalg.norm(open_ones, axis=1) < TAKES_PART
    reasons = _reasons(rest, rotated, acc, bool(readings.transitions), told, moved > TAKES_PART * UNKNOWN)
    return LinearSensor(values, tuple(found), reasons, ideal, zero, NAMES)


def _not_determined(plan: Plan, rest: AtRest, by_open: Array) -> Source:
    """Return what a matrix that is in part nominal does to its own rest, and by the earth rate to g-sensitivity."""
    changes = np.zeros((21, 9))
    changes[:9] = UNKNOWN * by_open
    if rest.g_sensitivity is not None and plan.latitude is not None:
        per_matrix = EARTH_ROTATION_RATE.value * np.sin(plan.latitude) / local_gravity(plan)
        changes[12:] = -per_matrix * changes[:9]
    influence = Influence(UNKNOWN, certificate="none: assumed")
    return Source(NOT_DETERMINED, "B", changes @ changes.T, np.inf, influence)


def _after_corrections(readings: Readings, rest: AtRest, by_rest: Array, ideal: Array) -> list[Source]:
    """Return what is not known of corrections: a constant is the bias, at rest and while the unit turns."""
    off = readings.taken_off.get("gyro", {})
    if rest.fits is None or not off:
        return []
    kept = np.flatnonzero(~rest.outliers)
    gain = np.zeros((21, len(readings), 3))
    for k, fit in enumerate(rest.fits):
        at = np.array([k, 3 + 3 * k, 4 + 3 * k, 5 + 3 * k])[: len(fit.coefficients)]
        gain[:, kept, k] = by_rest[:, at] @ fit.gain / ideal[k]
    turning = np.vstack([-by_rest[:9, :3] / ideal, np.zeros((12, 3))])
    return after_corrections(off, gain, turning)


def _directions_by(acc: Fitted, force: Array) -> Array:
    """Return the derivatives of the directions of gravity by matrix and offset of accelerometers, shape (m, 3, 12)."""
    length = np.linalg.norm(force, axis=1)
    u = force / length[:, None]
    inverse = np.linalg.inv(acc.sensor.matrix)
    across = (np.eye(3) - u[:, :, None] * u[:, None, :]) / length[:, None, None]
    by_offset = -across @ inverse  # (m, 3, 3)
    by_matrix = by_offset[:, :, :, None] * force[:, None, None, :]  # (m, 3, row of A, column of A)
    return np.concatenate([by_matrix.reshape(len(u), 3, 9), by_offset], axis=2)


def _direction_u(acc: Fitted, force: Array) -> Array:
    """Return the standard uncertainty of the direction of gravity in each position, shape (m,) [rad]."""
    wide = _directions_by(acc, force)
    return np.asarray(np.sqrt(np.einsum("mij,jk,mik->m", wide, acc.sensor.covariance, wide)))


def _by_accelerometers(acc: Fitted, rotated: Rotated, force: Array, forward: Array) -> Array:
    """Return what the accelerometers do to the directions of gravity, and these to the matrix, shape (21, 12)."""
    wide = _directions_by(acc, force)
    back = np.zeros((21, 12))
    back[:9] = forward @ np.einsum("wkj,kjq->wq", rotated.by_positions, wide)
    return back


def without_scale(fitted: FittedGyro) -> FittedGyro:
    """Return gyros of no stated scale factor: where rotations do not tell it either, readings are no rates."""
    open_ones = [k for k in range(3) if fitted.sensor.reasons.get(4 * k, NOTHING_LEFT) is not NOTHING_LEFT]
    places = [at for k in open_ones for at in (9 + k, *range(12 + 3 * k, 15 + 3 * k))]
    reasons = dict.fromkeys(places, NO_SCALE) | dict(fitted.sensor.reasons)
    return replace(fitted, sensor=replace(fitted.sensor, reasons=reasons))


def _reasons(
    rest: AtRest,
    rotated: Rotated | None,
    acc: Fitted,
    by_gravity: bool,
    told: NDArray[np.bool_],
    unknown: NDArray[np.bool_],
) -> dict[int, Reason]:
    found: dict[int, Reason] = {}
    if rotated is None:
        found |= dict.fromkeys(range(9), NO_ROTATIONS)
    else:
        found |= {k: NOT_TOLD for k in range(9) if not told[k]}
        if by_gravity:
            found |= {k: NO_GRAVITY for k in range(9) if k not in found and (unknown[k] or acc.free == 0)}
        if rotated.found is None:
            found |= {k: NOTHING_LEFT for k in range(9) if k not in found}
    if rest.fits is None:
        found |= dict.fromkeys(range(9, 12), ONE_PLACE)
    if rest.g_sensitivity is None or rest.fits is None:
        found |= dict.fromkeys(range(12, 21), Reason("no_g_sensitivity", rest.reason) if rest.reason else ONE_PLACE)
    return found

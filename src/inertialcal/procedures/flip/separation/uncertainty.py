"""Uncertainty of a flip from noise slower than a dwell (Type A).

Sub-means inside one dwell say nothing of what wanders from dwell to dwell: with 1/f noise that is most of it. Here the
noise is that of the whole quiet record, and what counts of it are contrasts, as every result is one: ambient
acceleration the half difference of two dwells, bias the half sum less the mean of the record. So ``bias`` means the
mean bias over the record that the flip lies in, and ``ambient_acceleration`` is taken as constant over it: the noise
is taken as the sensor's.

``slow``
    White and 1/f noise by ``statistics.slow_noise`` on block means; level and step at the turns (and a drift in time,
    if the plan has one) are fitted beside, and so is the level of each dwell: an error of the result that is in the
    noise found would widen its own interval, and 95 % would hold 98 % on white noise.
``pairs``
    The same combination of dwells, moved to where the record has quiet stretches as long and as far apart: scatter of
    what should be zero. Assumes no shape of the noise, needs three such places; for a bias the mean at each position
    is taken off before, which makes it a little too small in a short record.

The noise of different axes is taken as independent.

References
----------
.. [1] Chestney and Sicker, NASA TM-106980, 1996: control axis -1.136 ug against an accuracy of 0.36 ug (Tables 5).
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache

import numpy as np

from ....core.errors import DataError
from ....core.estimate import Array, Component
from ....core.key import Origin, Reason
from ....statistics.slow_noise import Blocks, SlowNoise, blocks_of, slow_noise
from ..plan import Plan
from ..readings import Quiet, Readings
from .equations import Separated
from .positions import directions

FEWEST = 3  # pairs
PART = 0.8  # of a window that the blocks of a moved one must fill
NO_RECORD = Reason("no_record", "no record of the noise: readings of a table do not show how it wanders between dwells")
APART = Reason("apart", "the positions lie in different recordings: noise between them is not shown")
DEPENDS = 1e-9  # of a weight, relative to the largest
MEMORY = 8  # shapes of records that are kept: axes and simulated tests share theirs


def noise_components(plan: Plan, readings: Readings, found: Separated) -> tuple[list[Component], Reason]:
    """Return one component an axis, or the reason why there is no uncertainty.

    Parameters
    ----------
    plan : Plan
        Which model.
    readings : Readings
        With the quiet records.
    found : Separated
        One flip.
    """
    if not readings.quiet:
        return [], NO_RECORD
    components = []
    for axis, weights in found.weights.items():
        if not np.any(weights):
            continue
        record = _record(readings, weights)
        if record is None:
            return [], APART
        try:
            covariance, dof, how = _of_axis(plan, record, axis, weights)
        except DataError as error:
            return [], Reason(error.problems[0].code, f"{axis}: {error.problems[0].what}")
        components.append(Component(Origin(f"noise of {axis}: {how}", level="record"), "A", covariance, dof, "t"))
    return components, Reason()


def independent(plan: Plan, record: Quiet, lines: Mapping[str, Array]) -> tuple[Array, Array, Array]:
    """Return independent directions of combinations of dwells, by the record's slow noise alone.

    Parameters
    ----------
    plan, record : Plan, Quiet
        Whose noise.
    lines : mapping of str to ndarray, shape (r, n)
        Weights of the dwells of each axis; a combination is the sum over the axes.

    Returns
    -------
    directions : ndarray, shape (r, r)
        Orthonormal, a row each.
    variance, dof : ndarray, shape (r,)
        Of each; degrees of freedom by Welch and Satterthwaite.

    Raises
    ------
    DataError
        If the record does not show its noise.
    """
    records = {axis: record.of(axis) for axis, weights in lines.items() if np.any(weights)}
    used = {axis: _contrasts(own, lines[axis]) for axis, own in records.items()}
    noises = {axis: slow_noise(own.means[axis], _shape(plan, own), used[axis]) for axis, own in records.items()}
    whole = np.asarray(sum(_covariance(noises[axis], record, contrasts) for axis, contrasts in used.items()))
    directions = np.linalg.eigh(whole)[1].T
    variance, spread = np.zeros(len(whole)), np.zeros(len(whole))
    for axis, contrasts in used.items():
        for i, line in enumerate(_small_to_zero(directions) @ contrasts):
            if np.any(np.abs(line) > DEPENDS * np.abs(contrasts).max()):
                own, dof = noises[axis].variance(line - line.mean())
                variance[i] += own
                spread[i] += own**2 / dof
    return directions, variance, variance**2 / np.maximum(spread, np.finfo(float).tiny)


def _covariance(noise: SlowNoise, record: Quiet, contrasts: Array) -> Array:
    white = contrasts @ contrasts.T * (noise.white / (2.0 * record.length))
    whole = white + noise.flicker * (contrasts @ noise.blocks.flicker @ contrasts.T)
    return np.asarray(0.5 * (whole + whole.T))


def record_of(readings: Readings, weights: Mapping[str, Array]) -> Quiet | None:
    """Return the recording that all dwells with a weight lie in; None where there is none."""
    return _record(readings, np.vstack(list(weights.values()))) if weights else None


def _of_axis(plan: Plan, record: Quiet, axis: str, weights: Array) -> tuple[Array, Array, str]:
    record = record.of(axis)
    if not len(record.times):
        raise DataError("no block of the record is quiet and whole", do="Record longer", code="too_few_blocks")
    if plan.noise == "pairs":
        return _pairs(plan, record, axis, weights)
    try:
        return _slow(plan, record, axis, weights)
    except DataError as error:
        try:
            return _pairs(plan, record, axis, weights)
        except DataError as other:
            raise DataError(f"{error.problems[0].what}; {other.problems[0].what}") from None


def _record(readings: Readings, weights: Array) -> Quiet | None:
    used = np.any(weights != 0.0, axis=0)
    return next((one for one in readings.quiet if np.all(one.dwells[used])), None)


def _slow(plan: Plan, record: Quiet, axis: str, weights: Array) -> tuple[Array, Array, str]:
    contrasts = _contrasts(record, weights)
    noise = slow_noise(record.means[axis], _shape(plan, record), contrasts)
    dof = np.array([noise.variance(line)[1] if np.any(line) else np.inf for line in contrasts])
    return _covariance(noise, record, contrasts), dof, "white and 1/f, by its quiet record"


def _contrasts(record: Quiet, weights: Array) -> Array:
    """Weights of the blocks in each result, shape (p, m); less the mean of the record where they make a mean."""
    weights = _small_to_zero(weights)
    if np.any(np.any(weights != 0.0, axis=0) & ~np.any(record.weights, axis=1)):
        what = "no block of a window has all its samples"
        raise DataError(what, why="its noise is not shown", do="Choose another window", code="too_few_blocks")
    lines = weights @ record.weights
    return np.asarray(lines - lines.sum(axis=1, keepdims=True) / lines.shape[1])


def _small_to_zero(weights: Array) -> Array:
    largest = np.abs(weights).max(axis=1, keepdims=True, initial=0.0)
    return np.where(np.abs(weights) > DEPENDS * largest, weights, 0.0)


def _shape(plan: Plan, record: Quiet) -> Blocks:
    """Return what does not depend on the readings, made once for all axes."""
    steps = directions(record.angle)
    since = (record.times - record.times.mean())[:, None]
    drift = {"bias": [since], "ambient": [since * steps]}.get(plan.drift, [])
    beside = np.column_stack([steps, *drift, record.weights[record.dwells].T])
    design = np.column_stack([np.ones(len(record.times)), _independent(beside - beside.mean(axis=0))])
    return _remembered(record.times.tobytes(), record.length, design.tobytes(), design.shape[1])


def _independent(columns: Array) -> Array:
    """Return orthonormal columns that span the same."""
    length = np.sqrt(np.sum(columns**2, axis=0))
    basis, s, _ = np.linalg.svd(columns / np.where(length > 0.0, length, 1.0), full_matrices=False)
    return np.asarray(basis[:, s > DEPENDS * s.max(initial=0.0)])


@lru_cache(MEMORY)
def _remembered(times: bytes, length: float, design: bytes, columns: int) -> Blocks:
    return blocks_of(np.frombuffer(times), length, np.frombuffer(design).reshape(-1, columns))


def _pairs(plan: Plan, record: Quiet, axis: str, weights: Array) -> tuple[Array, Array, str]:
    """Scatter of the same combination of dwells where the head was not turned."""
    design = np.column_stack([np.ones(len(record.times)), *directions(record.angle).T])
    level = design @ np.linalg.lstsq(design, record.means[axis], rcond=None)[0]
    used = np.flatnonzero(np.any(weights != 0.0, axis=0))
    moved = np.array(_moved(record, record.means[axis] - level, record.spans[used])).reshape(-1, len(used))
    count = len(moved)
    if count < FEWEST:
        what = f"{count} quiet places as long and as far apart as its dwells: need {FEWEST}"
        raise DataError(what, do="Record longer", code="too_few_pairs")
    should_be_zero = moved @ weights[:, used].T
    covariance = should_be_zero.T @ should_be_zero / count
    return covariance, np.full(len(weights), float(count)), f"{count} quiet stretches as long and as far apart"


def _moved(record: Quiet, rest: Array, spans: Array) -> list[Array]:
    """Means of the windows of a flip, moved along the record without overlap, where it is quiet and not turned."""
    span = spans - spans.min()
    own = (float(spans.min()), float(spans.max()))
    half, free, found = 0.5 * record.length, -np.inf, []
    for start in record.times - half:
        stop = start + span.max()
        if start < free or (start < own[1] and stop > own[0]):
            continue
        inside = (record.times >= start) & (record.times <= stop)
        held = [(record.times - half >= a - DEPENDS) & (record.times + half <= b + DEPENDS) for a, b in span + start]
        need = [PART * (b - a) / record.length for a, b in span]
        whole = all(one.sum() >= enough for one, enough in zip(held, need, strict=True))
        if whole and len(np.unique(record.angle[inside])) == 1:
            found.append(np.array([rest[one].mean() for one in held]))
            free = stop
    return found

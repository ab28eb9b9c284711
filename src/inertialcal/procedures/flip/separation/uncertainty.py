"""Uncertainty of a flip: noise slower than a dwell (Type A), and standards that are not exact (Type B).

**Noise.** Sub-means inside one dwell say nothing about what wanders from dwell to dwell: with 1/f noise that is most of
it. The noise is therefore taken from the whole quiet record. ``bias`` means the mean over that record of what wanders
slowly, of which white noise is no part; ``ambient_acceleration`` likewise.

``slow``
    White and slow noise, and a drift, of head or ambient acceleration, by ``separation.noise``.
``pairs``
    The same combination of dwells, moved to where the record has quiet stretches as long and as far apart: scatter of
    values that should be zero. Assumes no shape of the noise and needs three such places. For a bias the mean at each
    position is removed first, which makes the uncertainty a little too small in a short record.

The noise of different axes is taken as independent.

**Standards**, one unknown value each for the whole test:

turn angle
    Every position but 0 is off by the same angle u: a reading there changes by ``dC/dtheta g u``. In a half turn the
    other turned axis enters: ``G_y`` and ``B_y`` change by ``g_z u / 2``.
turn axis
    The true axis of the turn is off the stated one by two small angles, each with u: the readings change by
    ``([e] C - C [e]) g``. Ambient acceleration along the turn, which no flip separates from bias, is taken as large as
    that across it.
converter zero
    An offset of the electronics of each axis, u in its bias.
scale factor
    A relative error of each axis: of its readings, and of the bias that was subtracted before: ``plan.raw_bias``, or
    where that is 0 the prediction of the ground model.

References
----------
.. [1] Chestney and Sicker, NASA TM-106980, 1996: control axis -1.136 ug against an accuracy of 0.36 ug (Tables 5).
.. [2] JCGM 100:2008 (GUM), 4.3 and 5.2.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import lru_cache

import numpy as np

from ....core.errors import DataError
from ....core.estimate import Array, Component, joined_dof
from ....core.key import AXES, Key, Origin, Reason
from ....statistics.slow_noise import Blocks, SlowNoise, blocks_of, slow_noise
from ..plan import INFLUENCES, Plan
from ..readings import Quiet, Readings
from .equations import AMBIENT, BIAS, SAME, Separated, directions, slope, tilted
from .noise import noise_of

FEWEST = 3  # pairs
PART = 0.8  # of a window that the blocks of a moved one must fill
NO_RECORD = Reason("no_record", "no record of the noise: a table of means does not show how it wanders between dwells")
APART = Reason("apart", "the positions lie in different recordings: the noise between them is not known")
DEPENDS = 1e-9  # of a weight, relative to the largest
MEMORY = 8  # shapes of records that are kept: axes and simulated tests share theirs

Patterns = dict[str, Array]  # of each influence, shape (q, p): changes of the values, one standard uncertainty each

NAMES = {
    "turn.angle": "turn angle",
    "turn.axis": "axis of the turn",
    "converter.zero": "zero of the electronics",
    "sensor.scale_factor": "scale factor",
}


def noise_components(
    plan: Plan, readings: Readings, flip: Separated, without_drift: bool = False
) -> tuple[list[Component], Reason]:
    """Return one component per axis of a flip, or the reason why there is no uncertainty.

    ``without_drift``: of white and 1/f noise alone, as a control axis is tested.
    """
    if not readings.quiet:
        return [], NO_RECORD
    components = []
    for axis, weights in flip.weights.items():
        if not np.any(weights):
            continue
        record = record_of(readings, {axis: weights})
        if record is None:
            return [], APART
        try:
            covariance, dof, method = _of_axis(plan, record.of(axis), axis, weights, without_drift)
        except DataError as error:
            return [], Reason(error.problems[0].code, f"{axis}: {error.problems[0].what}")
        components.append(Component(Origin(f"noise of {axis}: {method}", level="record"), "A", covariance, dof, "t"))
    return components, Reason()


def next_record(plan: Plan, readings: Readings, flip: Separated) -> dict[Key, tuple[float, float]]:
    """Return u and degrees of freedom of each bias as that of the next record; empty where the noise is not known."""
    found = {}
    for axis in plan.turned:
        key = Key(BIAS, axis)
        record = record_of(readings, flip.weights)
        if key not in flip.keys or record is None or plan.noise == "pairs":
            continue
        at, squares, free = flip.keys.index(key), [], []
        for other, weights in flip.weights.items():
            if not np.any(weights[at]):
                continue
            try:
                own = record.of(other)
                noise = noise_of(own, other, other != plan.axis, plan.drift)
                u, dof = noise.next_record(_lines(own, weights[at : at + 1])[0])
            except DataError:
                return {}
            squares.append(np.array([u**2]))
            free.append(np.array([dof]))
        found[key] = (float(np.sqrt(np.sum(squares))), float(joined_dof(squares, free)[0]))
    return found


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


def record_of(readings: Readings, weights: Mapping[str, Array]) -> Quiet | None:
    """Return the recording that all dwells with a weight lie in; None where there is none."""
    if not weights:
        return None
    used = np.any(np.vstack(list(weights.values())) != 0.0, axis=0)
    return next((one for one in readings.quiet if np.all(one.dwells[used])), None)


def _of_axis(plan: Plan, record: Quiet, axis: str, weights: Array, without_drift: bool) -> tuple[Array, Array, str]:
    """Return covariance, degrees of freedom and method of the noise of one axis."""
    if not len(record.times):
        raise DataError("no block of the record is quiet and complete", do="Record longer", code="too_few_blocks")
    if plan.noise == "pairs":
        return _pairs(record, axis, weights)
    try:
        noise = noise_of(record, axis, axis != plan.axis, plan.drift)
        noise = noise.without_drift() if without_drift else noise
        return *noise.covariance(_lines(record, weights)), "white, slow and drift, by its quiet record"
    except DataError as error:
        try:
            return _pairs(record, axis, weights)
        except DataError as other:
            raise DataError(f"{error.problems[0].what}; {other.problems[0].what}") from None


def _covariance(noise: SlowNoise, record: Quiet, contrasts: Array) -> Array:
    white = contrasts @ contrasts.T * (noise.white / (2.0 * record.length))
    whole = white + noise.flicker * (contrasts @ noise.blocks.flicker @ contrasts.T)
    return np.asarray(0.5 * (whole + whole.T))


def _contrasts(record: Quiet, weights: Array) -> Array:
    """Weights of the blocks in each result, shape (p, m); less the mean of the record where they make a mean."""
    lines = _lines(record, weights)
    return np.asarray(lines - lines.sum(axis=1, keepdims=True) / lines.shape[1])


def _lines(record: Quiet, weights: Array) -> Array:
    """Weights of the blocks in each result, shape (p, m)."""
    weights = _small_to_zero(weights)
    if np.any(np.any(weights != 0.0, axis=0) & ~np.any(record.weights, axis=1)):
        what = "no block of a window has all its samples"
        raise DataError(what, why="its noise is not known", do="Choose another window", code="too_few_blocks")
    return np.asarray(weights @ record.weights)


def _small_to_zero(weights: Array) -> Array:
    largest = np.abs(weights).max(axis=1, keepdims=True, initial=0.0)
    return np.where(np.abs(weights) > DEPENDS * largest, weights, 0.0)


def _shape(plan: Plan, record: Quiet) -> Blocks:
    """Return blocks and design of the noise model: independent of the readings, computed once for all axes."""
    steps = directions(record.angle)
    since = (record.times - record.times.mean())[:, None]
    drift = {"bias": [since], "ambient": [since * steps]}.get(plan.drift, [])
    fitted = np.column_stack([steps, *drift, record.weights[record.dwells].T])
    fitted = fitted - fitted.mean(axis=0)
    length = np.sqrt(np.sum(fitted**2, axis=0))
    basis, s, _ = np.linalg.svd(fitted / np.where(length > 0.0, length, 1.0), full_matrices=False)
    design = np.column_stack([np.ones(len(record.times)), np.asarray(basis[:, s > DEPENDS * s.max(initial=0.0)])])
    return _remembered(record.times.tobytes(), record.length, design.tobytes(), design.shape[1])


@lru_cache(MEMORY)
def _remembered(times: bytes, length: float, design: bytes, columns: int) -> Blocks:
    return blocks_of(np.frombuffer(times), length, np.frombuffer(design).reshape(-1, columns))


def _pairs(record: Quiet, axis: str, weights: Array) -> tuple[Array, Array, str]:
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
    half, free, places = 0.5 * record.length, -np.inf, []
    for start in record.times - half:
        stop = start + span.max()
        if start < free or (start < own[1] and stop > own[0]):
            continue
        inside = (record.times >= start) & (record.times <= stop)
        held = [(record.times - half >= a - DEPENDS) & (record.times + half <= b + DEPENDS) for a, b in span + start]
        need = [PART * (b - a) / record.length for a, b in span]
        whole = all(one.sum() >= enough for one, enough in zip(held, need, strict=True))
        if whole and len(np.unique(record.angle[inside])) == 1:
            places.append(np.array([rest[one].mean() for one in held]))
            free = stop
    return places


def missing(plan: Plan) -> list[str]:
    """Return the influences that have no stated uncertainty."""
    return [name for name in INFLUENCES if name not in plan.standards]


def patterns(plan: Plan, readings: Readings, flip: Separated) -> Patterns:
    """Return the changes of the values of a flip that each stated influence makes.

    Returns
    -------
    dict of str to ndarray, shape (q, p)
        q independent unknowns, each one standard uncertainty; SI.
    """

    def changes(change: Array) -> Array:  # of the values for changes of the readings, shape (n, 3)
        parts = [weights @ change[:, AXES.index(axis)] for axis, weights in flip.weights.items()]
        return np.asarray(np.sum(parts, axis=0))

    across, along = np.zeros(3), np.zeros(3)  # ambient acceleration: as found, and as large along the turn
    for axis in plan.turned:
        across[AXES.index(axis)] = flip.value(Key(AMBIENT, axis)) or 0.0
    along[AXES.index(plan.axis)] = math.hypot(*across)
    made: Patterns = {}
    for name in (one for one in NAMES if one in plan.standards):
        if name == "turn.angle":
            turned = np.abs(readings.angle) > SAME
            unit = changes(turned[:, None] * (slope(plan.axis, readings.angle) @ across))[None, :]
        elif name == "turn.axis":
            tilts = [tilted(plan.axis, readings.angle, np.eye(3)[AXES.index(axis)]) for axis in plan.turned]
            unit = np.array([changes(tilt @ one) for tilt in tilts for one in (across, along)])
        elif name == "converter.zero":
            unit = np.array([weights.sum(axis=1) for weights in flip.weights.values()])
        else:
            unit = np.array([weights @ _raw(plan, readings, axis) for axis, weights in flip.weights.items()])
        made[name] = plan.standards[name].u * unit
    return made


def _raw(plan: Plan, readings: Readings, axis: str) -> Array:
    """Return the readings with the bias that was subtracted before: as the plan says, else as the model predicts."""
    raw = np.nan_to_num(readings.outputs[axis])
    if plan.raw_bias != 0.0 or not plan.corrected or axis not in readings.predicted:
        return np.asarray(raw + plan.raw_bias)
    return np.asarray(raw + np.nan_to_num(readings.predicted[axis]))


def components(plan: Plan, parts: Patterns, flip: Separated) -> list[Component]:
    """Return the Type B components that patterns make; unknowns go by the axis that they belong to."""
    read = tuple(flip.weights)
    unknowns = {
        "turn.axis": tuple(f"{axis}, {way}" for axis in plan.turned for way in ("across", "along")),
        "converter.zero": read, "sensor.scale_factor": read,
    }  # fmt: skip
    made = []
    for name, pattern in parts.items():
        one = plan.standards[name]
        covariance = pattern.T @ pattern
        origin = one.origin(NAMES[name])
        named = unknowns.get(name, ())
        made.append(Component(origin, "B", covariance, one.dof, one.distribution, one.stated, pattern, named))
    return made

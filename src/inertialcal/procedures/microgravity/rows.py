"""Rows of the environment, their intervals, and what was found in a sentence."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ...core.key import AXES, At, Key, Reason
from ...core.results import Interval, Row, WrittenRow, not_estimated
from ...core.show.rows import Cited, Sentence, estimated
from ...statistics.intervals import coverage_factor
from .plan import (
    INTERVAL_MEAN,
    MAGNITUDE,
    ORBITAL,
    PERIOD,
    PERPENDICULAR,
    RATIO,
    RSS,
    SCALE,
    SLOW,
    VIBRATORY,
)

if TYPE_CHECKING:
    from ...core.estimate import Array, Estimate
    from .bands import Power
    from .reduction import Result

P = 0.95
ALL = "all"
NO_BIAS = Reason("bias_unknown", "the bias is not known: state it, or take off what a flip found")
FEW = Reason("few_blocks", "too few blocks that follow each other")
DIRECTED = 3.0  # times its standard uncertainty, from which the mean has a direction
NO_DIRECTION = Reason("no_direction", "the mean is too small beside its uncertainty to point anywhere")
NO_AXES = Reason("no_axes", "all three axes are needed")


def rows(result: Result) -> list[Row]:
    """Return the rows, SI."""
    found = []
    for axis in (*result.axes, *([RSS] if len(result.axes) == len(AXES) else [])):
        one = result.powers.get((axis, ALL))
        key = Key(VIBRATORY, axis)
        if one is None:
            found.append(not_estimated(key, "m/s^2", Reason("no_bands", "no band lies in the pass band")))
            continue
        shared = {SCALE: one.rms * one.u} if one.u else {}
        found.append(Row(key, one.rms, one.u_rms, "m/s^2", one.dof, one.interval(P), shared=shared))
    return [*found, *_ratio(result), *_slow(result), *_orbital(result)]


def _ratio(result: Result) -> list[Row]:
    """Return the band that comes nearest to the curve; its interval holds for all bands together."""
    if result.readings.requirement is None:
        return []
    if len(result.axes) < len(AXES):
        return [not_estimated(Key(RATIO, RSS), "1", NO_AXES)]
    at = worst(result)
    if at is None:
        return [not_estimated(Key(RATIO, RSS), "1", Reason("no_bands", "no band that is estimated has a limit"))]
    one, limit, count = result.power(RSS, result.bands[at]), float(result.limits[at]), judged(result)
    reason = Reason("simultaneous", f"highest of {count} bands; the interval holds for all of them together")
    key = Key(RATIO, RSS, at=At("frequency", result.bands[at].nominal, "Hz"))
    shared = {SCALE: one.rms / limit * one.u} if one.u else {}
    return [Row(key, one.rms / limit, one.u_rms / limit, "1", one.dof, ratio_interval(result, P), reason=reason,
                shared=shared)]  # fmt: skip


def judged(result: Result) -> int:
    """Return how many bands have a limit."""
    return int(np.count_nonzero(np.isfinite(result.limits)))


def worst(result: Result) -> int | None:
    """Return the band that comes nearest to its limit, or lies highest above it; None where none has a limit."""
    ratios = [result.power(RSS, one).rms / limit if math.isfinite(limit) else -math.inf
              for one, limit in zip(result.bands, result.limits.tolist(), strict=True)]  # fmt: skip
    return int(np.argmax(ratios)) if ratios and math.isfinite(max(ratios)) else None


def ratio_interval(result: Result, p: float) -> Interval:
    """Return the interval of the highest of all true ratios: each band's holds for all of them together."""
    each = 1.0 - (1.0 - p) / max(judged(result), 1)
    ends = []
    for one, limit in zip(result.bands, result.limits.tolist(), strict=True):
        if math.isfinite(limit):
            own = result.power(RSS, one).interval(each)
            ends.append((float(own.lo or 0.0) / limit, float(own.hi or 0.0) / limit))
    return Interval(max(low for low, _ in ends), max(high for _, high in ends), p)


def _slow(result: Result) -> list[Row]:
    if result.trend is None or result.estimate is None:
        why = FEW if result.trend is None else NO_BIAS if len(result.axes) == len(AXES) else NO_AXES
        found = [not_estimated(Key(SLOW, axis), "m/s^2", why) for axis in result.axes]
        found += [not_estimated(Key(name, ""), "m/s^2", why) for name in (MAGNITUDE, PERPENDICULAR)]
        return [*_means(result), *found]
    one, found = result.estimate, []
    for i, key in enumerate(one.keys):
        value, u, dof = float(one.values[i]), float(one.u[i]), float(one.dof[i])
        half = coverage_factor(dof, P) * u
        ends = Interval(value - half, value + half, P)
        found.append(Row(key, value, u, "m/s^2", None if math.isinf(dof) else dof, ends, shared=one.shared(key)))
    lacking = [axis for axis in result.axes if axis not in {key.axis for key in one.keys}]
    found += [not_estimated(Key(SLOW, axis), "m/s^2", NO_BIAS) for axis in lacking]
    for name in (MAGNITUDE, PERPENDICULAR):
        if lacking:
            found.append(not_estimated(Key(name, ""), "m/s^2", NO_BIAS))
            continue
        if name == PERPENDICULAR and not _has_direction(one):
            found.append(not_estimated(Key(name, ""), "m/s^2", NO_DIRECTION))
            continue
        value, u = size(result, name)
        found.append(Row(Key(name, ""), value, u, "m/s^2", None, size_interval(result, name, P)))
    return [*_means(result), *found]


def _has_direction(estimate: Estimate) -> bool:
    """Tell whether the mean is known to point somewhere: longer than three of its largest standard uncertainty."""
    largest = math.sqrt(max(float(np.linalg.eigvalsh(estimate.covariance)[-1]), 0.0))
    return float(np.linalg.norm(estimate.values)) > DIRECTED * largest


def _means(result: Result) -> list[Row]:
    """Return the mean of each axis over the record as it was read, what was stated of the bias taken off."""
    if result.trend is None:
        return []
    known = set() if result.estimate is None else {key.axis for key in result.estimate.keys}
    values, u = result.trend.values.mean(axis=0), result.trend.noise / math.sqrt(len(result.trend.times))
    factor = coverage_factor(result.trend.dof, P)
    return [Row(Key(INTERVAL_MEAN, axis), float(value), float(own), "m/s^2", result.trend.dof,
                Interval(float(value - factor * own), float(value + factor * own), P))
            for axis, value, own in zip(result.axes, values, u, strict=True) if axis not in known]  # fmt: skip


def _vectors(result: Result, name: str) -> tuple[Array, Array]:
    """Return vectors whose largest is told, shape (k, 3), and the covariance of each, shape (3, 3)."""
    assert result.trend is not None and result.estimate is not None  # noqa: S101, PT018 - callers know
    values, mean = result.trend.values, result.estimate.values
    scatter = np.diag(result.trend.noise**2)
    known = result.estimate.covariance - result.estimate.components[0].covariance
    if name == MAGNITUDE:
        if result.plan.magnitude == "mean":
            return mean[None, :], result.estimate.covariance
        return values, scatter + known
    along = mean / max(float(np.linalg.norm(mean)), 1e-300)
    across = values - np.outer(values @ along, along)
    project = np.eye(len(AXES)) - np.outer(along, along)
    # An error common to all blocks turns the mean too: of a block of the mean's own length nothing of it is left
    turned = float(np.max((1.0 - values @ along / max(float(np.linalg.norm(mean)), 1e-300)) ** 2))
    return across, project @ (scatter + turned * known) @ project


def size(result: Result, name: str) -> tuple[float, float]:
    """Return the largest size of vectors, with its standard uncertainty [m/s^2]."""
    vectors, covariance = _vectors(result, name)
    lengths = np.linalg.norm(vectors, axis=1)
    at = int(np.argmax(lengths))
    along = vectors[at] / max(float(lengths[at]), 1e-300)
    return float(lengths[at]), math.sqrt(max(float(along @ covariance @ along), 0.0))


def size_interval(result: Result, name: str, p: float) -> Interval:
    """Return the interval of the largest true size: no error of a vector moves its length by more than its own length.

    The sphere about each vector holds for all blocks together; where there is one vector much longer than its
    uncertainty, the interval is Student's along it.
    """
    from scipy.stats import f  # noqa: PLC0415 - starts slowly

    vectors, covariance = _vectors(result, name)
    lengths, dof = np.linalg.norm(vectors, axis=1), result.trend.dof if result.trend is not None else math.inf
    largest = math.sqrt(max(float(np.linalg.eigvalsh(covariance)[-1]), 0.0))
    value, u = size(result, name)
    if len(vectors) == 1 and value > 3.0 * largest:
        own = float(np.min(result.estimate.dof)) if result.estimate is not None else dof
        half = coverage_factor(own, p) * u
        return Interval(value - half, value + half, p)
    free = 3 if name == MAGNITUDE else 2
    reach = largest * math.sqrt(free * float(f.isf((1.0 - p) / len(vectors), free, max(dof, 1.0))))
    return Interval(max(float(lengths.max()) - reach, 0.0), float(lengths.max()) + reach, p)


def _orbital(result: Result) -> list[Row]:
    one = result.orbit
    if one is None:
        return []
    dof = math.inf if result.trend is None else result.trend.dof
    found = [Row(Key(ORBITAL, axis), float(value), float(u), "m/s^2", None if math.isinf(dof) else dof,
                 amplitude_interval(float(value), float(u), dof))
             for axis, value, u in zip(result.axes, one.amplitude, one.u, strict=True)]  # fmt: skip
    if one.u_period is not None:
        half = 1.96 * one.u_period
        found.append(Row(Key(PERIOD, ""), one.period, one.u_period, "s", None,
                         Interval(one.period - half, one.period + half, P)))  # fmt: skip
    return found


def amplitude_interval(value: float, u: float, dof: float) -> Interval:
    """Return the 95 % interval of an amplitude, of which noise of two phases makes up u each.

    Noise alone has an amplitude, too: the lower end is the one that gives as much or more in 2.5 % of records
    (noncentral chi-square), and zero where none does. The upper end is as of one phase, and holds for any amplitude.
    """
    from scipy.optimize import brentq  # noqa: PLC0415 - start slowly
    from scipy.stats import chi2, ncx2  # noqa: PLC0415

    half = coverage_factor(dof, P) * u
    if u <= 0.0:
        return Interval(value, value, P)
    square, tail = (value * coverage_factor(math.inf, P) / half) ** 2, 0.5 * (1.0 - P)
    low = 0.0
    if float(chi2.sf(square, 2)) < tail:
        root = brentq(lambda a: float(ncx2.sf(square, 2, a * a)) - tail, 1e-9, math.sqrt(square))
        low = root * half / coverage_factor(math.inf, P)
    return Interval(low, value + half, P)


def interval_at(result: Result, row: Row, p: float) -> Interval | None:
    """Return the interval of another probability of a row; None where it has none of its own."""
    if row.key.quantity == VIBRATORY:
        one: Power | None = result.powers.get((row.key.axis, ALL))
        return None if one is None else one.interval(p)
    if row.key.quantity == RATIO and row.value is not None:
        return ratio_interval(result, p)
    if row.key.quantity in (MAGNITUDE, PERPENDICULAR) and row.value is not None:
        return size_interval(result, row.key.quantity, p)
    return None


def finding(rows: Sequence[WrittenRow]) -> Sentence:
    """Say the level, how far it is from the curve, and the slow acceleration."""
    said: Sentence = ()
    for quantity, axis, before in ((VIBRATORY, RSS, ""), (RATIO, RSS, ", "), (MAGNITUDE, "", ", slow acceleration ")):
        row = next((one for one in estimated(rows, quantity) if one["axis"] == axis), None)
        if row is not None:
            said = (*said, before if said else "", Cited(row))
            said = (*said, " of the curve") if quantity == RATIO else said
    return said or ("No level of all axes together could be estimated",)


__all__ = ["finding", "interval_at", "rows"]

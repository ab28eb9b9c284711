"""Which runs of a sensor over temperature disagree with the others: sign, unit, another curve.

The bias over temperature of a run, bin by bin and path by path, is held against the median of all runs (of two, against
the other). Offsets of runs are free: each power-up has its own. What is compared:

response
    the slope of the run's curve over the usual curve, by repeated medians: 1 of a sound run, -1 of a turned sign;
noise
    the scatter within its bins over the usual one: a run in rad/s has that of deg/s over 57.3, whatever its curve;
shape
    the scatter about the usual curve.

No nominal is known: of one run nothing can be told but that it is stuck, of two not which is wrong.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ....core.estimate import Array
from ....core.remarks import Remark, Severity
from ....statistics.agreement import repeated_median_line, robust_scale
from ...agreement import Cause, unit_mistaken
from ..recordings import Readings
from .cells import Cells, Indices

KINDS = {"rad/s": "angular_rate", "m/s^2": "acceleration"}
FEWEST = 6  # bins that two curves must share
EFFICIENCY = 0.64  # of a repeated median
RESOLVED = 0.1  # largest standard error of a response that tells its sign
FEWEST_RUNS = 4  # so that most of them can be right
FAR = 8.0  # times the distance of the others from each other
LEVEL = 0.5  # relative difference of the levels of runs, which have offsets of their own
ROUNDING = 1e-12  # of means of equal readings
MUCH = 0.2  # relative difference of a response from which a model would be wrong


@dataclass(frozen=True, eq=False)
class Curves:
    """The runs of one sensor, a row each."""

    response: Array  # shape (r,): of the usual curve; NaN where it cannot be told
    u: Array  # shape (r,): standard error of it
    level: Array  # shape (r,): over the usual one
    noise: Array  # shape (r,): scatter within bins, over the usual one
    apart: Array  # shape (r,): distance from the other curves, after offsets [unit of the readings]
    far: Array  # shape (r,): the same, over that of the others
    size: float  # of the usual curve [unit of the readings]


def disagreements(axis: str, cells: Cells, readings: Readings) -> list[Remark]:
    """Return a remark for each run of one sensor that is stuck, or disagrees with the others."""
    runs = np.unique(cells.run) if cells.runs > 1 else cells.run[:1]
    found = [one for run in runs for one in _stuck(axis, cells, run, readings)]
    if len(runs) < 2 or found:
        return found
    curves = _curves(cells, runs)
    for i, run in enumerate(runs):
        label = readings.labels[run]
        sweep = next(one for one in readings.sweeps if one.run == label)
        cause = _cause(curves, i, axis, readings.unit)
        severity: Severity = "error"
        if cause is None and len(runs) >= FEWEST_RUNS and curves.far[i] > FAR:
            cause = _different(curves, i, axis)
            severity = "error" if curves.apart[i] > MUCH * curves.size else "warning"
        if cause is not None:
            name = sweep.name or sweep.place
            name += f", run {label}" if label not in (name, sweep.place) else ""
            found.append(cause.remark(name, sweep.place, axis, severity))
    return found


def _stuck(axis: str, cells: Cells, run: int, readings: Readings) -> list[Remark]:
    own = cells.ends if cells.runs == 1 else cells.reading[cells.run == run]
    low, high = float(min(own)), float(max(own))
    if high - low > ROUNDING * max(abs(low), abs(high)):
        return []
    place = next(one.place for one in readings.sweeps if one.run == readings.labels[run])
    what = f"{axis} sensor: all readings are equal, at every temperature"
    return [Remark("constant", "error", what, place, do="Check for a stuck or disconnected channel")]


def _curves(cells: Cells, runs: Indices) -> Curves:
    size = int(cells.bin.max()) + 1
    table, within = np.full((2, len(runs), 3 * size), np.nan)
    for row, run in enumerate(runs):
        own = cells.run == run
        key = (cells.path[own] + 1) * size + cells.bin[own]
        weight = np.bincount(key, cells.weight[own], 3 * size)
        for target, values in ((table, cells.reading), (within, cells.scatter)):
            total = np.bincount(key, cells.weight[own] * values[own], 3 * size)
            target[row] = np.divide(total, weight, out=target[row], where=weight > 0.0)
    shared = np.isfinite(table).sum(axis=0) >= max(2, (len(runs) + 1) // 2)
    table, within = table[:, shared], within[:, shared]
    response, u, level = np.full((3, len(runs)), np.nan)
    usual_size = 0.0
    for i in range(len(runs)):
        others = slice(None) if len(runs) > 2 else slice(1 - i, 2 - i)
        usual = _middles(table[others])
        both = np.isfinite(usual) & np.isfinite(table[i])
        x, y = usual[both], table[i][both]
        if len(x) < FEWEST:
            continue
        response[i], start = repeated_median_line(x, y)
        spread = float(np.sum((x - x.mean()) ** 2))
        scale, _ = robust_scale(y - start - response[i] * x, 2)
        u[i] = scale / np.sqrt(EFFICIENCY * spread) if spread > 0.0 else np.inf
        level[i] = float(np.median(y) / np.median(x))
        usual_size = max(usual_size, float(np.std(x)))
    # Of the distances to the others the middle one, the lower of two: nearly half of the runs may be bad
    between = np.sort([[_apart(one, other) for other in table] for one in table], axis=1)  # own distance 0 first
    count = np.isfinite(between).sum(axis=1)
    apart = np.array([row[n // 2] if n > 1 else np.nan for row, n in zip(between, count, strict=True)])
    rest = np.array([_middle(np.delete(apart, i)) for i in range(len(runs))])
    far = np.divide(apart, rest, out=np.zeros_like(apart), where=rest > 0.0)
    scatter = np.array([_middle(row) for row in within])
    rest = np.array([_middle(np.delete(scatter, i)) for i in range(len(runs))])
    noise = np.divide(scatter, rest, out=np.full_like(rest, np.nan), where=rest > 0.0)
    return Curves(response, u, level, noise, apart, far, usual_size)


def _middle(values: Array) -> float:
    """Median of what there is; NaN where there is nothing."""
    there = values[np.isfinite(values)]
    return float(np.median(there)) if len(there) else np.nan


def _middles(table: Array) -> Array:
    """Median of what there is in each column; NaN where there is nothing."""
    rising = np.sort(np.where(np.isfinite(table), table, np.nan), axis=0)  # NaN last
    count = np.isfinite(rising).sum(axis=0)
    column, last = np.arange(len(count)), np.maximum(count, 1)
    return np.asarray(0.5 * (rising[(last - 1) // 2, column] + rising[last // 2, column]))


def _apart(one: Array, other: Array) -> float:
    """Root mean square difference of two curves after their offset; NaN with few bins in common."""
    difference = (one - other)[np.isfinite(one) & np.isfinite(other)]
    return float(difference.std()) if len(difference) >= FEWEST else np.nan


def _cause(curves: Curves, i: int, axis: str, unit: str) -> Cause | None:
    """Return a turned sign or another unit; None where neither is likely."""
    response, u, noise = curves.response[i], curves.u[i], curves.noise[i]
    if not np.isfinite(response):
        return None
    resolved = u < RESOLVED * max(abs(response), 1.0)
    taken = unit_mistaken(noise, KINDS.get(unit, "")) if np.isfinite(noise) else ""
    reads = f"{axis} reads {response:+.3g} of what the other runs read over temperature"
    if taken and (not resolved or (abs(response) < 1.0) == (noise < 1.0)):
        what = f"{reads}, and its noise is {noise:.3g} of theirs: {taken}"
        return Cause("unit_disagrees", what, "State the unit of this recording")
    # Curves that have nothing in common have any response: all must be 1 or -1, and the levels of few runs too
    alike = np.abs(np.abs(curves.response[np.isfinite(curves.response)]) - 1.0) <= MUCH
    few = len(alike) < FEWEST_RUNS
    if resolved and response < 0.0 and alike.all() and (not few or abs(curves.level[i] + 1.0) <= LEVEL):
        return Cause("sign_disagrees", f"{reads}: the sign is inverted", "Check the sign of the column, the mounting")
    return None


def _different(curves: Curves, i: int, axis: str) -> Cause:
    what = f"{axis} shows another curve than in the other runs: {curves.far[i]:.3g} times as far from them as they are"
    do = "Look for exchanged axes, another gain, or a disturbance in this recording"
    return Cause("run_differs", what, do)

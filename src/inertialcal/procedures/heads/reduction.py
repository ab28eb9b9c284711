"""Bias of heads from that of others on the same rigid body.

With the weights w of module ``contrasts``, in the axes of the head that is calibrated (C takes the body's to its)::

    d = y - C (sum_i w_i C_i' y_i + Gamma e)        relative_bias: b - sum_i w_i b_i
    b = d + C sum_i w_i C_i' b_i                    bias, where the others' were found absolutely, by flips

y are means over the intervals in which all heads were read, e is what the head lies off the line, plane or space of
the others. Where the motion carries it, d is regressed on the acceleration that the others tell: the slopes are scale
factor error and misalignment of the head, against the others. These read noise too, which makes a slope too small and
lowers a scale factor; both are corrected by the noise that the fit leaves, of which the others' part is taken as their
part of the weights; that it may be any is Type B.

Assumed: the body is rigid; biases hold over the record but for drift, which the uncertainty of means includes; noise of
heads is independent, whatever its spectrum above two periods in the record; what is common (drag,
gradient of gravity) cancels by geometry, not by assumption.

Type B, from the file of the body, in first order: biases of the calibrated heads with their covariance and their drift
since, orientations and scale factors by the mean acceleration, positions by the mean of Gamma, Gamma e by what is not
known of the motion, clocks by the change of the acceleration over the record.

Where real data break it, see module ``shared`` (gross errors, by the motion) and ``doubts`` (fine ones).
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from ...core.curve import Curve
from ...core.errors import DataError
from ...core.estimate import Array, Component, Estimate
from ...core.key import Origin
from ...core.remarks import Remark
from ...core.results import Row
from ...core.show.result_tables import estimate_table, remarks_line
from ...core.show.rounding import number
from ...core.show.tables import Block, html, text
from .contrasts import Weights, fitted, long_run
from .doubts import doubts
from .found import (
    BIAS,
    CLEAR,
    RELATIVE,
    TURN,
    Calibrated,
    gap_of,
    keys_of,
    known_heads,
    motion_told,
    off_line_covariance,
    on_line,
    others_bias,
    weights_of,
)
from .grid import body_means, smoothing, turning
from .plan import Plan
from .readings import Flags, Readings, aligned, edges_of, span
from .rows import curves, rows
from .shared import checked, clocks, common, offsets
from .stated import stated

BLOCKS, FEWEST = 240, 32  # intervals that a record is cut into, and that are needed
FAR_OUT = 8.0  # robust standard deviations, by which an interval departs


@dataclass(frozen=True, eq=False)
class Result:
    """What the test gives."""

    plan: Plan
    readings: Readings
    times: Array  # middles of intervals [s]
    interval: float  # [s]
    means: Array  # shape (heads, n, 3), in the body [m/s^2]
    gammas: Array | None  # shape (n, 3, 3), by a gyro [1/s^2]
    heads: tuple[Calibrated, ...]
    estimate: Estimate | None
    lost: Array | None = None  # shape (heads, 3): part of the motion that means of a head lose, by axis of the body
    off_line: dict[str, Array] = field(default_factory=dict)  # covariance of Gamma e, in the body
    remarks: tuple[Remark, ...] = ()

    def rows(self) -> tuple[Row, ...]:
        """Rows of ``results.json``, SI."""
        return tuple(rows(self))

    def curves(self) -> list[Curve]:
        """Curves of ``results.json``, SI."""
        return curves(self)

    @property
    def absolute(self) -> bool:
        """Whether the biases of all calibrated heads are known."""
        return all(one.mounted.bias is not None for one in self.readings.tracks if one.mounted.calibrated)

    def parts(self) -> tuple[Block, ...]:
        """Return what is shown: the figures in SI, how many remarks."""
        caption = f"heads on one body: {', '.join(f'{one.number} is {one.name}' for one in self.heads)}"
        return (*estimate_table([row.to_dict() for row in self.rows()], caption), *remarks_line(self.remarks))

    def __str__(self) -> str:
        """Return what is shown as text."""
        return text(self.parts())

    __repr__ = __str__

    def _repr_html_(self) -> str:
        """Return what is shown for a notebook."""
        return html(self.parts())


def reduce(plan: Plan, readings: Readings) -> Result:
    """Calibrate the heads that are not.

    Raises
    ------
    DataError
        As ``shared.checked`` and ``shared.clocks``; ``too_short``, ``no_common_time``.
    """
    remarks = list(readings.remarks)
    start, stop = span(readings)
    series, step = common(readings, start, stop)
    late, said = clocks(readings, offsets(readings, series, step, plan.clock_search))
    if late:
        readings = aligned(readings, late)
        start, stop = span(readings)
        series, _ = common(readings, start, stop)
    remarks += [*said, *checked(readings, series)]
    interval = _interval(plan, readings, stop - start)
    edges = edges_of(start, stop, interval)
    means = body_means(readings, edges)
    gammas = None if readings.gyro is None else turning(readings.gyro, edges)
    there: Flags = np.asarray(np.isfinite(means).all(axis=(0, 2)))
    if gammas is not None:
        there &= np.isfinite(gammas).all(axis=(1, 2))
    kept, left = _without_glitches(readings, means, gammas, there)
    remarks += left
    times = edges[:-1] + 0.5 * interval
    if np.count_nonzero(kept) < FEWEST:
        what = f"{int(np.count_nonzero(kept))} intervals of {number(interval, 4)} s in which all heads were read, need "
        what += f"{FEWEST}"
        do = "Record longer, or average over a shorter interval"
        raise DataError(what, why="the uncertainty rests on their scatter", do=do, code="too_short")
    result = Result(plan, readings, times[kept], interval, means[:, kept], None if gammas is None else gammas[kept], (),
                    None)  # fmt: skip
    lost = np.array([smoothing(one, edges) for one in readings.tracks])
    result = _with_heads(replace(result, lost=lost))
    return replace(result, remarks=(*remarks, *doubts(result)))


def _interval(plan: Plan, readings: Readings, length: float) -> float:
    """Return the time to average over: samples of the slowest head, so many that there are enough intervals."""
    slowest = max(one.interval for one in readings.tracks)
    if plan.interval is not None:
        if plan.interval < slowest * 0.999:
            what = f"interval {number(plan.interval, 4)} s, but a sample every {number(slowest, 4)} s"
            raise DataError(what, do="Average over longer", code="too_short")
        return plan.interval
    return slowest * max(1, int(length / BLOCKS / slowest))


def _without_glitches(
    readings: Readings, means: Array, gammas: Array | None, there: Flags
) -> tuple[Flags, list[Remark]]:
    """Return the intervals without those in which a head departs from what the others tell, and remarks on these."""
    known, kept = known_heads(readings), np.array(there)
    targets = [i for i in range(len(readings.tracks)) if i not in known]
    gaps = [gap_of(readings, means, gammas, at, known) for at in targets]
    if np.count_nonzero(there) < FEWEST:
        return kept, []
    out = np.zeros(len(there), dtype=bool)
    for gap in gaps:
        out |= _departures(gap, there) > FAR_OUT
    if not out.any() or np.count_nonzero(out) > 0.2 * np.count_nonzero(there):
        return kept, []
    each = np.array([_departures(one, there) for one in means])  # heads x intervals
    moved = (each > FAR_OUT).all(axis=0)
    remarks = []
    for code, which in (("thruster_event", out & moved), ("glitch", out & ~moved)):
        if count := int(np.count_nonzero(which)):
            if code == "glitch":
                free = means - np.median(means[:, there], axis=1)[:, None, :]
                apart = np.max(np.abs(free - np.median(free, axis=0)), axis=2)  # heads x intervals
                names = {readings.tracks[int(np.argmax(apart[:, k]))].mounted.name for k in np.flatnonzero(which)}
                what = (
                    f"{count} intervals in which a head departs from the others ({', '.join(sorted(names))}): left out"
                )
                do = "Look for glitches of that head"
            else:
                what = f"{count} intervals in which all heads read an event and do not agree: left out"
                do = "A structure that bends, or clocks that differ, make heads disagree while a thruster fires"
            remarks.append(Remark(code, "warning", what, count=count, do=do))
    return kept & ~out, remarks


def _departures(series: Array, there: Flags) -> Array:
    """Return how far each interval lies from the median, in robust standard deviations, the farthest axis."""
    middle = np.median(series[there], axis=0)
    scale = 1.4826 * np.median(np.abs(series[there] - middle), axis=0)
    found = np.abs(series - middle) / np.where(scale > 0.0, scale, np.inf)
    return np.asarray(np.where(there, np.max(np.nan_to_num(found), axis=1), 0.0))


def _with_heads(result: Result) -> Result:
    readings, known = result.readings, known_heads(result.readings)
    heads, off_line = [], {}
    for at, track in enumerate(readings.tracks):
        if at in known:
            continue
        weights = weights_of(readings, at, known)
        turn = track.mounted.orientation
        extra, covariance = off_line_covariance(result, weights.off)
        off_line[track.mounted.name] = covariance
        gap = (gap_of(readings, result.means, result.gammas, at, known) - extra) @ turn.T
        others = np.tensordot(weights.weights, result.means[known], 1) + extra
        others = (others if result.gammas is None else others + result.gammas @ weights.off) @ turn.T
        others = others - others_bias(result, at, weights)
        told = on_line(result, at, weights) or motion_told(result)
        heads.append(_calibrated(result, at, weights, told, gap, others))
    result = replace(result, heads=tuple(heads), off_line=off_line)
    return replace(result, estimate=_estimate(result))


def _calibrated(result: Result, at: int, weights: Weights, told: bool, gap: Array, others: Array) -> Calibrated:
    """Return the mean of what a head reads beyond the others, and slopes over what these tell where it is carried."""
    flat = fitted(np.ones((len(gap), 1)), gap)
    square = weights.growth**2
    part = square / (1.0 + square)  # of the noise of the gap, that is the others'
    power = np.var(others, axis=0)
    every = np.column_stack([np.ones(len(gap)), others])
    left = gap - every @ np.linalg.lstsq(every, gap, rcond=None)[0]  # without slopes, however large
    noise = np.var(left, axis=0) * len(gap) / max(len(gap) - every.shape[1], 1)
    carried = np.zeros(3, dtype=bool)
    line = flat
    if result.plan.scale_factor == "auto":
        for _ in range(2):  # noise is what is left with slopes
            carried = power * (1.0 - part * noise / np.maximum(power, 1e-300)) >= CLEAR * part * noise
            carried &= power > 0.0
            design = np.column_stack([np.ones(len(gap)), (others - others.mean(axis=0))[:, carried]])
            line = fitted(design, gap)
            noise = np.var(line.rest, axis=0) * len(gap) / max(len(gap) - design.shape[1], 1)
    slopes, doubt, late = np.zeros((3, 3)), np.zeros(3), np.zeros(3)
    clocks = _clocks_u(result, at, weights) ** 2
    lost = np.zeros(3)
    if result.lost is not None:
        turn = result.readings.tracks[at].mounted.orientation
        lost = turn**2 @ (result.lost[at] - weights.weights @ result.lost[known_heads(result.readings)])
    for k, m in enumerate(np.flatnonzero(carried).tolist()):
        q = part * float(noise[m]) / float(power[m])
        slopes[:, m] = line.values[1 + k] / (1.0 - q)
        slopes[m, m] += q / (1.0 - q)
        doubt[m] = q / part * max(part, 1.0 - part) / np.sqrt(3.0)
        pace = float(np.mean(np.diff(others[:, m]) ** 2)) / result.interval**2 / float(power[m])  # square of rad/s
        late[m] = float(np.hypot(0.5 * pace * clocks * np.sqrt(3.0), lost[m]))
        slopes[m, m] += lost[m]
    name = result.readings.tracks[at].mounted.name
    mean = line.values[0] - slopes @ others.mean(axis=0) if carried.any() else line.values[0]
    return Calibrated(name, at + 1, weights, told, carried, gap, others, line, slopes, doubt, late, mean)


def _clocks_u(result: Result, at: int, weights: Weights) -> float:
    """Return the standard uncertainty of the clock of a head against the others [s]."""
    tracks = result.readings.tracks
    known = known_heads(result.readings)
    squares = [float(w) ** 2 * tracks[i].mounted.clock_u ** 2 for w, i in zip(weights.weights, known, strict=True)]
    return float(np.sqrt(tracks[at].mounted.clock_u ** 2 + sum(squares)))


def _estimate(result: Result) -> Estimate | None:
    """Return all values with their covariance."""
    heads = [one for one in result.heads if one.told]
    if not heads:
        return None
    keys = [key for one in heads for key in keys_of(result, one)]
    units = ["m/s^2" if key.quantity in (RELATIVE, BIAS) else "rad" if key.quantity == TURN else "1" for key in keys]
    influence = np.hstack([one.line.influence for one in heads])
    base, dof = long_run(influence)
    rows, values, sizes = [], [], [one.line.influence.shape[1] for one in heads]
    for place, one in enumerate(heads):
        first = sum(sizes[:place])
        to_values, own = _values(result, one)
        wide = np.zeros((len(own), base.shape[0]))
        wide[:, first : first + sizes[place]] = to_values
        rows.append(wide)
        values.append(own)
    to = np.vstack(rows)
    covariance = to @ base @ to.T
    parts = [Component(Origin("scatter of interval means", level="interval"), "A", 0.5 * (covariance + covariance.T),
                       float(dof), "t")]  # fmt: skip
    parts += stated(result, heads)
    return Estimate(tuple(keys), np.concatenate(values), tuple(units), tuple(parts))


def _values(result: Result, one: Calibrated) -> tuple[Array, Array]:
    """Return the values of a head, and the matrix from the coefficients of its line to them."""
    axes = np.flatnonzero(one.carried).tolist()
    size = 3 * (1 + len(axes))
    level = np.zeros((3, size))
    level[:, :3] = np.eye(3)
    for k, m in enumerate(axes):
        level[:, 3 * (1 + k) : 3 * (2 + k)] = -np.eye(3) * float(one.told_by_others[:, m].mean())
    rows, values = [level], [one.mean]
    if result.absolute:
        rows.append(level)
        values.append(one.mean + others_bias(result, one.number - 1, one.weights))
    slopes = np.zeros((3 * len(axes), size))
    own = []
    at = 0
    for order in (True, False):
        for k, m in enumerate(axes):
            for a in range(3):
                if (a == m) == order:
                    slopes[at, 3 * (1 + k) + a] = 1.0
                    own.append(float(one.slopes[a, m]))
                    at += 1
    return np.vstack([*rows, slopes]), np.concatenate([*values, np.array(own)])

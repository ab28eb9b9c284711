"""Bias and noise at levels of pressure that lie decades apart, and the noise of a pump.

Pressure stands at levels over decades (Table 6 of [1]_), where a line in pressure says nothing. Each level has a bias
of its own::

    y = offset of its power-up + beta_level + c (T - mean) + noise        beta of the lowest level: 0

Levels are stretches in which the logarithm of the pressure stays within `ALIKE`; those of several recordings are one
level where they lie within `ONE` of each other. ``beta`` comes from within power-ups, with the sandwich by power-up
(CR2) and Student's t; the bias of a level is ``beta`` with the mean offset, and holds what power-ups differ by. ``c``
is there where a temperature was recorded and changes.

*Constant below a pressure*: the highest level up to which no ``beta`` differs from zero (Bonferroni, 5 %), with the
bound that the intervals leave: few readings pass easily, and leave a large bound.

Noise of a level: root mean square about the line of each block, whatever its spectrum inside the block. Its uncertainty
is what blocks, and power-ups, differ by. Pump on over pump off: the ratio of two, with the quotient of chi-squares.

Three ways in which real records break this: (1) levels that always come in one order under a drift, as in every
pump-down: the drift is taken for an effect of pressure (``one_order``); (2) without air the unit warms up: the
temperature goes with pressure (``temperature_follows``), and without a thermometer it cannot be told; (3) a gauge at
the end of its scale: all levels below are one (``gauge_floor``).

References
----------
.. [1] V. V. Badescu, NPS thesis, 2011, Tables 5 and 6.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import special

from ...core.curve import Column, Curve
from ...core.estimate import Array
from ...core.key import At, Key, Reason
from ...core.recording import SECOND
from ...core.remarks import Remark
from ...core.results import Interval, Row, not_estimated
from ...statistics.intervals import band_factor, chi_square_interval, coverage_factor, t_interval
from ...statistics.own_offsets import OwnOffsets, fit_own_offsets
from .plan import PRESSURE, PUMP, TEMPERATURE
from .readings import ConditionRecording

ALIKE = 0.15  # decades of pressure that a level stays within
ONE = 0.3  # decades within which levels of several recordings are one
DECADES = 1.0  # of pressure, from which on levels are looked at
BLOCKS = 8  # of a level
FEWEST = 12  # samples of a block
ORDERED = 0.9  # correlation of levels with time, in all power-ups
STUCK = 0.5  # share of samples of the lowest level that read alike: the end of the scale
CHANGES = 1.0  # range of temperature that acts [degC]
LEVEL = 0.05  # of the test for constancy


@dataclass(frozen=True, eq=False)
class Blocks:
    """Blocks of steady pressure, in order of recording and time."""

    axes: tuple[str, ...]
    run: NDArray[np.str_]  # shape (b,)
    level: NDArray[np.intp]  # shape (b,): 0 is the lowest pressure
    time: Array  # shape (b,): since power-up [s]; NaN where not known
    mean: Array  # shape (b, k) [unit of the readings]
    square: Array  # shape (b, k): mean square about the line of the block
    samples: NDArray[np.int64]  # shape (b,)
    temperature: Array  # shape (b, k) [degC]; NaN where not known
    pump: Array  # shape (b,): 1 on, 0 off; NaN where not known
    pressure: Array  # shape (levels, 2): lowest and highest of each level [Pa]
    stuck: float  # Share of samples of the lowest level that read alike

    @property
    def middle(self) -> Array:
        """Pressure of each level, geometric mean of its ends [Pa]."""
        return np.sqrt(self.pressure[:, 0] * self.pressure[:, 1])


@dataclass(frozen=True, eq=False)
class PressureLevels:
    """What the levels show."""

    blocks: Blocks
    unit: str
    fits: Mapping[str, OwnOffsets | None]  # By axis; None where power-ups cannot tell the levels
    remarks: tuple[Remark, ...]

    def rows(self) -> Iterator[Row]:
        """Yield bias, change and noise a level, what is constant, and the pump's noise, SI."""
        for a, axis in enumerate(self.blocks.axes):
            fit = self.fits[axis]
            if fit is None:
                reason = Reason("levels_together", "the power-ups cannot tell the levels from their offsets")
                yield not_estimated(Key("bias_change", axis), self.unit, reason)
            else:
                yield from _biases(self.blocks, fit, axis, self.unit)
                yield from _constant(self.blocks, fit, axis, self.unit)
            yield from _noise(self.blocks, a, axis, self.unit)

    def curves(self) -> list[Curve]:
        """Return the change of the bias over pressure with its interval."""
        found = []
        for axis, fit in self.fits.items():
            if fit is None:
                continue
            values, us, dofs = _changes(self.blocks, fit)
            half = np.array([coverage_factor(float(d)) * u for u, d in zip(us, dofs, strict=True)])
            columns = {
                "pressure": Column(self.blocks.middle, "Pa"),
                "change": Column(values, self.unit),
                "lo": Column(values - half, self.unit),
                "hi": Column(values + half, self.unit),
            }
            found.append(Curve("pressure_levels", axis, columns))
        return found


def pressure_levels(recorded: Sequence[ConditionRecording], axes: tuple[str, ...], unit: str) -> PressureLevels | None:
    """Return bias and noise at levels of pressure; None where it does not go over a decade, or stands nowhere."""
    blocks = blocks_of(recorded, axes)
    if blocks is None:
        return None
    fits = {}
    for a, axis in enumerate(axes):
        columns = [(blocks.level == k).astype(float) for k in range(1, len(blocks.pressure))]
        T = blocks.temperature[:, a]
        columns += [T - T.mean()] if _warms(blocks, a) else []
        fits[axis] = fit_own_offsets(np.column_stack(columns), blocks.mean[:, a], blocks.run, blocks.run)
    return PressureLevels(blocks, unit, fits, tuple(_remarks(blocks)))


def blocks_of(recorded: Sequence[ConditionRecording], axes: tuple[str, ...]) -> Blocks | None:
    """Return the blocks of steady pressure of all recordings; None where there are no two levels over a decade."""
    parts: list[tuple[str, float, Array, Array, int, Array, float, float]] = []
    floors: list[float] = []
    begin: dict[str, int] = {}
    for one in recorded:
        own = one.conditions.get(PRESSURE)
        if not own or any(axis not in one.recording.names for axis in axes):
            continue
        pressure = next(iter(own.values()))
        run, stamps = one.run or one.name, one.recording.time_ns
        if stamps is not None:
            begin.setdefault(run, int(stamps[0]))
        y = np.column_stack([np.asarray(one.recording.channel(axis).data, dtype=float) for axis in axes])
        warm = one.conditions.get(TEMPERATURE, {})
        T = np.column_stack([warm.get(axis, np.full(len(y), np.nan)) for axis in axes])
        pump = next(iter(one.conditions.get(PUMP, {}).values()), np.full(len(y), np.nan))
        valid = np.isfinite(pressure) & (pressure > 0.0) & np.isfinite(y).all(axis=1)
        for start, stop in _steady(np.log10(np.where(valid, pressure, np.nan)), pump):
            size = max((stop - start) // BLOCKS, FEWEST)
            for first in range(start, stop - size + 1, size):
                at = slice(first, first + size)
                t = np.nan if stamps is None else float(stamps[at].mean() - begin[run]) / SECOND
                line = np.column_stack([np.ones(size), np.linspace(-1.0, 1.0, size)])
                left = y[at] - line @ np.linalg.lstsq(line, y[at], rcond=None)[0]
                p = float(np.log10(pressure[at]).mean())
                parts.append((run, t, y[at].mean(axis=0), np.sum(left**2, axis=0) / (size - 2.0), size,
                              T[at].mean(axis=0), float(pump[at].mean()), p))  # fmt: skip
                floors.append(float(np.mean(np.diff(pressure[at]) == 0.0)))
    if not parts:
        return None
    logs = np.array([one[-1] for one in parts])
    level = _grouped(logs)
    count = int(level.max()) + 1
    if count < 2 or np.ptp(logs) < DECADES:
        return None
    ends = np.array([[10.0 ** logs[level == k].min(), 10.0 ** logs[level == k].max()] for k in range(count)])
    pump = np.array([one[6] for one in parts])
    known = pump[np.isfinite(pump)]
    middle = 0.5 * (float(known.min()) + float(known.max())) if len(known) else 0.0
    pump = np.where(np.isfinite(pump) & bool(len(known) and np.ptp(known) > 0.0), (pump > middle).astype(float), np.nan)
    return Blocks(
        axes, np.array([one[0] for one in parts]), level, np.array([one[1] for one in parts]),
        np.array([one[2] for one in parts]), np.array([one[3] for one in parts]),
        np.array([one[4] for one in parts], dtype=np.int64), np.array([one[5] for one in parts]), pump, ends,
        float(np.mean(np.array(floors)[level == 0])),
    )  # fmt: skip


def _steady(logs: Array, pump: Array) -> Iterator[tuple[int, int]]:
    """Yield stretches [start, stop) in which the logarithm of pressure stays, and the pump does not change."""
    size = FEWEST
    count = len(logs) // size
    if not count:
        return
    rows = logs[: count * size].reshape(count, size)
    still = np.isfinite(rows).all(axis=1) & (np.ptp(np.nan_to_num(rows, nan=np.inf), axis=1) <= 2.0 * ALIKE)
    means = np.where(still, np.nan_to_num(rows).mean(axis=1), np.nan)
    on = pump[: count * size].reshape(count, size).mean(axis=1)
    start, total, members = -1, 0.0, 0
    for k in range(count + 1):
        goes_on = k < count and still[k] and members and abs(means[k] - total / members) <= ALIKE
        goes_on = goes_on and not (np.isfinite(on[k]) and abs(on[k] - on[start]) > 0.0)
        if goes_on:
            total, members = total + float(means[k]), members + 1
            continue
        if members > 1:
            yield start * size, k * size
        if k < count and still[k]:
            start, total, members = k, float(means[k]), 1
        else:
            members = 0


def _grouped(logs: Array) -> NDArray[np.intp]:
    """Return the number of the level of each logarithm; a level spans no more than `ONE`."""
    order = np.argsort(logs, kind="stable")
    level = np.zeros(len(logs), dtype=np.intp)
    first, number = logs[order[0]], 0
    for i in order:
        if logs[i] - first > ONE:
            first, number = logs[i], number + 1
        level[i] = number
    return level


def _warms(blocks: Blocks, a: int) -> bool:
    T = blocks.temperature[:, a]
    return bool(np.isfinite(T).all() and np.ptp(T) > CHANGES)


def _changes(blocks: Blocks, fit: OwnOffsets) -> tuple[Array, Array, Array]:
    """Change of each level from the lowest, its uncertainty and degrees of freedom."""
    n = len(blocks.pressure)
    u = np.sqrt(np.diag(fit.covariance))
    return (
        np.concatenate([[0.0], fit.coefficients[1:n]]),
        np.concatenate([[0.0], u[1:n]]),
        np.concatenate([[np.inf], fit.dof[1:n]]),
    )


def _place(blocks: Blocks, level: int) -> At:
    return At("pressure", float(f"{blocks.middle[level]:.3g}"), "Pa")


def _biases(blocks: Blocks, fit: OwnOffsets, axis: str, unit: str) -> Iterator[Row]:
    values, us, dofs = _changes(blocks, fit)
    for k in range(len(values)):
        one = np.zeros(len(fit.coefficients))
        one[0] = 1.0
        if k:
            one[k] = 1.0
        bias, u = float(one @ fit.coefficients), math.sqrt(max(float(one @ fit.covariance @ one), 0.0))
        dof = float(min(fit.dof[0], dofs[k]))
        low, high = blocks.pressure[k]
        alone = len(np.unique(blocks.run)) < 2
        told = f"{low:.3g} to {high:.3g} Pa{'; one power-up: drift slower than a level is not in it' if alone else ''}"
        yield Row(Key("bias", axis, at=_place(blocks, k)), bias, u, unit, dof, t_interval(bias, u, dof),
                  reason=Reason("limits", told))  # fmt: skip
        if k:
            value, own = float(values[k]), float(us[k])
            seen = "" if fit.repeated[k] else "; seen in one power-up"
            dof, told = float(dofs[k]), f"less the lowest level{seen}"
            interval = t_interval(value, own, dof)
            yield Row(Key("bias_change", axis, at=_place(blocks, k)), value, own, unit, dof, interval,
                      reason=Reason("limits", told))  # fmt: skip


def constant_below(blocks: Blocks, fit: OwnOffsets) -> tuple[int, float]:
    """Return the highest level up to which no change was seen (0: none), and the bound of the changes there."""
    values, us, dofs = _changes(blocks, fit)
    for top in range(len(values) - 1, 0, -1):
        mine = slice(1, top + 1)
        p = 2.0 * special.stdtr(dofs[mine], -np.abs(values[mine]) / np.maximum(us[mine], 1e-300))
        if top * float(p.min()) > LEVEL:
            factors = np.array([band_factor(top, float(d)) for d in dofs[mine]])
            return top, float(np.max(np.abs(values[mine]) + factors * us[mine]))
    return 0, 0.0


def _constant(blocks: Blocks, fit: OwnOffsets, axis: str, unit: str) -> Iterator[Row]:
    top, bound = constant_below(blocks, fit)
    place, limit = Key("pressure_constant_below", axis), Key("bias_change_below", axis)
    if not top:
        reason = Reason("not_constant", "the two lowest levels differ")
        yield not_estimated(place, "Pa", reason)
        yield not_estimated(limit, unit, reason)
        return
    pressure = float(blocks.pressure[top, 1])
    told = Reason("limits", f"no change seen among the {top + 1} levels up to it; a rule, no estimate")
    yield Row(place, pressure, None, "Pa", status="not_estimated", reason=told)
    yield Row(limit, bound, None, unit, None, Interval(0.0, bound), "upper_limit",
              Reason("not_seen", f"largest change below {pressure:.3g} Pa that the readings allow"))  # fmt: skip


def _root_mean_square(squares: Array, runs: NDArray[np.str_], samples: NDArray[np.int64]) -> tuple[float, float]:
    """Return the root of the mean of squares, and the degrees of freedom that blocks and power-ups leave it."""
    mean = float(np.average(squares, weights=samples))
    variance = 2.0 * mean**2 / float(np.sum(samples - 2.0))
    if len(squares) > 1:
        variance = max(variance, float(squares.var(ddof=1)) / len(squares))
    each = np.array([squares[runs == one].mean() for one in np.unique(runs)])
    if len(each) > 1:
        variance = max(variance, float(each.var(ddof=1)) / len(each))
    fewest = len(each) - 1.0 if len(each) > 1 else max(len(squares) - 1.0, 1.0)
    return math.sqrt(mean), max(2.0 * mean**2 / variance if variance > 0.0 else fewest, 1.0)


def _noise(blocks: Blocks, a: int, axis: str, unit: str) -> Iterator[Row]:
    for k in range(len(blocks.pressure)):
        mine = blocks.level == k
        if not mine.any():
            continue
        std, dof = _root_mean_square(blocks.square[mine, a], blocks.run[mine], blocks.samples[mine])
        if std > 0.0:
            yield Row(Key("scatter_sample", axis, at=_place(blocks, k)), std, std / math.sqrt(2.0 * dof), unit, dof,
                      chi_square_interval(std, dof))  # fmt: skip
    key = Key("pump_noise_ratio", axis)
    on, off = blocks.pump == 1.0, blocks.pump == 0.0
    if not (on.any() and off.any()):
        return
    (s1, d1), (s2, d2) = (
        _root_mean_square(blocks.square[one, a], blocks.run[one], blocks.samples[one]) for one in (on, off)
    )
    if not s2 > 0.0:
        yield not_estimated(key, "1", Reason("no_scatter", "no noise with the pump off"))
        return
    ratio = s1 / s2
    ends = [ratio / math.sqrt(float(special.fdtri(d1, d2, q))) for q in (0.975, 0.025)]
    u = ratio * math.sqrt(0.5 / d1 + 0.5 / d2)
    told = Reason("limits", "standard deviation of a sample, pump on over pump off")
    yield Row(key, ratio, u, "1", min(d1, d2), Interval(*ends), reason=told)


def _remarks(blocks: Blocks) -> Iterator[Remark]:
    runs = np.unique(blocks.run)
    ordered = []
    for run in runs:
        mine = blocks.run == run
        t, p = blocks.time[mine], blocks.level[mine].astype(float)
        if np.isfinite(t).all() and np.ptp(p) > 0.0 and np.ptp(t) > 0.0:
            ordered.append(float(np.corrcoef(t, p)[0, 1]))
    if ordered and (min(ordered) > ORDERED or max(ordered) < -ORDERED):
        what = "levels of pressure come in one order in all power-ups: a drift is taken for an effect of pressure"
        yield Remark("one_order", "warning", what, do="Go back to a first level at the end", subject=PRESSURE)
    if blocks.stuck > STUCK:
        what = f"the gauge reads {blocks.pressure[0, 0]:.3g} Pa again and again at the lowest level: its end of scale"
        yield Remark("gauge_floor", "warning", what, do="Take a gauge that reads lower", subject=PRESSURE)
    for a, axis in enumerate(blocks.axes):
        if _warms(blocks, a):
            size = abs(float(np.corrcoef(blocks.temperature[:, a], np.log(blocks.middle[blocks.level]))[0, 1]))
            if size > ORDERED:
                what = f"the temperature of {axis} goes with pressure (r = {size:.2f}): hard to tell apart"
                yield Remark("temperature_follows", "warning", what, do="Hold the temperature", axis=axis)

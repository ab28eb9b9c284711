"""Joint warm-up of a sensitivity test: its power-ups from the recordings, its rows and curves."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from ...core.curve import Column, Curve
from ...core.errors import DataError
from ...core.key import Key, Reason
from ...core.recording import SECOND
from ...core.results import Interval, Row, not_estimated
from ...statistics.closed_loop import AxisLoop
from ...statistics.intervals import t_interval
from .plan import RESIDUALS, START_TEMPERATURE, TEMPERATURE, Plan
from .readings import Readings
from .warm_up_model import PowerUps, Stretches, WarmUpModel, stretches_of, warm_up_model

LIMITED = ("no_transient", "temperature_moves")  # reasons that leave an upper limit


def joint_warm_up(plan: Plan, readings: Readings) -> WarmUpModel:
    """Return the warm-up of all axes over all power-ups.

    Raises
    ------
    DataError
        As `power_ups_of` and `warm_up_model`.
    """
    power_ups = power_ups_of(plan, readings)
    known = power_ups.temperature is not None and bool(np.isfinite(power_ups.temperature).all())
    return warm_up_model(power_ups, plan.reference_temperature if known else None)


def power_ups_of(plan: Plan, readings: Readings) -> PowerUps:
    """Return the samples of all recordings with the time since power-up.

    Raises
    ------
    DataError
        ``no_time`` where a recording has no times; ``missing_axis`` where one lacks an axis of the others.
    """
    first: dict[str, int] = {}
    times, values, warmth, runs = [], [], [], []
    axes = readings.axes
    for one in readings.recorded:
        recording, run = one.recording, one.run or one.name
        stamps = recording.time_ns
        if stamps is None:
            what = "no time since power-up is known"
            raise DataError(what, recording.source.path, do="Give the sample rate", code="no_time")
        if any(axis not in recording.names for axis in axes):
            what = f"not all of {', '.join(axes)} were read"
            raise DataError(what, recording.source.path, do="Give the axes apart", code="missing_axis")
        begin = first.setdefault(run, int(stamps[0]))
        times.append((stamps - begin) / SECOND + plan.power_up_delay)
        values.append(np.column_stack([np.asarray(recording.channel(axis).data, dtype=float) for axis in axes]))
        own = one.conditions.get(TEMPERATURE, {})
        warmth.append(np.column_stack([own.get(axis, np.full(len(recording), np.nan)) for axis in axes]))
        runs.append(np.full(len(recording), list(first).index(run)))
    temperature = np.concatenate(warmth)
    return PowerUps(
        axes, readings.unit, np.concatenate(times), np.concatenate(values), np.concatenate(runs),
        temperature if np.isfinite(temperature).any() else None, labels=tuple(first),
    )  # fmt: skip


def warm_up_loops(found: WarmUpModel, held: Sequence[PowerUps]) -> list[AxisLoop]:
    """Return how much the warm-up reduces the mean square of power-ups that it has not seen, axis by axis.

    Each is compared about a level of its own, with the warm-up taken off and without.
    """
    estimate, stretches = found.estimate, []
    for one in held:
        try:
            stretches.append(stretches_of(one, powers=len(found.by_temperature)))
        except DataError:
            continue  # too short to be compared
    if estimate is None or not stretches:
        return []
    loops = []
    for a, axis in enumerate(found.power_ups.axes):
        parts = [part for one in stretches for part in _compared(found, one, a, axis)]
        raw, left, allowed, weight = (np.array(column) for column in zip(*parts, strict=True))
        count, gain = len(parts), raw - left
        share = weight / weight.sum()
        u = float(gain.std(ddof=1)) / math.sqrt(count) if count > 1 else math.nan
        before, after = (math.sqrt(float(share @ one)) for one in (raw, left))
        number = sum(len(one.time) for one in stretches)
        loops.append(AxisLoop(axis, number, count, before, after, float(gain.mean()), u, count - 1.0,
                              float(share @ allowed), found.power_ups.unit))  # fmt: skip
    return loops


def _compared(found: WarmUpModel, held: Stretches, a: int, axis: str) -> Iterator[tuple[float, float, float, float]]:
    """Yield mean squares of each power-up without and with the model, of the model's uncertainty, and the samples."""
    estimate = found.estimate
    assert estimate is not None  # noqa: S101 - the caller looked
    readings = held.readings[:, a] - found.of_temperature(held, a)
    for r in range(held.runs):
        own = held.run == r
        t, weight = held.time[own], held.weight[own]
        start = float(held.start[r]) if math.isfinite(held.start[r]) else None
        away = 0.0 if start is None or found.reference_temperature is None else start - found.reference_temperature
        y = readings[own]
        columns = np.zeros((len(t), len(estimate.keys)))
        for i, key in enumerate(estimate.keys):
            j = key.power - 1
            shape = np.exp(-t / found.times[j])
            if key.quantity == "warm_up_time":
                size = found.amplitudes[j, a] + (0.0 if found.slopes is None else found.slopes[j, a] * away)
                columns[:, i] = size * t / found.times[j] ** 2 * shape
            elif key.axis == axis:
                columns[:, i] = shape * (away if key.quantity == START_TEMPERATURE else 1.0)
        every = np.column_stack([y, y - found.at(t, a, start), columns])
        every = every - np.average(every, axis=0, weights=weight)
        variance = np.einsum("ij,jk,ik->i", every[:, 2:], estimate.covariance, every[:, 2:])
        squares = [float(np.average(one, weights=weight)) for one in (every[:, 0] ** 2, every[:, 1] ** 2, variance)]
        yield squares[0], squares[1], squares[2], float(weight.sum())


def warm_up_rows(found: WarmUpModel) -> tuple[Row, ...]:
    """Return times, amplitudes, and what is left of power-ups held out, SI."""
    return (*_model_rows(found), *_held_out_rows(found))


def warm_up_curves(found: WarmUpModel) -> list[Curve]:
    """Return means of each power-up less its settled level, with the joint fit."""
    return [one for i in range(len(found.power_ups.axes)) for one in (*_of_axis(found, i), *_of_held_out(found, i))]


def _model_rows(found: WarmUpModel) -> Iterator[Row]:
    axes, unit = found.power_ups.axes, found.power_ups.unit
    if found.estimate is None:
        yield not_estimated(Key("warm_up_time", power=1), "s", found.reason)
        for a, axis in enumerate(axes):
            key, limit = Key("bias_warm_up", axis, power=1), float(found.limits[a])
            if math.isfinite(limit) and found.reason.code in LIMITED:
                yield Row(key, limit, None, unit, None, Interval(0.0, limit), "upper_limit", found.reason)
            else:
                yield not_estimated(key, unit, found.reason)
        return
    estimate = found.estimate
    start = found.reference_temperature
    said = {"bias_warm_up": "amplitude at power-up"}
    if found.slopes is not None and start is not None:
        said["bias_warm_up"] += f" from {start:.4g} degC"
        said[START_TEMPERATURE] = "change of the amplitude with the starting temperature"
    for i, key in enumerate(estimate.keys):
        value, u, dof = float(estimate.values[i]), float(estimate.u[i]), float(estimate.dof[i])
        reason = Reason("limits", said.get(key.quantity, ""))
        yield Row(key, value, u, estimate.units[i], dof, t_interval(value, u, dof), reason=reason)


def _held_out_rows(found: WarmUpModel) -> Iterator[Row]:
    """Rows of what is left of power-ups held out: the root mean square over all."""
    runs, unit = found.held_out, found.power_ups.unit
    if not runs:
        return
    told = "first minutes of power-ups held out, predicted from the others"
    for a, axis in enumerate(found.power_ups.axes):
        for name, each in (
            (RESIDUALS[0], [float(one.with_model[a]) for one in runs]),
            (RESIDUALS[1], [float(one.without[a]) for one in runs]),
        ):
            squares = np.square(each)
            value = math.sqrt(float(squares.mean()))
            u = float(squares.std(ddof=1)) / math.sqrt(len(each)) / (2.0 * value) if value > 0.0 else 0.0
            dof = len(each) - 1.0
            yield Row(Key(name, axis), value, u, unit, dof, t_interval(value, u, dof), reason=Reason("limits", told))


def _of_axis(found: WarmUpModel, axis: int) -> Iterator[Curve]:
    means, name, unit = found.stretches, found.power_ups.axes[axis], found.power_ups.unit
    labels = found.power_ups.labels or tuple(str(r + 1) for r in range(means.runs))
    readings = means.readings[:, axis] - found.of_temperature(means, axis)
    for r in range(means.runs):
        own = means.run == r
        start = float(means.start[r])
        level = found.levels[r, axis]
        columns = {
            "time": Column(means.time[own], "s"),
            "reading": Column(readings[own] - level, unit),
            "model": Column(found.at(means.time[own], axis, start if math.isfinite(start) else None), unit),
        }
        yield Curve("warm_up_joint", name, columns, of=labels[r], picture=True)


def _of_held_out(found: WarmUpModel, axis: int) -> Iterator[Curve]:
    """Yield what is left of the first minutes of each power-up, predicted from the others."""
    runs, unit = found.held_out, found.power_ups.unit
    if runs:
        columns = {
            "run": Column([one.label for one in runs]),
            "with_model": Column([float(one.with_model[axis]) for one in runs], unit),
            "without_model": Column([float(one.without[axis]) for one in runs], unit),
        }
        yield Curve("warm_up_held_out", found.power_ups.axes[axis], columns)

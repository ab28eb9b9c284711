"""Closed loop of a test of positions: readings held out, as they are and compensated.

Accelerometers: in every position held out the length of the specific force must be gravity, and where its direction is
known each component too. Gyros: each axis at rest must read the earth rate that is known, and in every rotation held
out gravity, carried by them, must arrive where the accelerometers find it. Squares of errors are paired by position or
rotation; the scatter of their differences says how well the mean is known. The verdict is that of all models
(``statistics.closed_loop``); what is common to fit and judgement cancels.

Positions of one record count as independent, also where they share a power-up: what differs from power-up to power-up
is judged by as many draws as there are records held out.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from scipy import special

from ....core.axes import Kind
from ....core.estimate import Array
from ....statistics.closed_loop import AxisLoop
from .. import reduction as positions
from ..fit.linear_sensor import LinearSensor
from .judges import Errors, Judge, as_read, mixed_up, of_accelerometers, of_gyros


def loops_of(fitted: positions.Result, held: Sequence[positions.Readings], kind: Kind) -> tuple[AxisLoop, ...]:
    """Return what readings held out say of one sensor, without verdicts; none where they cannot judge it.

    Parameters
    ----------
    fitted : positions.Result
        Of the test for a fit.
    held : sequence of Readings
        Held out, in the same units; one a record.
    kind : {"accelerometer", "gyro"}
        Which.
    """
    sensor = fitted.acc.sensor if kind == "accelerometer" else _gyros(fitted)
    if sensor is None:
        return ()
    own = {one.name: one for one in judges_of(fitted, fitted.readings, kind)}
    pooled = _pooled([judges_of(fitted, one, kind) for one in held])
    return before_and_after(sensor, sensor.values, pooled, own, len(held))


def judges_of(fitted: positions.Result, held: positions.Readings, kind: Kind) -> tuple[Judge, ...]:
    """Return the ways in which readings judge one sensor."""
    if kind == "accelerometer":
        return of_accelerometers(fitted, held)
    return () if fitted.gyro is None else of_gyros(fitted, fitted.gyro, held)


def before_and_after(
    sensor: LinearSensor, values: Array, judges: Sequence[Judge], own: Mapping[str, Judge], runs: int
) -> tuple[AxisLoop, ...]:
    """Return what the numbers of a model do to readings held out, with the uncertainty of the sensor that was fitted.

    Parameters
    ----------
    sensor : LinearSensor
        As it was fitted.
    values : ndarray, shape (12,) or (21,)
        The numbers to be judged: those of the sensor.
    judges : sequence of Judge
        Ways to judge.
    own : mapping of str to Judge
        The same of the readings of the fit, by name: they say how errors scatter.
    runs : int
        Records behind them.
    """
    views = [_View(one, values, sensor, own.get(one.name)) for one in judges]
    rivals = mixed_up(values, not set(range(9)) & set(sensor.reasons))
    return tuple(_before_after(view, as_read(sensor), runs, rivals) for view in views if len(view.error) > 1)


def _gyros(fitted: positions.Result) -> LinearSensor | None:
    return None if fitted.gyro is None else fitted.gyro.sensor


def _pooled(records: Sequence[Sequence[Judge]]) -> list[Judge]:
    """Return the ways to judge, each over all records."""
    by_name: dict[str, list[Judge]] = {}
    for one in (one for judges in records for one in judges):
        by_name.setdefault(one.name, []).append(one)
    return [replace(found[0], errors=_together([one.errors for one in found])) for found in by_name.values()]


def _together(parts: Sequence[Errors]) -> Errors:
    return lambda values: np.concatenate([part(values) for part in parts])


class _View:
    """One way to judge: errors of the model, what its uncertainty does to them, and how those of the fit scatter."""

    def __init__(self, judge: Judge, values: Array, sensor: LinearSensor, own: Judge | None) -> None:
        self.judge, self.values = judge, values
        self.error = judge.errors(values)
        self.moved = [judge.errors(values + step) - self.error for step in _steps(sensor)]
        left = np.empty((0, 1)) if own is None else own.errors(sensor.values)
        rows = int(np.sum(np.any(left != 0.0, axis=0))) * len(left)
        self.dof = float(max(rows - judge.free, 0))
        self.variance = float(np.sum(left**2)) / self.dof if self.dof else np.inf


def _steps(sensor: LinearSensor) -> Array:
    """Return one standard uncertainty along each principal direction of the Type A covariance, shape (p, p)."""
    covariance = np.zeros((len(sensor.values), len(sensor.values)))
    for one in sensor.sources:
        if one.kind == "A":
            covariance = covariance + one.covariance
    variance, directions = np.linalg.eigh(0.5 * (covariance + covariance.T))
    return np.asarray((directions * np.sqrt(np.maximum(variance, 0.0))).T[variance > 0.0])


def _before_after(view: _View, raw: Array, runs: int, rivals: Mapping[str, Array]) -> AxisLoop:
    before, after = _squares(view.judge.errors(raw)), _squares(view.error)
    n, gain = len(after), before - after
    allowed = float(sum(np.mean(_squares(one)) for one in view.moved))
    u = float(np.std(gain, ddof=1) / np.sqrt(n))
    raw_rms, left_rms = (float(np.sqrt(np.mean(squares))) for squares in (before, after))
    judge = view.judge
    distinct = {name: rival for name, rival in rivals.items() if judge.tells(view.values, rival)}
    return AxisLoop(
        judge.name,
        n,
        runs,
        raw_rms,
        left_rms,
        float(np.mean(gain)),
        u,
        float(n - 1),
        allowed,
        judge.unit,
        {name: _p_rival(view, rival) for name, rival in distinct.items()},
    )


def _squares(errors: Array) -> Array:
    return np.asarray(np.sum(errors**2, axis=1))


def _p_rival(view: _View, rival: Array) -> float:
    """Probability that a rival does so much better if the model were right; its uncertainty counts as scatter.

    The rival's error is that of the model and a known change: what scatters is the error of the model, as in the fit.
    """
    change = view.judge.errors(rival) - view.error
    n = len(change)
    gain = float(np.mean(_squares(view.error + change) - _squares(view.error)))
    shift = [2.0 * float(np.mean(np.sum(change * one, axis=1))) for one in view.moved]
    variance = 4.0 * view.variance * float(np.sum(change**2)) / n**2 + float(np.sum(np.square(shift)))
    if not (np.isfinite(variance) and variance > 0.0):
        return 1.0
    return float(special.stdtr(view.dof, gain / np.sqrt(variance)))

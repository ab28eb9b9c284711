"""Closed loop of a rate table: dwells that the model has not seen, as they are read and compensated.

Per axis and dwell, with the true input ``x``, reading ``r`` and compensated reading ``c = r - delta``::

    d = (r - x)^2 - (c - x)^2 = delta (2 (r - x) - delta)       positive: compensation helped

The correction ``delta`` is fixed by the model; ``r - x`` scatters, and its part that belongs to a run is the same
for all dwells of it. So the variance of the sum of ``d`` over a run is observed where runs are: it is that of
``2 sum(delta * residual)`` over the runs of the fit, with the correction that the model makes there. Dwells of one
run do not count as independent, and nothing is assumed of how runs differ, but that those held out differ as those of
the fit do. A fit of one run, or of runs not named, cannot judge another power-up: INCONCLUSIVE. What follows from it
is ``statistics.closed_loop``; against a mixed-up form the uncertainty of the model counts as scatter.

Errors of the table that are the same in fit and judgement cancel: the loop says nothing about them. Where both state
that the unit was laid anew in between, the angles of the two mountings are two draws: they count as uncertainty.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from scipy import special

from ....core.curve import Column, Curve
from ....core.estimate import Array
from ....core.key import AXES
from ....statistics.closed_loop import AxisLoop
from ..fit.quantities import matrix_entry
from ..fit.regression import Line
from ..readings import Labels, Readings
from ..turned import columns_of

Find = Callable[[Readings], Mapping[str, Array]]


def closed_loop(
    lines: Mapping[str, Line], held: Readings, model: Find, rivals: Mapping[str, Find], laid: float = 0.0
) -> tuple[AxisLoop, ...]:
    """Return how much better compensated readings of dwells held out are, axis by axis, without verdicts.

    Parameters
    ----------
    lines : mapping of str to Line
        Fits behind the model: they say how readings scatter.
    held : Readings
        Dwells held out, with their earth rate.
    model : callable
        From dwells to the inputs that the model finds, by axis [rad/s], shape (n,); NaN where it finds none.
    rivals : mapping of str to callable
        The same for each mixed-up form of the model.
    laid : float
        Standard uncertainty of each angle of the mounting, where that of the fit was another one [rad].

    Returns
    -------
    tuple of AxisLoop
        For the axes that have compensated readings.
    """
    compensated = model(held)
    views = [_view(lines[axis], held, model, axis, laid) for axis in compensated if axis in lines]
    return tuple(_axis(view, rivals) for view in views if len(view.dwells))


def compensated_curves(lines: Mapping[str, Line], held: Readings, model: Find) -> tuple[Curve, ...]:
    """Return the errors of the dwells that ``closed_loop`` judges, axis by axis, before and after compensation."""
    found = model(held)
    views = [_view(lines[axis], held, model, axis) for axis in found if axis in lines]
    return tuple(_compensated(view) for view in views if len(view.dwells))


def _compensated(view: _View) -> Curve:
    applied = true_input(view.dwells, view.axis)
    run = view.dwells.run
    return Curve(
        "compensated",
        view.axis,
        {
            "applied": Column(applied, "rad/s"),
            "raw_error": Column(view.dwells.outputs[view.axis] - applied, "rad/s"),
            "compensated_error": Column(view.found - applied, "rad/s"),
            "run": Column(("",) * len(applied) if run is None else tuple(str(label) for label in run)),
        },
    )


def true_input(held: Readings, axis: str) -> Array:
    """Return the rate about a body axis in each dwell, earth rate included [rad/s], shape (n,)."""
    table = np.where(held.axis == axis, held.applied, 0.0)
    return table if held.earth is None else table + held.earth[:, AXES.index(axis)]


@dataclass(frozen=True, eq=False)
class _View:
    """One axis: dwells held out with what the model finds there, and the fit with what it finds there."""

    axis: str
    line: Line
    dwells: Readings
    found: Array
    found_in_fit: Array
    laid: Array  # shape (s, n): what each angle between two mountings changes, one standard uncertainty [rad/s]


def _view(one: Line, held: Readings, model: Find, axis: str, laid: float = 0.0) -> _View:
    values = model(held)[axis]
    use = np.isfinite(values) & np.isfinite(held.outputs[axis])
    dwells = held.take(use)
    return _View(axis, one, dwells, values[use], model(one.readings)[axis], _angles(one, dwells, laid))


def _angles(one: Line, dwells: Readings, u: float) -> Array:
    """Return the changes of readings by the angles of the fit's mounting and of another one, shape (s, n) [rad/s]."""
    patterns = [
        np.sqrt(2.0) * u * matrix_entry(one, j) * np.where(dwells.axis == turned, dwells.applied, 0.0)
        for turned in AXES
        for j in AXES
        if j != turned
    ]
    return np.array(patterns) if u else np.zeros((0, len(dwells)))


def _axis(view: _View, rivals: Mapping[str, Find]) -> AxisLoop:
    reading = view.dwells.outputs[view.axis]
    error = reading - true_input(view.dwells, view.axis)
    delta = reading - view.found
    in_fit = view.line.readings.outputs[view.axis] - view.found_in_fit
    variance, dof = _variance(view, delta, in_fit)
    variance += _by_laying(view, delta)
    return AxisLoop(
        view.axis,
        len(view.dwells),
        view.dwells.runs,
        float(np.sqrt(np.mean(error**2))),
        float(np.sqrt(np.mean((error - delta) ** 2))),
        float(np.mean(delta * (2.0 * error - delta))),
        float(np.sqrt(variance)),
        dof,
        float(np.mean(_model_variance(view.line, view.dwells) + np.sum(view.laid**2, axis=0))),
        rivals={name: _p_rival(view, find) for name, find in rivals.items()},
    )


def _by_laying(view: _View, delta: Array) -> float:
    """Return the variance of the mean of d by the angles between two mountings."""
    return float(np.sum((2.0 * view.laid @ delta / max(len(delta), 1)) ** 2))


def _variance(view: _View, delta: Array, in_fit: Array) -> tuple[float, float]:
    """Variance of the mean of d, and its degrees of freedom.

    Parameters
    ----------
    view : _View
        Of the axis.
    delta, in_fit : ndarray
        Correction of the dwells held out, and of those of the fit [rad/s].
    """
    fit, readings = view.line.fit, view.line.readings
    n, lost = len(view.dwells), len(fit.coefficients)
    product = in_fit * fit.residuals
    if readings.runs < 2 or readings.run is None:
        same = readings.run is not None and view.dwells.run is not None and set(view.dwells.run) <= set(readings.run)
        if fit.dof < 1 or fit.mean_square is None or not same:
            return np.inf, 1.0  # how another power-up differs was not observed
        return 4.0 * fit.mean_square * float(delta @ delta) / n**2, float(fit.dof)
    _, at = np.unique(readings.run, return_inverse=True)
    sums = np.bincount(at, product)
    freedom = len(sums) / max(len(sums) - 1.0, 1.0) * len(product) / max(len(product) - lost, 1.0)
    share = max(
        float(delta @ delta) / max(float(in_fit @ in_fit), np.finfo(float).tiny),
        _run_weight(view.dwells.run, delta) / max(_run_weight(readings.run, in_fit), np.finfo(float).tiny),
    )
    return 4.0 * freedom * share * float(sums @ sums) / n**2, float(len(sums) - 1)


def _run_weight(run: Labels | None, delta: Array) -> float:
    """Sum over the runs of the squared sum of corrections, all taken as of one sign [(rad/s)^2].

    What a run has in common adds up over its dwells, so a longer run weighs more than its number of dwells; without
    runs all dwells are one.
    """
    at = np.zeros(len(delta), dtype=np.intp) if run is None else np.unique(run, return_inverse=True)[1]
    sums = np.bincount(at, np.abs(delta))
    return float(sums @ sums)


def _model_variance(one: Line, dwells: Readings) -> Array:
    """Type A variance of the fitted line at each dwell [(rad/s)^2], shape (n,)."""
    if one.covariance is None:
        return np.zeros(len(dwells))
    rows = _rows(one, dwells)
    return np.asarray(np.einsum("ij,jk,ik->i", rows, one.covariance, rows))


def _rows(one: Line, dwells: Readings) -> Array:
    """Design of the line at the dwells, shape (n, p)."""
    x = {axis: true_input(dwells, axis) for axis in one.axes}
    return columns_of(x, one.sensor, one.asymmetry, one.curvature)[0]


def _p_rival(view: _View, find: Find) -> float:
    """Probability that a rival does so much better if the model were right."""
    one, dwells = view.line, view.dwells
    if one.covariance is None:
        return 1.0
    delta = view.found - find(dwells)[view.axis]
    in_fit = view.found_in_fit - find(one.readings)[view.axis]
    error = view.found - true_input(dwells, view.axis)
    gain = float(np.mean(delta * (2.0 * error - delta)))
    variance, dof = _variance(view, delta, in_fit)
    moved = delta @ _rows(one, dwells) / len(dwells)
    variance += 4.0 * float(moved @ one.covariance @ moved) + _by_laying(view, delta)
    if not (np.isfinite(variance) and variance > 0.0):
        return 1.0
    return float(special.stdtr(dof, -gain / np.sqrt(variance)))

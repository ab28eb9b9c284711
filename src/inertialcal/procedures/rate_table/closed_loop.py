"""Closed loop: whether a reading is better after compensation, on dwells that the model has not seen.

Per axis and dwell, with the true input ``x``, reading ``r`` and compensated reading ``c = r - delta``::

    d = (r - x)^2 - (c - x)^2 = delta (2 (r - x) - delta)       positive: compensation helped

The correction ``delta`` is fixed by the model; ``r - x`` scatters, and its part that belongs to a run is the same
for all dwells of it. So the variance of the sum of ``d`` over a run is observed where runs are: it is that of
``2 sum(delta * residual)`` over the runs of the fit, with the correction that the model makes there. Dwells of one
run do not count as independent, and nothing is assumed of how runs differ, but that those held out differ as those of
the fit do. A fit of one run, or of runs not named, cannot judge another power-up: INCONCLUSIVE. Tests are
one-sided t tests; Holm's rule holds the risk over the axes at 5 %.

A model made from a finite test is off by its own (Type A) uncertainty even where it is right; that much is
allowed: an axis FAILs if it is worse beyond the mean square of that uncertainty. It PASSes if it is shown better;
else it is INCONCLUSIVE.

Better than nothing is not enough: a transposed matrix can still improve every axis where scale factor and bias
prevail. So the model is also held against its own mixed-up forms (transposed, signs turned, axes exchanged):
an axis FAILs where one of them is shown to do better. Here the uncertainty of the model counts as scatter. The risk of
5 % is shared in halves between the two ways to FAIL.

Errors of the table that are the same in fit and judgement cancel: the loop says nothing about them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy import special

from ...core.axes import AXES
from ...core.estimate import Array
from ...statistics.decision import holm
from .fit.regression import Line
from .readings import Labels, Readings

RISK = 0.05  # of calling a model wrong that is not, over all axes; and the same for calling it better


@dataclass(frozen=True)
class AxisLoop:
    """One axis, before and after.

    Parameters
    ----------
    axis : str
        Of the input.
    dwells, runs : int
        Judged.
    raw, compensated : float
        Root mean square error [rad/s].
    gain : float
        Mean of d [(rad/s)^2]: positive where compensation helped.
    u : float
        Standard uncertainty of it [(rad/s)^2].
    dof : float
        Degrees of freedom.
    allowed : float
        Mean square uncertainty of the model itself [(rad/s)^2].
    verdict : {"PASS", "FAIL", "INCONCLUSIVE"}
        By the rule.
    reason : str
        Why neither.
    """

    axis: str
    dwells: int
    runs: int
    raw: float
    compensated: float
    gain: float
    u: float
    dof: float
    allowed: float
    verdict: str = "INCONCLUSIVE"
    reason: str = ""


@dataclass(frozen=True, eq=False)
class HeldOut:
    """Dwells held out that one axis was judged on, before and after.

    Parameters
    ----------
    axis : str
        Of the input.
    applied : ndarray, shape (n,)
        True rate about the axis, earth rate included [rad/s].
    raw, compensated : ndarray, shape (n,)
        Error of the reading, and of what the model finds from it [rad/s].
    run : tuple of str
        Run of each dwell; empty where not given.
    """

    axis: str
    applied: Array
    raw: Array
    compensated: Array
    run: tuple[str, ...]


Find = Callable[[Readings], Mapping[str, Array]]


def held_out_errors(lines: Mapping[str, Line], held: Readings, model: Find) -> tuple[HeldOut, ...]:
    """Return the dwells that ``closed_loop`` judges, axis by axis, before and after compensation.

    Parameters
    ----------
    lines, held, model
        As for ``closed_loop``.
    """
    found = model(held)
    views = [_view(lines[axis], held, model, axis) for axis in found if axis in lines]
    return tuple(_before_after(view) for view in views if len(view.dwells))


def _before_after(view: _View) -> HeldOut:
    applied = true_input(view.dwells, view.axis)
    run = view.dwells.run
    return HeldOut(
        view.axis,
        applied,
        view.dwells.outputs[view.axis] - applied,
        view.found - applied,
        ("",) * len(applied) if run is None else tuple(str(label) for label in run),
    )


def closed_loop(
    lines: Mapping[str, Line], held: Readings, model: Find, rivals: Mapping[str, Find], share: float = 1.0
) -> tuple[AxisLoop, ...]:
    """Judge compensated readings of dwells held out, axis by axis.

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
    share : float
        Of the risk of a wrong verdict that is left to this loop; the rest belongs to another one of the campaign.

    Returns
    -------
    tuple of AxisLoop
        For the axes that have compensated readings.
    """
    compensated = model(held)
    views = {axis: _view(lines[axis], held, model, axis) for axis in compensated if axis in lines}
    loops = [_axis(view) for view in views.values() if len(view.dwells)]
    beaten = _beaten([view for view in views.values() if len(view.dwells)], rivals, share)
    return judged(loops, 0.5 * share, share, beaten)


def judged(
    loops: Sequence[AxisLoop],
    worse_share: float,
    better_share: float | None = None,
    beaten: Mapping[str, str] | None = None,
) -> tuple[AxisLoop, ...]:
    """Return the axes with their verdicts, Holm over all of them.

    Parameters
    ----------
    loops : sequence of AxisLoop
        Without verdicts.
    worse_share, better_share : float
        Of the risk to call one worse that is not, and better; alike where not said.
    beaten : mapping of str to str, optional
        Mixed-up form that is shown to do better, by axis.
    """
    if not loops:
        return ()
    worse = holm([_p_worse(one) for one in loops], RISK * worse_share)
    better = holm([_p_better(one) for one in loops], RISK * (worse_share if better_share is None else better_share))
    rivals = beaten or {}
    return tuple(
        _judged(one, bool(w), bool(b), rivals.get(one.axis, "")) for one, w, b in zip(loops, worse, better, strict=True)
    )


def overall(loops: tuple[AxisLoop, ...]) -> str:
    """Return FAIL if any axis does, PASS if every axis does, else INCONCLUSIVE."""
    found = {one.verdict for one in loops}
    if "FAIL" in found:
        return "FAIL"
    return "PASS" if found == {"PASS"} else "INCONCLUSIVE"


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


def _view(one: Line, held: Readings, model: Find, axis: str) -> _View:
    values = model(held)[axis]
    use = np.isfinite(values) & np.isfinite(held.outputs[axis])
    return _View(axis, one, held.take(use), values[use], model(one.readings)[axis])


def _axis(view: _View) -> AxisLoop:
    reading = view.dwells.outputs[view.axis]
    error = reading - true_input(view.dwells, view.axis)
    delta = reading - view.found
    in_fit = view.line.readings.outputs[view.axis] - view.found_in_fit
    variance, dof = _variance(view, delta, in_fit)
    return AxisLoop(
        view.axis,
        len(view.dwells),
        view.dwells.runs,
        float(np.sqrt(np.mean(error**2))),
        float(np.sqrt(np.mean((error - delta) ** 2))),
        float(np.mean(delta * (2.0 * error - delta))),
        float(np.sqrt(variance)),
        dof,
        float(np.mean(_model_variance(view.line, view.dwells))),
    )


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
    columns = [np.ones(len(dwells)), *(true_input(dwells, axis) for axis in one.axes)]
    if one.asymmetry:
        columns.append(np.abs(true_input(dwells, one.sensor)))
    return np.column_stack(columns)


def _beaten(views: list[_View], rivals: Mapping[str, Find], share: float) -> dict[str, str]:
    """Return the mixed-up form that does better than the model, by axis, where one is shown to."""
    tests = [(view.axis, name, _p_rival(view, find)) for name, find in rivals.items() for view in views]
    if not tests:
        return {}
    shown = holm([p for _, _, p in tests], RISK * share / 2.0)
    best: dict[str, tuple[float, str]] = {}
    for (axis, name, p), significant in zip(tests, shown, strict=True):
        if significant and p <= best.get(axis, (1.0, ""))[0]:
            best[axis] = (p, name)
    return {axis: name for axis, (_, name) in best.items()}


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
    variance += 4.0 * float(moved @ one.covariance @ moved)
    if not (np.isfinite(variance) and variance > 0.0):
        return 1.0
    return float(special.stdtr(dof, -gain / np.sqrt(variance)))


def _p_worse(one: AxisLoop) -> float:
    return _p(one.gain + one.allowed, one)


def _p_better(one: AxisLoop) -> float:
    return _p(-one.gain, one)


def _p(size: float, one: AxisLoop) -> float:
    """Probability of so negative a size or less, if its expectation were zero."""
    if not (np.isfinite(one.u) and one.u > 0.0):
        return 1.0
    return float(special.stdtr(one.dof, size / one.u))


def _judged(one: AxisLoop, worse: bool, better: bool, rival: str) -> AxisLoop:
    if rival:
        reason = f"{rival} does better on readings held out: the model is mixed up"
        return replace(one, verdict="FAIL", reason=reason)
    if worse:
        reason = "worse on readings held out, beyond the uncertainty of the model"
        return replace(one, verdict="FAIL", reason=reason)
    if better:
        return replace(one, verdict="PASS")
    return replace(one, reason="not shown better, nor worse, on readings held out")

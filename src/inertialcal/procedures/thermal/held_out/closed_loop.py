"""Bias over temperature on power-ups that it was not fitted to: what is left of it, and whether it helps.

Per power-up that was held out, with reading y (earth rate taken off) and polynomial P, mean over the cells::

    residual = mean(y - P)              gain = mean(y^2 - (y - P)^2) = mean(P (2 y - P))

Bins that were seen on both paths count on each alike, so hysteresis drops out of the residual. Power-ups are what was
repeated: the scatter of both is that of the power-ups of the fit, and nothing is assumed of those held out but that
they differ as these do. The polynomial of a finite test is off by its own (Type A) uncertainty even where it is right:
in the residual it counts as uncertainty, in the gain that much is allowed. Errors that are the same in both tests
(thermometer, attitude, converter) cancel and are not judged; where both state that the body was laid anew in between,
what is not known of its attitude counts as uncertainty, once for each. The polynomial is known on temperatures that it
was fitted to: cells beyond are left out.

Where a model is judged, P is the bias over temperature that it holds, whichever tests that comes from: what it has more
than the polynomial of the test is taken off as well, and its own (Type A) uncertainty is allowed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ....core.curve import Column, Curve
from ....core.errors import DataError
from ....core.estimate import Array
from ....core.key import AXES, Key, Reason
from ....core.results import Row, not_estimated
from ....sensors.model.sensor_model import SensorModel
from ....statistics.closed_loop import AxisLoop
from ....statistics.intervals import t_interval
from ..fit.cells import Cells
from ..fit.law import Law
from ..fit.quantities import earth_along
from ..over_temperature import bias_of
from ..reduction import Result

RESIDUAL = "residual_bias"
SAME = 1e-6  # of a bias: the model holds the polynomial itself
ONE_RUN = Reason("one_run", "the fit rests on one power-up: how another one differs was not observed")


@dataclass(frozen=True)
class AxisResidual:
    """What the polynomial leaves of one axis on power-ups held out."""

    axis: str  # Of the sensor
    cells: int  # Judged
    runs: int  # Judged
    raw: float  # Root mean square of the bias before [unit of the readings]
    compensated: float  # Root mean square of the bias after [unit of the readings]
    # Mean left, and its standard uncertainty [rad/s]; NaN where the scatter of power-ups was not observed
    residual: float
    u: float  # Mean left, and its standard uncertainty [rad/s]; NaN where the scatter of power-ups was not observed
    gain: float  # Of the mean square [unit squared]
    u_gain: float  # Its standard uncertainty [unit squared]
    allowed: float  # Mean square uncertainty of the polynomial [(rad/s)^2]
    dof: float  # Degrees of freedom of both


def held_out(
    fitted: Result, held: Result, remounted: bool = False, model: SensorModel | None = None
) -> tuple[AxisResidual, ...]:
    """Return what the polynomials of one test leave of another, axis by axis.

    Parameters
    ----------
    fitted, held : Result
        Of both tests.
    remounted : bool
        The body was laid anew in between.
    model : SensorModel, optional
        That is judged; by default the polynomials of the fitted test.

    Raises
    ------
    DataError
        ``outside`` if no cell held out lies at temperatures of the polynomial.
    """
    earth = earth_along(fitted.plan)[0] if fitted.readings.unit == "rad/s" else np.zeros(3)
    laid = _attitude_variance(fitted, held) if remounted else np.zeros(3)
    return tuple(
        _axis_residual(
            axis,
            fitted.sensors[axis].law,
            one.law.cells,
            float(earth[AXES.index(axis)]),
            float(laid[AXES.index(axis)]),
            model,
        )
        for axis, one in held.sensors.items()
        if axis in fitted.sensors and (model is None or axis in model.axes)
    )


def _attitude_variance(*results: Result) -> Array:
    """Return the variance of the earth rate along the axes that the attitudes of tests leave, shape (3,)."""
    total = np.zeros(3)
    for one in results:
        if one.readings.unit == "rad/s":
            for source, unknown in earth_along(one.plan)[1].items():
                if source != "latitude":  # of one place
                    total += np.sum(unknown.patterns**2, axis=0)
    return total


def _axis_residual(
    axis: str, law: Law, cells: Cells, earth: float, laid: float = 0.0, model: SensorModel | None = None
) -> AxisResidual:
    low, high = law.domain
    inside = (cells.temperature >= low) & (cells.temperature <= high)
    if not inside.any():
        what = f"{axis}: no temperature held out lies between {low:.4g} and {high:.4g} degC, those of the fit"
        raise DataError(what, do="Hold out ramps over the same temperatures", code="outside")
    weight, runs = cells.weight[inside], cells.run[inside]
    rows = law.basis(cells.temperature[inside])
    off, error = rows @ law.coefficients - earth, cells.reading[inside] - rows @ law.coefficients
    more, own = _more(model, axis, cells.temperature[inside], off)
    off, error = off + more, error - more
    labels = np.unique(runs)
    mean = np.array([_mean(rows, weight, runs == one) for one in labels]).mean(axis=0)
    leaned = np.array([_mean(rows * off[:, None], weight, runs == one) for one in labels]).mean(axis=0)
    both, dof = law.contrasts(np.vstack([mean, leaned]))
    spread, spread_gain, freedom = _between_power_ups(law, earth)
    m = len(labels)
    residual = float(np.mean([_mean(error, weight, runs == one) for one in labels]))
    gain = float(np.mean([_mean(off * (2.0 * error + off), weight, runs == one) for one in labels]))
    fit_rows, _ = law.contrasts(rows)
    return AxisResidual(
        axis,
        int(inside.sum()),
        m,
        float(np.sqrt(np.average((off + error) ** 2, weights=weight))),
        float(np.sqrt(np.average(error**2, weights=weight))),
        residual,
        float(np.sqrt(spread / m + both[0, 0] + laid)),
        gain,
        float(2.0 * np.sqrt(spread_gain / m + both[1, 1] + laid * float(np.average(off, weights=weight)) ** 2)),
        float(np.average(np.diag(fit_rows) if own is None else own, weights=weight)) + laid,
        float(min(freedom, dof.min())) if freedom > 0.0 else 0.0,
    )


def _more(model: SensorModel | None, axis: str, warmth: Array, off: Array) -> tuple[Array, Array | None]:
    """Return what a model has more of a bias than was taken off, and its Type A variance where that is something."""
    if model is None:
        return np.zeros(len(warmth)), None
    more = bias_of(model, axis, warmth) - off
    if np.all(np.abs(more) <= SAME * np.max(np.abs(off))):
        return np.zeros(len(warmth)), None
    variance = np.zeros(len(warmth))
    powers = 0 if model.bias_temperature is None else len(model.bias_temperature)
    reference = (
        0.0 if model.reference_temperature is None else float(model.reference_temperature[model.axes.index(axis)])
    )
    columns = np.vander(warmth - reference, 1 + powers, increasing=True)
    keys = [Key("bias", axis), *(Key("bias_temperature", axis, power=j + 1) for j in range(powers))]
    if model.estimate is not None:
        known = [j for j, key in enumerate(keys) if key in model.estimate.keys]
        chosen = model.estimate.select([keys[j] for j in known])
        for one in chosen.components:
            if one.kind == "A":
                variance += np.einsum("ij,jk,ik->i", columns[:, known], one.covariance, columns[:, known])
    return more, variance


def _mean(values: Array, weight: Array, chosen: Array) -> Array:
    return np.asarray(np.average(values[chosen], weights=weight[chosen], axis=0))


def _between_power_ups(law: Law, earth: float) -> tuple[float, float, float]:
    """Variance of the residual and of the mean product with the correction between power-ups of the fit, and dof."""
    cells = law.cells
    labels = np.unique(cells.run)
    if len(labels) < 2:
        return np.nan, np.nan, 0.0
    raw = law.basis(cells.temperature) @ law.coefficients
    error, off = cells.reading - raw, raw - earth
    means = [_mean(error, cells.weight, cells.run == one) for one in labels]
    products = [_mean(error * off, cells.weight, cells.run == one) for one in labels]
    return float(np.var(means, ddof=1)), float(np.var(products, ddof=1)), float(len(labels) - 1)


def loops(residuals: Sequence[AxisResidual], unit: str) -> tuple[AxisLoop, ...]:
    """Return the same for the closed loop, without verdicts; a dwell is a cell."""
    return tuple(
        AxisLoop(
            one.axis,
            one.cells,
            one.runs,
            one.raw,
            one.compensated,
            one.gain,
            one.u_gain if one.dof > 0.0 else float("inf"),
            one.dof if one.dof > 0.0 else 1.0,
            max(one.allowed, 0.0),
            unit,
        )
        for one in residuals
    )


def residual_rows(residuals: Sequence[AxisResidual], unit: str, against: str) -> list[Row]:
    """Return the rows of what is left on power-ups held out, SI."""
    found = []
    for one in residuals:
        if not one.dof > 0.0:
            found.append(not_estimated(Key(RESIDUAL, one.axis), unit, ONE_RUN))
            continue
        text = f"after the polynomial of {against}, mean over {one.runs} power-up(s) held out"
        interval = t_interval(one.residual, one.u, one.dof)
        reason = Reason("limits", text)
        found.append(Row(Key(RESIDUAL, one.axis), one.residual, one.u, unit, one.dof, interval, reason=reason))
    return found


NAME = "overlay"


def overlays(held: Result, first: Result, second: Result | None) -> tuple[Curve, ...]:
    """Return a curve an axis: after the first polynomial, and after the second where there is one."""
    made, unit = [], held.readings.unit
    earth = earth_along(held.plan)[0] if unit == "rad/s" else np.zeros(len(AXES))
    for axis, one in held.sensors.items():
        if axis not in first.sensors or (second is not None and axis not in second.sensors):
            continue
        columns: dict[str, Any] = {"temperature": Column(one.cells.temperature, "degC")}
        raw = one.cells.reading - earth[AXES.index(axis)]
        columns["raw"] = Column(raw, unit)
        columns["by_temperature"] = Column(raw - _bias(first, axis, one.cells.temperature), unit)
        if second is not None:
            left = raw - _bias(second, axis, one.cells.temperature)
            columns["by_temperature_and_pressure"] = Column(left, unit)
        columns["run"] = Column([held.readings.labels[run] for run in one.cells.run])
        made.append(Curve(NAME, axis, columns))
    return tuple(made)


def _bias(result: Result, axis: str, temperature: Any) -> Any:
    """Return the bias that a test found; NaN at temperatures where it is not known."""
    law = result.sensors[axis].law
    inside = (temperature >= law.domain[0]) & (temperature <= law.domain[1])
    value = law.basis(np.clip(temperature, *law.domain)) @ law.coefficients
    return np.where(inside, value - earth_along(result.plan)[0][AXES.index(axis)], np.nan)

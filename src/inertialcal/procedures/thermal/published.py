"""The reduction of the NPS thesis, as published: one unweighted cubic through all samples, in volts.

Rate volts over the volts of the temperature channel, every sample with the same weight, standard errors as if the
samples were independent; with residual sum of squares and adjusted R-square (Tables 3 and 7). It stands beside the
result with ``Method.TEXTBOOK``. The standard errors are far too small: neighbouring samples share the drift
of the bias. Where the volts are not known, in the unit of the readings over degC less the reference temperature.

References
----------
.. [1] V. V. Badescu, NPS thesis, September 2011, Tables 3, 4, 7, 8.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.polynomial import chebyshev

from ...core.estimate import Array
from ...core.key import Key, Method, Reason
from ...core.results import Row, not_estimated
from ...core.units import normalise
from ...sensors.thermal import in_unit, over_voltage
from ...statistics.intervals import t_interval
from ...statistics.least_squares import fit
from ...statistics.polynomial import Polynomial
from .fit.cells import Series
from .fit.quantities import power_unit
from .plan import Plan

ORDER = 3


@dataclass(frozen=True, eq=False)
class Published:
    """The fit as the thesis prints it.

    Parameters
    ----------
    polynomial : Polynomial
        Over volts [V], or degC.
    residual_sum_of_squares, adjusted_r_square : float
        [unit of the polynomial squared], (1).
    samples : int
        That it was fitted to.
    volts : bool
        Whether it is in volts over volts.
    """

    polynomial: Polynomial
    residual_sum_of_squares: float
    adjusted_r_square: float
    samples: int
    volts: bool


def published_fit(plan: Plan, series: Series, cut: float) -> Published | None:
    """Return the unweighted cubic through all samples after the start-up; None where there are too few."""
    axis = series.axis
    used = np.isfinite(series.reading) & np.isfinite(series.temperature)
    used &= ~(np.nan_to_num(series.time, nan=np.inf) < cut)
    T, y = series.temperature[used], series.reading[used]
    if len(np.unique(T)) <= ORDER + 1:
        return None
    domain = (float(T.min()), float(T.max()))
    found = fit(_rows(T, domain), y)
    rss = float(found.residuals @ found.residuals)
    total = float(np.sum((y - y.mean()) ** 2))
    n = len(y)
    adjusted = 1.0 - (rss / (n - ORDER - 1)) / (total / (n - 1)) if total > 0.0 else np.nan
    polynomial = Polynomial(found.coefficients, found.covariance, found.dof, domain)
    channel, volts = (plan.thermometers or {}).get(axis), (plan.scale_factor or {}).get(axis)
    if channel is None or volts is None:
        return Published(polynomial, rss, adjusted, n, False)
    over = over_voltage(polynomial, channel.slope, channel.voltage, channel.temperature)
    return Published(in_unit(over, volts), rss * volts**2, adjusted, n, True)


def _rows(T: Array, domain: tuple[float, float]) -> Array:
    return np.asarray(chebyshev.chebvander((2.0 * T - domain[0] - domain[1]) / (domain[1] - domain[0]), ORDER))


def published_rows(plan: Plan, series: Series, cut: float, unit: str) -> list[Row]:
    """Return coefficients, residual sum of squares and adjusted R-square of the published way."""
    axis, found = series.axis, published_fit(plan, series, cut)
    if found is None:
        return [
            not_estimated(
                Key("residual_sum_of_squares", axis),
                normalise(f"({unit})^2"),
                Reason("few_samples", "too few samples for a cubic"),
                Method.TEXTBOOK,
            )
        ]
    own, by = ("V", "V") if found.volts else (unit, "degC")
    stem = "bias_voltage" if found.volts else "bias_temperature"
    reference = 0.0 if found.volts else plan.reference_temperature
    values, covariance = found.polynomial.monomials(reference)
    told = f"unweighted cubic through all {found.samples} samples; its uncertainty takes them as independent"
    reason = Reason("limits", told)
    dof = found.polynomial.dof
    rows = []
    for j, value in enumerate(values):
        key = Key("bias", axis) if j == 0 and not found.volts else Key(stem, axis, power=j)
        u = None if covariance is None else float(np.sqrt(covariance[j, j]))
        interval = None if u is None else t_interval(float(value), u, dof)
        rows.append(
            Row(key, float(value), u, power_unit(own, by, j), dof, interval, reason=reason, method=Method.TEXTBOOK)
        )
    square = normalise(f"({own})^2")
    for name, value, its in (
        ("residual_sum_of_squares", found.residual_sum_of_squares, square),
        ("adjusted_r_square", found.adjusted_r_square, "1"),
    ):
        key = Key(name, axis)
        rows.append(Row(key, value, None, its, status="not_estimated", reason=reason, method=Method.TEXTBOOK))
    return rows

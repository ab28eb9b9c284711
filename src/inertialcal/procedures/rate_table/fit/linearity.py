"""Linearity error: largest deviation of the mean reading at a rate from the best straight line.

The line is straight, without asymmetry and curvature, with an intercept of its own in each recording. In percent of
the largest rate that was used (IEEE 528, linearity error; 1431, 12.9). The largest of k deviations is large by chance
alone, so it counts as seen only where it exceeds the simultaneous (Sidak) bound of k means; otherwise that bound on
top of the largest deviation is published as an upper limit.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ....core.estimate import Array
from ....core.key import Key, Reason
from ....core.results import Interval, Row, not_estimated
from ....statistics.intervals import band_factor, coverage_factor
from ....statistics.least_squares import times
from .regression import Line, dwell_variance

FEW = 3.0  # degrees of freedom that the scatter about a line of its own slope in each recording needs


@dataclass(frozen=True)
class Deviation:
    """Largest deviation from the straight line: at which rate [rad/s], how much and how sure [rad/s]."""

    rate: float
    size: float
    u: float
    dof: float
    rates: int
    full_scale: float


def deviations(straight: Line, full: Line | None = None) -> tuple[Array, Array, Array, float] | None:
    """Return rates, mean deviations from the line, their u [rad/s] and its degrees of freedom.

    None where scatter or rates are too few. The scatter is that of the dwells about ``full``, a line of its own slope
    in each recording with all curvatures that the rates allow, so that no curvature counts as scatter. Where a rate
    belongs to few of the recordings, what is theirs cannot be told from a deviation: the scatter is then that of
    dwells and runs.
    """
    turned, fit = straight.readings.turned, straight.fit
    rates, mean = turned.rates.get(straight.sensor, (np.zeros(0), np.zeros((0, 0))))
    alike = fit.own and turned.shared_rates[straight.sensor]
    variance = _scatter(straight, full, alike)
    if variance is None or len(rates) < 3 or variance[2] < 1.0:
        return None
    dwell, between, dof = variance
    means = times(mean, fit.local if alike else fit.residuals)
    if alike:
        square = dwell * turned.beside_basis(straight.sensor, fit.basis)
    else:
        beside = mean - (mean @ fit.design) @ fit.solve
        in_groups = np.array([np.sum(np.bincount(fit.groups, one) ** 2) for one in beside])
        square = dwell * np.sum(beside**2, axis=1) + between * in_groups
    return rates, means, np.sqrt(square + np.finfo(float).tiny), dof


def _scatter(straight: Line, full: Line | None, alike: bool) -> tuple[float, float, float] | None:
    """Return the variances of a dwell and between recordings [(rad/s)^2], and the degrees of freedom of their sum."""
    readings = straight.readings
    if not alike:
        return _with_recordings(straight)
    lines = [straight] if full is None or len(full.readings) != len(readings) else [full, straight]
    for one in lines:
        turned = one.readings.turned
        basis, dof = turned.line(one.sensor, one.asymmetry, one.curvature).beside_lines
        if dof >= FEW:
            left = turned.beside(one.fit.local)
            residuals = left - basis @ (basis.T @ left)
            return float(residuals @ residuals) / dof, 0.0, float(dof)
    fit = straight.fit
    return None if fit.mean_square is None else (float(fit.local @ fit.local) / fit.dof, 0.0, fit.dof)


def _with_recordings(straight: Line) -> tuple[float, float, float] | None:
    """Return the same where rates belong to few recordings: of the levels, or as large as the residuals show it."""
    readings, fit = straight.readings, straight.fit
    dwell, run = (next(one for one in straight.levels if one.name == name) for name in ("dwell", "run"))
    square = 0.0 if dwell.std is None else dwell.std**2
    if run.std is not None or not fit.own or dwell.std is None:
        whole = dwell_variance(straight.levels, len(readings) / readings.runs if readings.runs else 1.0)
        return None if whole is None else (min(square, whole[0]), max(whole[0] - square, 0.0), whole[1])
    solved, count = fit.solve @ fit.design, int(np.max(fit.groups)) + 1
    parts = len(readings) - 2.0 * np.trace(solved) + np.sum((fit.design.T @ fit.design) * (fit.solve @ fit.solve.T))
    offsets = np.eye(count)[fit.groups]
    offsets = offsets - fit.design @ (fit.solve @ offsets)
    between = max(float(fit.residuals @ fit.residuals - square * parts) / float(np.sum(offsets**2)), 0.0)
    return square, between, (square + between) ** 2 / (square**2 / dwell.dof + between**2 / max(count - 1.0, 1.0))


def largest_deviation(straight: Line, full: Line | None = None) -> Deviation | None:
    """Find the largest deviation of a rate's mean from the line; None where scatter or rates are too few."""
    found = deviations(straight, full)
    if found is None:
        return None
    rates, means, sigmas, dof = found
    worst = int(np.abs(means).argmax())
    full_scale = float(np.abs(rates).max())
    return Deviation(float(rates[worst]), abs(float(means[worst])), float(sigmas[worst]), dof, len(rates), full_scale)


def linearity_row(straight: Line | None, sensor: str, full: Line | None = None) -> Row:
    """Return the linearity error in percent of the largest rate used."""
    found = None if straight is None else largest_deviation(straight, full)
    key = Key("linearity_error", sensor)
    if found is None:
        reason = "needs three rates or more about the sensor's own axis, and repeated dwells"
        return not_estimated(key, "%", Reason("few_rates", reason))
    percent = 100.0 / found.full_scale
    bound = band_factor(found.rates, found.dof, 0.95) * found.u
    if found.size <= bound:
        value = (found.size + bound) * percent
        reason = f"no deviation stands out among {found.rates} rates: the largest plus its simultaneous bound"
        return Row(
            key,
            value,
            found.u * percent,
            "%",
            found.dof,
            Interval(0.0, value),
            "upper_limit",
            Reason("not_seen", reason),
        )
    half = coverage_factor(found.dof, 0.95) * found.u
    interval = Interval((found.size - half) * percent, (found.size + half) * percent)
    return Row(key, found.size * percent, found.u * percent, "%", found.dof, interval)

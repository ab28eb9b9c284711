"""Linearity error: largest deviation of the mean reading at a rate from the best straight line.

The line is straight, without asymmetry and curvature, with an intercept of its own in each recording. In percent of
the largest rate that was used (IEEE 528, linearity error; 1431, 12.9). The largest of k deviations is large by chance
alone, so it counts as seen only where it exceeds the simultaneous (Sidak) bound of k means; otherwise that bound on
top of the largest deviation is published as an upper limit.
"""

from __future__ import annotations

from collections.abc import Sequence
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


Deviations = tuple[Array, Array, Array, float]


def deviations(straight: Line, full: Line | None = None) -> Deviations | None:
    """Return rates, mean deviations from the line, their u [rad/s] and its degrees of freedom.

    None where scatter or rates are too few. The scatter is that of the dwells about ``full``, a line of its own slope
    in each recording with all curvatures that the rates allow, so that no curvature counts as scatter. Where a rate
    belongs to few of the recordings, what is theirs cannot be told from a deviation: the scatter is then that of
    dwells and runs.
    """
    return deviations_each([(straight, full)])[0]


def deviations_each(lines: Sequence[tuple[Line, Line | None]]) -> list[Deviations | None]:
    """Return the `deviations` of each of several lines; those of units that were turned alike at once."""
    found: list[Deviations | None] = [None] * len(lines)
    kinds: dict[tuple[object, ...], list[int]] = {}
    for i, (straight, full) in enumerate(lines):
        turned, fit = straight.readings.turned, straight.fit
        if fit.own and turned.shared_rates[straight.sensor]:
            more = None if full is None else (id(full.readings.turned), full.asymmetry, full.curvature)
            kind = (id(turned), straight.sensor, straight.asymmetry, straight.curvature, id(fit.basis), more)
            kinds.setdefault(kind, []).append(i)
        else:
            found[i] = _among_few(straight)
    for at in kinds.values():
        for i, one in zip(at, _alike([lines[i] for i in at]), strict=True):
            found[i] = one
    return found


def _among_few(straight: Line) -> Deviations | None:
    """Return the deviations where a rate belongs to few of the recordings."""
    fit, variance = straight.fit, _with_recordings(straight)
    rates, mean = straight.readings.turned.rates.get(straight.sensor, (np.zeros(0), np.zeros((0, 0))))
    if variance is None or len(rates) < 3 or variance[2] < 1.0:
        return None
    dwell, between, dof = variance
    beside = mean - (mean @ fit.design) @ fit.solve
    in_groups = np.array([np.sum(np.bincount(fit.groups, one) ** 2) for one in beside])
    square = dwell * np.sum(beside**2, axis=1) + between * in_groups
    return rates, times(mean, fit.residuals), np.sqrt(square + np.finfo(float).tiny), dof


def _alike(lines: Sequence[tuple[Line, Line | None]]) -> list[Deviations | None]:
    """Return the deviations of lines of one kind of units that were turned alike."""
    first, whole = lines[0]
    turned, fit, count = first.readings.turned, first.fit, len(lines)
    rates, mean = turned.rates.get(first.sensor, (np.zeros(0), np.zeros((0, 0))))
    local = np.array([one.fit.local for one, _ in lines])
    dwell, dof = [None if one.fit.mean_square is None else float(np.sum(one.fit.local**2)) / one.fit.dof
                  for one, _ in lines], fit.dof  # fmt: skip
    tried = [(first, local)]
    if whole is not None and len(whole.readings) == len(first.readings):
        tried.insert(0, (whole, np.array([one.fit.local for _, one in lines if one is not None])))
    for one, own in tried:
        basis, free = one.readings.turned.line(one.sensor, one.asymmetry, one.curvature).beside_lines
        if free >= FEW:
            left = one.readings.turned.beside(own)
            residuals = left - times(basis, times(basis.T, left))
            dwell, dof = (np.sum(residuals**2, axis=-1) / free).tolist(), float(free)
            break
    if len(rates) < 3 or dof < 1.0:
        return [None] * count
    means, beside = times(mean, local), turned.beside_basis(first.sensor, fit.basis)
    return [
        None if square is None else (rates, own, np.sqrt(square * beside + np.finfo(float).tiny), dof)
        for square, own in zip(dwell, means, strict=True)
    ]


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
    return _largest(deviations(straight, full))


def _largest(found: Deviations | None) -> Deviation | None:
    if found is None:
        return None
    rates, means, sigmas, dof = found
    worst = int(np.abs(means).argmax())
    full_scale = float(np.abs(rates).max())
    return Deviation(float(rates[worst]), abs(float(means[worst])), float(sigmas[worst]), dof, len(rates), full_scale)


def linearity_row(sensor: str, known: Deviations | None) -> Row:
    """Return the linearity error in percent of the largest rate used, by the `deviations` of the sensor's line."""
    found = _largest(known)
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

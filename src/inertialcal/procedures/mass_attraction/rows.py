"""Rows and curves of a mass-attraction calibration: scale factor, comparisons, and each run alone."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from ...core.curve import Column, Curve
from ...core.key import NO_REASON, Key, Member, Method, Reason
from ...core.results import Interval, Row, not_estimated
from ...signals.correlation import autocorrelation
from ...statistics.intervals import coverage_factor, t_interval
from .published import published_rows
from .readings import Run
from .response import SCALE, UNIT, Response, compared_with, estimate_of, shape_of

if TYPE_CHECKING:
    from .reduction import Result

OTHER = {
    "within_runs": "by the noise next to the line of each run: right if nothing differs from run to run",
    "between_runs": "by the scatter of the runs",
}
LAGS = 0.5  # of the dwells


def rows(result: Result) -> Iterator[Row]:
    """Yield all rows, SI."""
    axis, estimate = result.plan.axis, result.estimate
    if estimate is None:
        yield not_estimated(Key(SCALE, axis), UNIT, Reason("not_told", result.reason))
    else:
        reference = compared_with(result.plan, estimate)
        for key, value, u, unit, dof in zip(
            estimate.keys, estimate.values, estimate.u, estimate.units, estimate.dof, strict=True
        ):
            reason = Reason("limits", reference.get(key.quantity, ""))
            yield _row(key, float(value), float(u), unit, float(dof), reason)
        if result.combined is not None and result.combined.between is not None:
            other = "within_runs" if result.scatter == "between_runs" else "between_runs"
            found = estimate_of(result.plan, result.readings, result.responses, result.combined, other)
            value, u, dof = (float(one[0]) for one in (found.values, found.u, found.dof))
            yield _row(Key(SCALE, axis), value, u, UNIT, dof, Reason("limits", OTHER[other]), Method(other))
    yield from published_rows(result)
    for one in result.responses:
        yield from _rows_of_run(result, one)


def _row(
    key: Key, value: float, u: float, unit: str, dof: float, reason: Reason = NO_REASON,
    method: Method = Method.RESULT, member: Member | None = None,
) -> Row:  # fmt: skip
    shown = dof if math.isfinite(dof) else None
    return Row(key, value, u, unit, shown, t_interval(value, u, dof), reason=reason, method=method, member=member)


def _rows_of_run(result: Result, one: Response) -> Iterator[Row]:
    axis, alone = result.plan.axis, Member("run", one.name)
    if not one.moved:
        size = result.per_applied
        if size:
            reason = Reason("zero_expected", "the mass did not move: zero is expected")
            key = Key("null_response", axis)
            yield _row(key, one.amplitude / size, one.u / size, "m/s^2", one.dof, reason, member=alone)
    elif one.significant(result.plan.floor):
        noise = Reason("limits", "its own noise alone, without the uncertainty of what is applied")
        yield _row(Key("response_amplitude", axis), one.amplitude, one.u, "count/s", one.dof, member=alone)
        yield _row(Key(SCALE, axis), one.scale_factor, one.u_scale_factor, UNIT, one.dof, noise, member=alone)
    else:
        limit = t_interval(abs(one.amplitude), one.u, one.dof, 0.9).hi
        below = f"below {result.plan.floor:g} times the noise floor of {one.u:.3g} count/s: cannot be told from noise"
        reason = Reason("not_told", below)
        yield Row(Key("response_amplitude", axis), limit, None, "count/s", None, Interval(0.0, limit), "upper_limit",
                  reason, member=alone)  # fmt: skip
        yield not_estimated(Key(SCALE, axis), UNIT, reason, member=alone)
    if math.isfinite(one.u_quadrature):
        ahead = Reason("zero_expected", "a quarter of a cycle ahead of the drive: zero is expected")
        key = Key("quadrature_amplitude", axis)
        yield _row(key, one.quadrature, one.u_quadrature, "count/s", one.dof, ahead, member=alone)
    if math.isfinite(one.tilt):
        of_pad = Reason("limits", "of the pad in phase with the drive, mercury subtracted")
        yield _row(Key("tilt_amplitude", axis), one.tilt, one.u_tilt, "rad", one.dof, of_pad, member=alone)


def curves(result: Result) -> list[Curve]:
    """Return the curves, SI: each run with its line, correlation and spectrum, then all runs."""
    by_name = {one.name: one for one in result.responses}
    found = []
    for run in result.readings.series:
        if by_name[run.name].fitted is not None:
            found += _curves_of_run(result.plan.axis, run, by_name[run.name])
    return [*found, _runs(result)]


def _curves_of_run(axis: str, run: Run, one: Response) -> list[Curve]:
    """Return series, autocorrelation (gaps count as zero) and Fourier amplitudes of a run; gaps are NaN."""
    schedule, fitted = run.schedule, one.fitted
    assert fitted is not None  # noqa: S101 - checked before
    reduced = np.asarray(one.series - fitted.drift)  # without drift and tilt
    series = {
        "time": Column(schedule.middle, "s", shown="h"),
        "reading": Column(run.reading, "count/s"),
        "drift": Column(fitted.drift, "count/s"),
        "reduced": Column(reduced, "count/s"),
        "line": Column(fitted.line, "count/s"),
        "shape": Column(shape_of(schedule)),
    }
    lags = int(LAGS * len(reduced))
    both = [autocorrelation(np.nan_to_num(part), lags).values for part in (reduced, reduced - fitted.line)]
    correlation = {
        "lag": Column(np.arange(lags + 1) * schedule.step, "s", shown="h"),
        "reduced": Column(both[0] / both[0][0], "1"),
        "noise": Column(both[1] / both[0][0], "1"),
    }
    there, length = np.isfinite(reduced), len(reduced) * schedule.step
    frequencies = np.arange(1, len(reduced) // 2 + 1) / length
    # amplitudes by projection: gaps have no row
    waves = np.exp(-1j * (2.0 * np.pi * np.outer(schedule.middle[there], frequencies)))
    half = np.where(np.isclose(frequencies * 2.0 * schedule.step, 1.0), 1.0, 2.0)
    amplitude = half * np.abs(waves.T @ reduced[there]) / there.sum()
    role = np.full(len(frequencies), "", dtype=object)
    for k, f in enumerate(fitted.frequencies):
        role[np.abs(frequencies - f) < 0.5 / length] = "beside" if k else "drive"
    spectrum = {
        "frequency": Column(frequencies, "Hz"),
        "amplitude": Column(amplitude, "count/s"),
        "role": Column(role.tolist()),
    }
    named = {"mass_series": series, "mass_correlation": correlation, "mass_spectrum": spectrum}
    return [Curve(name, axis, columns, recording=run.name) for name, columns in named.items()]


def _runs(result: Result) -> Curve:
    """Return all runs with their responses, and with the figures of the published way."""
    lines = {line.name: line for line in result.published[0]}

    def each(value: str) -> list[float]:
        return [float(getattr(one, value)) for one in result.responses]

    def published(name: str) -> list[float]:
        return [float(getattr(lines[one.name], name)) if one.name in lines else np.nan for one in result.responses]

    scale, u = np.array(each("scale_factor")), np.array(each("u_scale_factor"))
    half = u * np.array([coverage_factor(one.dof) for one in result.responses])
    columns = {
        "run": Column([one.name for one in result.responses]),
        "moved": Column([one.moved for one in result.responses]),
        "applied": Column(each("applied"), "m/s^2"),
        "response": Column(each("amplitude"), "count/s"),
        "u": Column(each("u"), "count/s"),
        "scale_factor": Column(scale, UNIT),
        "lo": Column(scale - half, UNIT),
        "hi": Column(scale + half, UNIT),
        "tilt": Column(each("tilt"), "rad"),
        "published_fourier": Column(published("response"), "count/s"),
        "published_fourier_noise": Column(published("noise"), "count/s"),
        "published_spectrum": Column(published("psd_response"), "count/s"),
        "published_spectrum_noise": Column(published("psd_noise"), "count/s"),
        "published_scatter": Column(published("scatter"), "count/s"),
    }
    return Curve("mass_runs", result.plan.axis, columns)

"""Curves of a mass-attraction calibration: each run before and after reduction, its correlation, its line, all runs."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...core.curve import Column, Curve
from ...core.estimate import Array
from ...signals.correlation import autocorrelation
from ...statistics.intervals import coverage_factor
from .readings import Run
from .response.line import shape_of
from .response.of_run import Response

if TYPE_CHECKING:
    from .reduction import Result

UNIT = "count/s/(m/s^2)"
LAGS = 0.5  # of the dwells


def curves(result: Result) -> list[Curve]:
    """Return the curves, SI.

    Parameters
    ----------
    result : Result
        Of the campaign.
    """
    axis = result.plan.axis
    found = []
    by_name = {one.name: one for one in result.responses}
    for run in result.readings.series:
        one = by_name[run.name]
        if one.fitted is not None:
            found += [_series(axis, run, one), _correlation(axis, run, one), _spectrum(axis, run, one)]
    return [*found, _runs(result)]


def _without(one: Response) -> Array:
    """Return the readings of a run without drift and tilt, shape (n,); NaN where there is none."""
    assert one.fitted is not None  # noqa: S101 - asked before
    return np.asarray(one.series - one.fitted.drift)


def _series(axis: str, run: Run, one: Response) -> Curve:
    assert one.fitted is not None  # noqa: S101 - asked before
    columns = {
        "time": Column(run.schedule.middle, "s", shown="h"),
        "reading": Column(run.reading, "count/s"),
        "drift": Column(one.fitted.drift, "count/s"),
        "reduced": Column(_without(one), "count/s"),
        "line": Column(one.fitted.line, "count/s"),
        "shape": Column(shape_of(run.schedule)),
    }
    return Curve("mass_series", axis, columns, recording=run.name)


def _correlation(axis: str, run: Run, one: Response) -> Curve:
    """Autocorrelation of the reduced readings and of what the line leaves; gaps count as zero."""
    reduced = _without(one)
    left = reduced - one.fitted.line if one.fitted is not None else reduced
    lags = int(LAGS * len(reduced))
    both = [autocorrelation(np.nan_to_num(part), lags).values for part in (reduced, left)]
    columns = {
        "lag": Column(np.arange(lags + 1) * run.schedule.step, "s", shown="h"),
        "reduced": Column(both[0] / both[0][0], "1"),
        "noise": Column(both[1] / both[0][0], "1"),
    }
    return Curve("mass_correlation", axis, columns, recording=run.name)


def _spectrum(axis: str, run: Run, one: Response) -> Curve:
    """Amplitude of each Fourier line of the reduced readings; which are read as noise."""
    assert one.fitted is not None  # noqa: S101 - asked before
    reduced = _without(one)
    there = np.isfinite(reduced)
    length = len(reduced) * run.schedule.step
    frequencies = np.arange(1, len(reduced) // 2 + 1) / length
    turn = 2.0 * np.pi * np.outer(run.schedule.middle[there], frequencies)
    # amplitudes by projection: gaps have no row
    waves = np.exp(-1j * turn)
    half = np.where(np.isclose(frequencies * 2.0 * run.schedule.step, 1.0), 1.0, 2.0)
    amplitude = half * np.abs(waves.T @ reduced[there]) / there.sum()
    near = 0.5 / length
    role = np.full(len(frequencies), "", dtype=object)
    for k, f in enumerate(one.fitted.frequencies):
        role[np.abs(frequencies - f) < near] = "beside" if k else "drive"
    columns = {
        "frequency": Column(frequencies, "Hz"),
        "amplitude": Column(amplitude, "count/s"),
        "role": Column(role.tolist()),
    }
    return Curve("mass_spectrum", axis, columns, recording=run.name)


def _runs(result: Result) -> Curve:
    """All runs with what each responds, and what the published way makes of it."""
    factors = {one.name: coverage_factor(one.dof) for one in result.responses}
    lines = {line.name: line for line in result.published[0]}

    def each(value: str) -> list[float]:
        return [float(getattr(one, value)) for one in result.responses]

    def of_lines(name: str) -> list[float]:
        return [float(getattr(lines[one.name], name)) if one.name in lines else np.nan for one in result.responses]

    scale, u = np.array(each("scale_factor")), np.array(each("u_scale_factor"))
    half = u * np.array([factors[one.name] for one in result.responses])
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
        "published_fourier": Column(of_lines("response"), "count/s"),
        "published_fourier_noise": Column(of_lines("noise"), "count/s"),
        "published_spectrum": Column(of_lines("psd_response"), "count/s"),
        "published_spectrum_noise": Column(of_lines("psd_noise"), "count/s"),
        "published_scatter": Column(of_lines("scatter"), "count/s"),
    }
    return Curve("mass_runs", result.plan.axis, columns)

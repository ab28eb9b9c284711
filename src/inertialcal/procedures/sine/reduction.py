"""A known drive in drift: its line in each channel, in the noise of the record.

Estimated: amplitude (and phase, where it is free) of a sine of known period, or of a sequence of dwells that was
applied. Assumed: nothing else follows the drive; drift is smooth over a period of the drive, or longer. The
uncertainty: white noise and a random walk, as sums of readings show them that neither drive nor drift enters
(``signals.sine.fit``). Where real data break it: drift with parts near the drive (remarked: ``drift_near_drive``), a
step in the level
(``jump``), a response that changes within the record (``scale_changed``).

References
----------
.. [1] K. Reinel, NASA TM X-53857, 1969.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...core.curve import Column, Curve
from ...core.errors import DataError
from ...core.estimate import Array
from ...core.key import Key, Method, Reason
from ...core.remarks import Remark, Severity, gather
from ...core.results import Interval, Row
from ...core.show.rounding import freedom, number, with_uncertainty
from ...core.units import FILE_UNIT
from ...files.text.headers import bare_name
from ...signals.sine.amplitude import amplitude_of
from ...signals.sine.cross_checks import CrossCheck, cross_checks, smoothing_remark
from ...signals.sine.fit import LineFit
from ...statistics.intervals import chi_square_interval, coverage_factor, t_interval, upper_bound
from .inputs import SEEN, Driven
from .plan import Plan

FLOOR = 3.0  # standard uncertainties below which an amplitude is an upper limit
FEW_DOF = 8.0
STRANGE = 0.999  # probability of the interval outside which the quadrature of a known phase is remarked
MOST = 4000  # rows of a curve
METHODS = {"alternating_differences": Method.DIFFERENCES, "generalised_least_squares": Method.GENERALISED}
SIDES = 6  # lines on each side of the drive, that are marked
AROUND = 3  # shown lines on each side, over those that are marked


@dataclass(frozen=True, eq=False)
class Readings:
    """Channels under the drive."""

    driven: tuple[Driven, ...]
    remarks: tuple[Remark, ...] = ()

    def __len__(self) -> int:
        """Return the number of samples, or of dwells with a reading."""
        return sum(len(one.readings) for one in self.driven)

    @property
    def runs(self) -> int:
        """Number of channels."""
        return len(self.driven)


@dataclass(frozen=True, eq=False)
class Result:
    """The line of each channel."""

    plan: Plan
    readings: Readings
    lines: tuple[SineResult, ...]
    remarks: tuple[Remark, ...] = ()

    @property
    def estimate(self) -> None:
        """None: each figure stands in its row, those of different channels are independent."""
        return

    def rows(self) -> tuple[Row, ...]:
        """Rows of ``results.json``."""
        return tuple(row for one in self.lines for row in one.rows())

    def curves(self) -> list[Curve]:
        """Curves of ``results.json``."""
        return [curve for one in self.lines for curve in one.curves()]


def reduce(plan: Plan, readings: Readings) -> Result:
    """Find the drive in each channel.

    Raises
    ------
    DataError
        ``no_recordings`` if there is no channel; as ``signals.sine``.
    """
    if not readings.driven:
        raise DataError("no channel", code="no_recordings")
    lines = tuple(line_of(plan, one) for one in readings.driven)
    remarks = gather([*readings.remarks, *(remark for one in lines for remark in one.remarks())])
    return Result(plan, readings, lines, remarks)


def line_of(plan: Plan, driven: Driven) -> SineResult:
    """Fit the drive to one channel, with the other estimates.

    Raises
    ------
    DataError, PlanError
        As ``signals.sine``.
    """
    checks = cross_checks(driven.fit, driven.readings) if driven.drive.phase_known else ()
    return SineResult(driven, driven.fit, checks)


@dataclass(frozen=True, eq=False)
class SineResult:
    """The line of one channel."""

    driven: Driven  # Readings and drive
    fit: LineFit  # Of them
    checks: tuple[CrossCheck, ...]  # Other estimates

    @property
    def unit(self) -> str:
        """Of the amplitude."""
        return self.driven.unit or FILE_UNIT

    @property
    def _axis(self) -> str:
        return self.driven.channel.axis or bare_name(self.driven.channel.name)

    @property
    def _dof(self) -> float:
        return float(self.fit.dof[0])

    def rows(self) -> tuple[Row, ...]:
        """Return amplitude, quadrature or phase, noise density, and the other estimates."""
        known, part = self.fit.design.drive.phase_known, self.driven.response
        density = float(np.sqrt(self.fit.density[0]))
        u, interval = density / math.sqrt(2.0 * self._dof), chi_square_interval(density, self._dof)
        noise = Row(Key("noise_density", self._axis), density, u, f"{self.unit}/sqrt(Hz)", self._dof, interval)
        checked = [
            Row(Key("amplitude", self._axis), one.value / part, one.u / part, self.unit, method=METHODS[one.name])
            for one in self.checks
            if known and one.value is not None and one.u is not None
        ]
        return (*(self._known_phase() if known else self._free_phase()), noise, *checked)

    @property
    def scale_factor(self) -> tuple[float, float, float, float] | None:
        """Of a channel whose applied amplitude is known: value, u by noise, u by what is applied, degrees of freedom.

        None where the response cannot be told from noise.
        """
        applied, fit, part = self.driven.applied, self.fit, self.driven.response
        if not applied or not fit.design.drive.phase_known:
            return None
        value, u = float(fit.in_phase[0]) / part / applied, float(fit.u_in_phase[0]) / part / abs(applied)
        if abs(value) < FLOOR * u:
            return None
        return value, u, abs(value) * (self.driven.u_applied or 0.0), self._dof

    def _known_phase(self) -> Iterator[Row]:
        fit, dof, part = self.fit, self._dof, self.driven.response
        key, value, u = Key("amplitude", self._axis), float(fit.in_phase[0]) / part, float(fit.u_in_phase[0]) / part
        limited = abs(value) < FLOOR * u
        if limited:
            limit = upper_bound(abs(value), u, dof)
            why = f"in phase {with_uncertainty(value, u)}: below {FLOOR:g} times the noise of an amplitude"
            yield _upper_limit(key, limit, self.unit, dof, why)
        else:
            yield Row(key, value, u, self.unit, dof, t_interval(value, u, dof))
        if fit.quadrature is not None and fit.u_quadrature is not None:
            across, own = float(fit.quadrature[0]) / part, float(fit.u_quadrature[0]) / part
            yield Row(Key("quadrature", self._axis), across, own, self.unit, dof, t_interval(across, own, dof))
        if self.driven.applied is not None and self.driven.unit:
            key, applied = Key("scale_factor", self._axis), self.driven.applied
            unit = "1" if self.driven.unit == "m/s^2" else f"{self.driven.unit}/(m/s^2)"
            found, own = value / (applied or math.nan), u / abs(applied or math.nan)
            total = math.hypot(own, abs(found) * (self.driven.u_applied or 0.0))
            dof = dof * (total / own) ** 4
            if limited:
                yield _upper_limit(key, upper_bound(abs(found), total, dof), unit, dof, "the amplitude is one")
            else:
                yield Row(key, found, total, unit, dof, t_interval(found, total, dof))

    def _free_phase(self) -> Iterator[Row]:
        fit, part = self.fit, self.driven.response
        assert fit.quadrature is not None  # noqa: S101 - a free phase has both
        assert fit.u_quadrature is not None  # noqa: S101
        a, b = float(fit.in_phase[0]), float(fit.quadrature[0])
        u = float(np.hypot(fit.u_in_phase[0], fit.u_quadrature[0]) / np.sqrt(2.0))
        found = amplitude_of(a, b, u, self._dof)
        value, own, key = float(found.value[0]) / part, u / part, Key("amplitude", self._axis)
        if float(found.chance[0]) > 0.05 or math.hypot(a, b) < FLOOR * u:
            length = math.hypot(a, b) / part
            why = f"length {number(length, 3)}, noise of a component {number(own, 3)}: below {FLOOR:g} times it"
            yield _upper_limit(key, float(found.limit[0]) / part, self.unit, self._dof, why)
            return
        interval = Interval(float(found.lo[0]) / part, float(found.hi[0]) / part)
        yield Row(key, value, own, self.unit, self._dof, interval)
        angle, u_angle = math.degrees(math.atan2(b, a)), math.degrees(own / value)
        yield Row(Key("phase", self._axis), angle, u_angle, "deg", self._dof, t_interval(angle, u_angle, self._dof))

    def summary(self) -> str:
        """Return one line: drive, readings, drift and noise, and why an amplitude is an upper limit."""
        drive = self.fit.design.drive
        kind = "sine" if drive.quadrature is not None else "applied sequence"
        limits = [f"; {row.quantity}: {row.reason}" for row in self.rows() if row.status == "upper_limit"]
        return (
            f"{self._axis}: {kind} of {number(1.0 / drive.frequency, 6)} s,"
            f" phase {'known' if drive.phase_known else 'free'},"
            f" {len(self.driven.readings)} readings, {number(drive.cycles, 5)} cycles, noise with"
            f" {freedom(self._dof, 3)}{''.join(limits)}"
        )

    def remarks(self) -> tuple[Remark, ...]:
        """Return the remarks on the fit."""
        fit, remarks = self.fit, list(self.driven.remarks)
        if self.driven.loss > SEEN:
            more, step = self.driven.loss / (1.0 - self.driven.loss), number(fit.design.drive.step, 6)
            what = "the amplitude is that of the readings as they are: if each is a mean over its interval,"
            what += f" the drive is {number(100.0 * more, 3)} % larger"
            length = float(np.hypot(fit.in_phase[0], 0.0 if fit.quadrature is None else fit.quadrature[0]))
            level: Severity = "warning" if more * length > fit.u_in_phase[0] else "info"
            do = f'Say how samples are made: --averaging "{step} s" for means, --averaging "0 s" for points'
            remarks.append(Remark("averaging", level, what, do=do))
        if self._dof < FEW_DOF:
            what = f"the noise has {freedom(self._dof, 2)}: {number(fit.design.drive.cycles, 3)} cycles"
            remarks.append(Remark("few_cycles", "warning", what, do="Record more cycles"))
        known = fit.design.drive.phase_known
        amplitude = float(fit.in_phase[0]) if known or fit.quadrature is None else math.hypot(
            float(fit.in_phase[0]), float(fit.quadrature[0]))  # fmt: skip
        shifts = [(one.length, float(one.value[0]), float(one.u[0]), float(one.dof[0]))
                  for one in fit.shifts if not (known and one.across)]  # fmt: skip
        if (moved := smoothing_remark(shifts, amplitude, float(fit.u_in_phase[0]))) is not None:
            remarks.append(moved)
        if fit.design.drive.phase_known and fit.quadrature is not None and fit.u_quadrature is not None:
            across = float(fit.quadrature[0])
            if abs(across) > coverage_factor(self._dof, STRANGE) * fit.u_quadrature[0]:
                turn = math.degrees(math.atan2(across, float(fit.in_phase[0])))
                what = f"the line is {number(turn, 3)} deg ahead of the drive: part of it is not in phase"
                do = "Check phase and schedule against the clock of the record; a response that lags does the same"
                remarks.append(Remark("phase", "warning", what, do=do))
        remarks += [one.remark() for one in self.checks if one.disagrees]
        if self.driven.applied is not None and self.driven.u_applied is None:
            what = "the applied amplitude has no stated uncertainty: that of the scale factor is scatter only"
            do = "Write '# u of applied: NUMBER %' in the schedule"
            remarks.append(Remark("applied_not_stated", "warning", what, do=do))
        return tuple(remarks)

    def curves(self) -> list[Curve]:
        """Return the series with drift and line, and the lines around the drive; long series thinned."""
        line, drift = self.fit.fitted()
        return [self._series(line, drift), self._lines(self.driven.readings - drift)]

    def _series(self, line: Array, drift: Array) -> Curve:
        x, times = self.driven.readings, self.fit.design.drive.times
        rest = x - drift
        kept = _extremes(rest, MOST)
        columns = {"time": Column((times - times[0])[kept], "s")}
        parts = {"reading": x, "drift": drift, "without_drift": rest, "line": line}
        columns |= {name: Column(values[kept], self.unit) for name, values in parts.items()}
        return Curve("sine_series", self._axis, columns)

    def _lines(self, rest: Array) -> Curve:
        drive, sides = self.fit.design.drive, SIDES
        reach = np.arange(-AROUND * sides, AROUND * sides + 1)
        frequency = drive.frequency + reach / drive.span
        good = (frequency > 0.5 / drive.span) & (frequency <= 0.5 / drive.step * (1.0 + 1e-9))
        reach, frequency = reach[good], frequency[good]
        amplitude = lines_at(rest, drive.times - drive.times[0], frequency[0], 1.0 / drive.span, len(frequency))
        amplitude[np.isclose(frequency, 0.5 / drive.step, rtol=1e-9)] *= 0.5
        role = ["drive" if j == 0 else "side_band" if abs(j) <= sides else "other" for j in reach.tolist()]
        columns = {
            "frequency": Column(frequency, "Hz"),
            "amplitude": Column(amplitude, self.unit),
            "role": Column(role),
        }
        return Curve("sine_lines", self._axis, columns)


def _upper_limit(key: Key, limit: float, unit: str, dof: float, why: str) -> Row:
    return Row(key, limit, None, unit, dof, Interval(0.0, limit), "upper_limit", Reason("not_found", why))


def lines_at(x: Array, times: Array, first: float, spacing: float, count: int) -> Array:
    """Return amplitudes of lines at equally spaced frequencies, of samples at any times; shape (count,).

    Parameters
    ----------
    x, times : ndarray, shape (n,)
        Readings without drift, and when [s].
    first, spacing : float
        Lowest frequency, and from one to the next [Hz].
    count : int
        How many.
    """
    turned, by = x * np.exp(-2j * np.pi * first * times), np.exp(-2j * np.pi * spacing * times)
    found = np.empty(count)
    for k in range(count):
        found[k] = 2.0 / len(x) * abs(turned.sum())
        turned = turned * by
    return found


def _extremes(values: Array, most: int) -> NDArray[np.int64]:
    """Return the places of the least and the largest of so many bins, all where there are few."""
    n = len(values)
    if n <= most:
        return np.arange(n)
    size = -(-n // (most // 2))
    starts = np.arange(0, n, size)
    places = [(s + int(np.argmin(values[s : s + size])), s + int(np.argmax(values[s : s + size]))) for s in starts]
    return np.unique(np.array(places).ravel())

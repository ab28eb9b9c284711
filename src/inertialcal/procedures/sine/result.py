"""Figures, remarks and curves of a drive that was fitted: what a user sees of ``signals.sine``."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...core.curve import Column, Curve
from ...core.estimate import Array
from ...core.key import Key, Method, Reason
from ...core.remarks import Remark
from ...core.results import Interval, Row
from ...core.show.rounding import number, with_uncertainty
from ...files.text.headers import bare_name
from ...signals.sine import CrossCheck, LineFit, amplitude_of
from ...statistics.intervals import chi_square_interval, coverage_factor, t_interval, upper_bound
from ..static_noise.reduction import FILE_UNIT
from .inputs import Driven

FLOOR = 3.0  # standard uncertainties below which an amplitude is an upper limit
FEW_DOF = 8.0
STRANGE = 0.999  # probability of the interval that a quadrature of a known phase must leave to be remarked
MOST = 4000  # rows of a curve
METHODS = {"alternating_differences": Method.DIFFERENCES, "generalised_least_squares": Method.GENERALISED}
AROUND = 3  # lines on each side that are shown, over the side bands


@dataclass(frozen=True, eq=False)
class SineResult:
    """What was found in one channel.

    Parameters
    ----------
    driven : Driven
        Readings and drive.
    fit : LineFit
        Of them.
    checks : tuple of CrossCheck
        Other estimates beside.
    """

    driven: Driven
    fit: LineFit
    checks: tuple[CrossCheck, ...]

    @property
    def unit(self) -> str:
        """Of the amplitude."""
        return self.driven.unit or FILE_UNIT

    def rows(self) -> tuple[Row, ...]:
        """Return amplitude, quadrature or phase, density of the noise, and the other estimates."""
        known = self.fit.design.drive.phase_known
        return (*(self._of_known_phase() if known else self._of_free_phase()), self._noise(), *self._checked())

    def _of_known_phase(self) -> Iterator[Row]:
        value, u = (float(one[0]) / self.driven.response for one in (self.fit.in_phase, self.fit.u_in_phase))
        yield self._row("amplitude", value, u, abs(value) < FLOOR * u)
        if self.fit.quadrature is not None and self.fit.u_quadrature is not None:
            across, own = (float(one[0]) / self.driven.response for one in (self.fit.quadrature, self.fit.u_quadrature))
            yield self._row("quadrature", across, own, limited=False)
        if self.driven.applied is not None and self.driven.unit:
            yield self._scale_factor(value, u)

    def _row(self, quantity: str, value: float, u: float, limited: bool) -> Row:
        dof = self.fit.dof
        if not limited:
            return Row(Key(quantity, self._axis), value, u, self.unit, dof, t_interval(value, u, dof))
        limit = upper_bound(abs(value), u, dof)
        reason = f"in phase {with_uncertainty(value, u)}: below {FLOOR:g} times the noise of an amplitude"
        said = Reason("not_found", reason)
        return Row(Key(quantity, self._axis), limit, None, self.unit, dof, Interval(0.0, limit), "upper_limit", said)

    def _scale_factor(self, value: float, u: float) -> Row:
        applied, key = float(self.driven.applied or np.nan), Key("scale_factor", self._axis)
        unit = f"{self.driven.unit}/(m/s^2)"
        found, own = value / applied, u / abs(applied)
        of_applied = abs(found) * (self.driven.u_applied or 0.0)
        total = math.hypot(own, of_applied)
        dof = self.fit.dof * (total / own) ** 4
        if abs(value) < FLOOR * u:
            limit = upper_bound(abs(found), total, dof)
            why = "the amplitude is one"
            said = Reason("not_found", why)
            return Row(key, limit, None, unit, dof, Interval(0.0, limit), "upper_limit", said)
        return Row(key, found, total, unit, dof, t_interval(found, total, dof))

    def _of_free_phase(self) -> Iterator[Row]:
        fit, part = self.fit, self.driven.response
        assert fit.quadrature is not None  # noqa: S101 - a free phase has both
        assert fit.u_quadrature is not None  # noqa: S101
        a, b = float(fit.in_phase[0]), float(fit.quadrature[0])
        u = float(np.hypot(fit.u_in_phase[0], fit.u_quadrature[0]) / np.sqrt(2.0))
        found = amplitude_of(a, b, u, fit.dof)
        value, own, key = float(found.value[0]) / part, u / part, Key("amplitude", self._axis)
        if float(found.chance[0]) > 0.05 or math.hypot(a, b) < FLOOR * u:
            limit, length = float(found.limit[0]) / part, math.hypot(a, b) / part
            reason = f"length {number(length, 3)}, noise of a component {number(own, 3)}: below {FLOOR:g} times it"
            said = Reason("not_found", reason)
            yield Row(key, limit, None, self.unit, fit.dof, Interval(0.0, limit), "upper_limit", said)
            return
        interval = Interval(float(found.lo[0]) / part, float(found.hi[0]) / part)
        yield Row(key, value, own, self.unit, fit.dof, interval)
        angle, u_angle = math.degrees(math.atan2(b, a)), math.degrees(own / value)
        yield Row(Key("phase", self._axis), angle, u_angle, "deg", fit.dof, t_interval(angle, u_angle, fit.dof))

    def _noise(self) -> Row:
        value = float(np.sqrt(self.fit.density[0]))
        u, interval = value / math.sqrt(2.0 * self.fit.dof), chi_square_interval(value, self.fit.dof)
        return Row(Key("noise_density", self._axis), value, u, f"{self.unit}/sqrt(Hz)", self.fit.dof, interval)

    def _checked(self) -> Iterator[Row]:
        part = self.driven.response
        for one in self.checks:
            if one.value is not None and one.u is not None and self.fit.design.drive.phase_known:
                key = Key("amplitude", self._axis)
                yield Row(key, one.value / part, one.u / part, self.unit, method=METHODS[one.name])

    @property
    def _axis(self) -> str:
        return self.driven.channel.axis or bare_name(self.driven.channel.name)

    def remarks(self) -> tuple[Remark, ...]:
        """Return what there is to say of the fit."""
        found = list(self.driven.remarks)
        if self.fit.dof < FEW_DOF:
            what = f"{self.fit.dof:g} degrees of freedom tell the noise: there is room for few side bands"
            found.append(Remark("few_side_bands", "warning", what, do="Record more cycles"))
        found += [self._strange()] if self._has_strange_phase() else []
        found += [one.remark() for one in self.checks if one.disagrees]
        if self.driven.applied is not None and self.driven.u_applied is None:
            what = "nobody said how well the applied amplitude is known: the scale factor has scatter only"
            found.append(
                Remark("applied_not_stated", "warning", what, do="Write '# u of applied: 0.9 %' in the schedule")
            )
        return tuple(found)

    def _has_strange_phase(self) -> bool:
        fit = self.fit
        if not fit.design.drive.phase_known or fit.quadrature is None or fit.u_quadrature is None:
            return False
        return bool(abs(fit.quadrature[0]) > coverage_factor(fit.dof, STRANGE) * fit.u_quadrature[0])

    def _strange(self) -> Remark:
        assert self.fit.quadrature is not None  # noqa: S101 - asked before
        turn = math.degrees(math.atan2(float(self.fit.quadrature[0]), float(self.fit.in_phase[0])))
        what = f"the line is {number(turn, 3)} deg ahead of the drive: a part of it is not in phase"
        do = "Check phase and schedule against the clock of the record; a response that lags does the same"
        return Remark("phase", "warning", what, do=do)

    def curves(self) -> list[Curve]:
        """Return the series with drift and line, and the lines around the drive; long series thinned."""
        line, drift = self.fit.fitted()
        return [self._series(line, drift), self._lines(self.driven.readings - drift)]

    def _series(self, line: Array, drift: Array) -> Curve:
        x, times, unit = self.driven.readings, self.fit.design.drive.times, self.unit
        rest = x - drift
        kept = _extremes(rest, MOST)
        columns = {"time": Column((times - times[0])[kept], "s")}
        parts = {"reading": x, "drift": drift, "without_drift": rest, "line": line}
        columns |= {name: Column(values[kept], unit) for name, values in parts.items()}
        return Curve("sine_series", self._axis, columns)

    def _lines(self, rest: Array) -> Curve:
        drive, sides = self.fit.design.drive, self.fit.design.side_bands
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

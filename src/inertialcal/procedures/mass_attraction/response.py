"""Response of one run: the line of the drive in its readings, by ``signals.sine``, corrected for the tilt of the pad.

The drive is what the schedule applies, about its middle and over its amplitude: the line is in the unit of the
readings.

Jumps, kinks of the drift and single false readings are subtracted first (``changes``), and the tilt of the pad as
``tilt`` has it.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from ...core.errors import DataError
from ...core.estimate import Array
from ...signals.sine.fit import LineFit, common_noise
from .changes import Changes, changes_of
from .line import Fitted, fit_line, fit_series, fitted_line, start_phase
from .plan import Plan
from .readings import Line, Run
from .tilt import G, pad_tilt, tilt_used, without_tilt

RAYLEIGH = float(np.sqrt(np.pi / 2.0))  # mean amplitude of noise over the standard deviation of its part in phase


@dataclass(frozen=True, eq=False)
class Response:
    """Response of one run."""

    name: str  # Of the run
    moved: bool  # False for a null run
    applied: float  # Amplitude of the drive, of a null run that of a moved mass [m/s^2]
    amplitude: float  # In phase with the drive [output unit]
    u: float  # Its standard uncertainty from the noise of the runs [output unit]
    dof: float  # Degrees of freedom of ``u``
    quadrature: float = np.nan  # A quarter of a cycle ahead [output unit]; NaN if not known
    u_quadrature: float = np.nan  # Its standard uncertainty [output unit]; NaN if not known
    # Of the pad in phase with the drive, mercury subtracted [rad]; NaN without a meter
    tilt: float = np.nan
    u_tilt: float = np.nan  # Its standard uncertainty [rad]
    coefficient: float = np.nan  # Of the tilt in the readings [output unit/rad]; NaN if nothing was subtracted
    half_range: float = 0.0  # Of the coefficient, by noise of the meter [output unit/rad]
    tilt_used: str = "ignored"  # As the plan says, or ``ignored`` without a tilt
    fitted: Fitted | None = None  # Line and drift; None for a run that was reduced before
    # shape (n,): readings that were fitted, tilt subtracted [output unit]
    series: Array = field(default_factory=lambda: np.empty(0))
    # Of the drive at the first dwell of the run [rad]: what repeats with the runs leaks with its cosine and sine
    phase: float = 0.0
    changes: Changes | None = None  # Faults within the run; None for a run that was reduced before

    @property
    def scale_factor(self) -> float:
        """Amplitude over what is applied [output unit/(m/s^2)]."""
        return self.amplitude / self.applied

    @property
    def u_scale_factor(self) -> float:
        """Standard uncertainty of it from the noise of the run [output unit/(m/s^2)]."""
        return self.u / self.applied

    def significant(self, floor: float) -> bool:
        """Return whether the response is at least so many standard uncertainties from zero."""
        return abs(self.amplitude) >= floor * self.u


def response_of(plan: Plan, run: Run) -> Response:
    """Return the response of a run, with its own noise; errors as `responses_of`."""
    return responses_of(plan, [run])[0]


def responses_of(plan: Plan, runs: Sequence[Run]) -> list[Response]:
    """Return the responses of runs, with the noise of all of them where it may be the same.

    Raises
    ------
    DataError
        ``schedule_slip``, if the mass came a dwell late or early from some dwell on; as `line.line_design`.
    """
    prepared = [_prepared(plan, run) for run in runs]
    _check_schedules(runs, [one.changes for one in prepared])
    fits = common_noise([one.found for one in prepared])
    return [_response(run, one, found) for run, one, found in zip(runs, prepared, fits, strict=True)]


class _Prepared(NamedTuple):
    """Readings of a run less its tilt, their fit, and the line of the tilt."""

    series: Array
    found: LineFit
    mode: str
    coefficient: float
    u_coefficient: float
    half_range: float
    meter: Fitted | None
    changes: Changes


def _prepared(plan: Plan, run: Run) -> _Prepared:
    mode = tilt_used(plan, run)
    tilt = None if run.tilt is None or mode == "ignored" else pad_tilt(plan, run)
    try:
        x, p, u_p, half = without_tilt(plan, run, tilt, mode)
        changes = changes_of(run.schedule, x, run.moved)
        x = changes.repaired(x) if changes.repairable else x
        found = fit_series(run.schedule, x)
        meter = None if tilt is None else fit_line(run.schedule, np.where(np.isfinite(x), tilt, np.nan))
    except DataError as error:
        raise DataError([replace(one, where=one.where or run.where or run.name) for one in error.problems]) from None
    return _Prepared(x, found, mode, p, u_p, half, meter, changes)


def _response(run: Run, prepared: _Prepared, fit: LineFit) -> Response:
    x, _, mode, p, u_p, half, meter, changes = prepared
    found = fitted_line(fit, np.isfinite(x))
    tau, u_tau = (np.nan, np.nan) if meter is None else (meter.amplitude, meter.u)
    applied, amplitude, u = run.schedule.amplitude, found.amplitude, found.u
    if changes.repairable:
        u *= float(np.sqrt(changes.inflation))
    if mode == "known" and run.moved:
        share = applied / (applied + G * tau)
        amplitude, u = (amplitude + p * tau) * share, u * abs(share)
    if mode == "regressed":
        u = float(np.hypot(u, u_p * tau))
    return Response(run.name, run.moved, applied, amplitude, u, found.dof, found.quadrature, found.u_quadrature, tau,
                    u_tau, p, half, mode, found, x, start_phase(run.schedule), changes)  # fmt: skip


def _check_schedules(runs: Sequence[Run], changes: Sequence[Changes]) -> None:
    """Refuse a slip; where several runs show it, as they share what repeats, the one that shows it most."""
    slips = [(one.score, k, one) for k, each in enumerate(changes) for one in each.found if one.kind == "slip"]
    if not slips:
        return
    score, k, one = max(slips, key=lambda each: each[0])
    part = "the whole run fits" if one.at == 0 else f"from dwell {one.at + 1} on the readings fit"
    size = "half a dwell" if abs(one.size) < 1.0 else ("one dwell" if abs(one.size) == 1.0 else "two dwells")
    side = "late" if one.size > 0.0 else "early"
    what = f"{runs[k].name}: {part} a mass that comes {size} {side}"
    why = f"twice the log likelihood gains {score:.0f}; the phase would be wrong"
    do = "Find the lost dwell or move, and correct the schedule or its begin"
    raise DataError(what, runs[k].where, why, do, "schedule_slip")


def tilt_left(responses: Iterable[Response]) -> float:
    """Return the uncertainty of the scale factor from the noise of the meter of a regressed tilt [output unit/(m/s^2)].

    Of a range whose ends are likelier than its middle (arc sine): a meter along the input axis is at one of them.
    """
    each = [one.half_range * one.tilt / one.applied for one in responses if one.moved and one.half_range]
    return abs(float(np.sum(each))) / float(np.sqrt(2.0)) / max(sum(one.moved for one in responses), 1)


def response_of_line(line: Line) -> Response:
    """Return the response of a run that was reduced before.

    The mean amplitude of n lines of noise is ``sqrt(pi/2)`` times the standard deviation of the part in phase.
    """
    return Response(line.name, line.moved, line.applied, line.response, line.noise / RAYLEIGH, 2.0 * line.beside)

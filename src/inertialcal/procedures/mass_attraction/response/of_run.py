"""Response of one run: the line of the drive in its readings, with the tilt of the pad taken off.

The pad tilts with the mass that is moved on it, and an accelerometer feels a tilt ``theta`` as ``g theta``. The meter
reads that and its own mercury, which the mass attracts, in phase: what is computed of that is taken off first. Then,
with what is left of the meter, Y:

- ``known``: ``S0 g Y`` is taken off the readings, S0 being the nominal scale factor. What S differs from S0 by is put
  right by the tilt in phase with the drive, so that ``S = (A + S0 g tau) / (a + g tau)``.
- ``regressed``: Y is regressed beside drive and drift: its coefficient p is that of what both leave of the readings and
  of the meter, the response is what the readings less ``p Y`` show, and the doubt of p counts by the tilt in phase.
  Noise of the meter draws p towards zero, and leaves ``(S g - |p|) tau`` of a tilt tau in phase in the response, as
  far as the meter stands along the input axis (`tilt_left`). It is told, and counted as an uncertainty.
- ``ignored``: the response is to ``a + g tau`` with an unknown tau.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, replace

import numpy as np

from ....core.constants import STANDARD_GRAVITY
from ....core.errors import DataError, PlanError
from ....core.estimate import Array
from ....signals.sine.fit import LineFit
from ..plan import Plan
from ..readings import Line, Run
from .line import Fitted, fit_line, fit_lines, fits_better_late

G = STANDARD_GRAVITY.value
SLIP = 25.0  # gain of squared signal over noise by which a slip of the schedule is told
HALF = 0.5  # of the dwells of a run that must have a tilt
RAYLEIGH = float(np.sqrt(np.pi / 2.0))  # mean amplitude of noise over the standard deviation of one of its parts


@dataclass(frozen=True, eq=False)
class Response:
    """What one run responds.

    Parameters
    ----------
    name : str
        Of the run.
    moved : bool
        Whether the mass was moved.
    applied : float
        Amplitude that was applied, or would have been [m/s^2].
    amplitude, u : float
        In phase with it, and its standard uncertainty from the lines beside [count/s].
    dof : float
        Degrees of freedom of ``u``.
    quadrature, u_quadrature : float
        A quarter of a cycle ahead, and its standard uncertainty [count/s]; NaN where it is not known.
    tilt, u_tilt : float
        Of the pad in phase with the drive, mercury taken off, and its standard uncertainty [rad]; NaN without a meter.
    coefficient : float
        Of the tilt in the readings [count/s/rad]; NaN where it was not taken off.
    tilt_used : str
        What became of the tilt: as the plan says, or ``ignored`` where there is none.
    fitted : Fitted or None
        Line and drift; None of a run that was reduced before.
    series : ndarray, shape (n,)
        Readings that they were fitted to, the tilt taken off [count/s].
    """

    name: str
    moved: bool
    applied: float
    amplitude: float
    u: float
    dof: float
    quadrature: float = np.nan
    u_quadrature: float = np.nan
    tilt: float = np.nan
    u_tilt: float = np.nan
    coefficient: float = np.nan
    tilt_used: str = "ignored"
    fitted: Fitted | None = None
    series: Array = field(default_factory=lambda: np.empty(0))

    @property
    def scale_factor(self) -> float:
        """What the amplitude is to what is applied [count/s/(m/s^2)]."""
        return self.amplitude / self.applied

    @property
    def u_scale_factor(self) -> float:
        """Standard uncertainty of it from the noise of the run [count/s/(m/s^2)]."""
        return self.u / self.applied

    def found(self, floor: float) -> bool:
        """Return whether the response is told from noise: at least so many standard uncertainties from zero."""
        return abs(self.amplitude) >= floor * self.u


def response_of(plan: Plan, run: Run) -> Response:
    """Return the response of a run.

    Raises
    ------
    DataError
        ``schedule_slip``, if the mass came a dwell late or early from some dwell on; as `fit_line`.
    """
    mode = tilt_used(plan, run)
    tilt = None if run.tilt is None or mode == "ignored" else _pad_tilt(plan, run)
    try:
        x, p, u_p = _without_tilt(plan, run, tilt, mode)
        found = fit_line(run.schedule, x, plan.side_bands)
        meter = None if tilt is None else fit_line(run.schedule, np.where(np.isfinite(x), tilt, np.nan))
    except DataError as error:
        raise DataError([replace(one, where=one.where or run.where or run.name) for one in error.problems]) from None
    if run.moved:
        _check_slip(run, x)
    tau, u_tau = (np.nan, np.nan) if meter is None else (meter.amplitude, meter.u)
    applied, amplitude, u = run.schedule.amplitude, found.amplitude, found.u
    if mode == "known" and run.moved:
        share = applied / (applied + G * tau)
        amplitude, u = (amplitude + p * tau) * share, u * abs(share)
    if mode == "regressed":
        u = float(np.hypot(u, u_p * tau))
    return Response(run.name, run.moved, applied, amplitude, u, found.dof, found.quadrature, found.u_quadrature, tau,
                    u_tau, p, mode, found, x)  # fmt: skip


def _without_tilt(plan: Plan, run: Run, tilt: Array | None, mode: str) -> tuple[Array, float, float]:
    """Return the readings less the share of the tilt, its coefficient and the doubt of it [count/s/rad]."""
    if tilt is None:
        return run.reading, np.nan, 0.0
    if mode == "known":
        p = (plan.nominal or 0.0) * G
        return run.reading - p * tilt, p, 0.0
    both = np.column_stack([run.reading, tilt / np.nanstd(tilt)])
    found, there = fit_lines(run.schedule, both, plan.side_bands)
    x, y = (both[there] - _explained(found)).T
    p = float(x @ y / (y @ y))
    left = float(np.sum((x - p * y) ** 2)) / max(len(x) - found.design.main - 1, 1)
    scale = float(np.nanstd(tilt))
    return run.reading - p / scale * tilt, p / scale, float(np.sqrt(left / (y @ y))) / scale


def _explained(found: LineFit) -> Array:
    """Return line and drift of all series of a fit, shape (n, k)."""
    line = [found.in_phase] if found.quadrature is None else [found.in_phase, found.quadrature]
    coefficients = np.vstack([*line, found.drift])
    columns = np.concatenate([part for _, part in found.design.parts(found.design.main)], axis=1)
    return np.asarray(columns.T @ coefficients)


def tilt_left(responses: Iterable[Response], scale: float) -> float:
    """Return what a regressed tilt in phase has left in the scale factor, mean over the runs [count/s/(m/s^2)].

    An accelerometer feels gravity times the tilt. A coefficient of less than that was drawn towards zero by the noise
    of the meter (or the meter does not stand along the input axis), and what it lacks stays in the response, with the
    sign of the coefficient.

    Parameters
    ----------
    responses : iterable of Response
        Of all runs.
    scale : float
        Scale factor [count/s/(m/s^2)].
    """
    moved = [one for one in responses if one.moved]
    left = [
        np.sign(one.coefficient) * max(abs(scale) * G - abs(one.coefficient), 0.0) * one.tilt / one.applied
        if one.tilt_used == "regressed" else 0.0 for one in moved
    ]  # fmt: skip
    return float(np.mean(left)) if left else 0.0


def response_of_line(line: Line) -> Response:
    """Return the response of a run that was reduced before.

    The mean amplitude of n lines of noise is ``sqrt(pi/2)`` times the standard deviation of the part in phase.
    """
    return Response(
        line.name, line.moved, line.applied, line.response, line.noise / RAYLEIGH, 2.0 * line.beside
    )  # fmt: skip


def tilt_used(plan: Plan, run: Run) -> str:
    """Return what becomes of the tilt of a run: nothing where half of its dwells or more have none."""
    if plan.tilt == "ignored" or run.tilt is None:
        return "ignored"
    wanted = np.isfinite(run.reading)
    have = np.isfinite(run.tilt) & wanted
    if have.sum() <= HALF * wanted.sum() or not np.ptp(run.tilt[have]) > 0.0:
        return "ignored"
    return "ignored" if plan.tilt == "known" and not plan.nominal else plan.tilt


def _pad_tilt(plan: Plan, run: Run) -> Array:
    """Return the tilt of the pad about its mean, as it is felt, what the mass does to the mercury taken off [rad]."""
    assert run.tilt is not None  # noqa: S101 - asked before
    tilt = run.tilt - (_of_mercury(plan, run) if run.moved else 0.0)
    with np.errstate(invalid="ignore"):
        middle = np.nanmean(tilt) if np.isfinite(tilt).any() else 0.0
    return np.asarray(plan.tilt_sign * (tilt - middle))


def _of_mercury(plan: Plan, run: Run) -> Array:
    """Return the tilt of the meter's mercury in each dwell, by the schedule, or by the amplitude of the plan [rad].

    Raises
    ------
    PlanError
        If both say it.
    """
    schedule = run.schedule
    if schedule.mercury is None:
        found: Array = plan.mercury * (schedule.applied - schedule.applied.mean()) / schedule.amplitude
        return found
    if plan.mercury:
        raise PlanError(
            f"{run.name}: the tilt of the mercury is stated twice: mercury of the plan, and a column of the schedule",
            why="it would be taken off once only, and nobody says which",
            do="Leave out one of them",
            code="contradiction",
        )
    return schedule.mercury


def _check_slip(run: Run, x: Array) -> None:
    """Refuse a run whose mass does not keep to its schedule."""
    gain, dwell = fits_better_late(run.schedule, x)
    if gain > SLIP:
        whole = "the whole run fits" if dwell == 0 else f"from dwell {dwell + 1} on the readings fit"
        what = f"{run.name}: {whole} a mass that comes one dwell off its schedule"
        why = f"the squared signal over noise gains {gain:.0f}; the phase would be wrong"
        do = "Find the dwell or the move that was lost, and mend the schedule or its begin"
        raise DataError(what, run.where, why, do, "schedule_slip")

"""Response of one run: the line of the drive in its readings, by ``signals.sine``, corrected for the tilt of the pad.

The drive is what the schedule applies, about its middle and over its amplitude: the line is in the unit of the
readings.

The pad tilts with the mass that moves on it, and an accelerometer feels a tilt ``theta`` as ``g theta``. The meter
reads that tilt and, in phase, the tilt of its own mercury, which the mass attracts; the computed tilt of the mercury is
subtracted first. Then, with the remaining tilt Y:

- ``known``: ``S0 g Y`` is subtracted from the readings; S0 is the nominal scale factor. The tilt tau in phase with the
  drive corrects for the difference of S from S0: ``S = (A + S0 g tau) / (a + g tau)``.
- ``regressed``: Y is regressed together with drive and drift. Its coefficient p follows from the residuals of both; the
  response is that of the readings less ``p Y``, and the uncertainty of p counts by the tilt in phase. Noise of the
  meter draws p towards zero, which leaves ``(S g - |p|) tau`` in the response if the meter stands along the input axis
  (`tilt_left`): it is remarked, and counts as an uncertainty.
- ``ignored``: the response is to ``a + g tau`` with an unknown tau.

Runs are weighted by ``1 / (u^2 + t^2)``: u of each from the lines next to its own, t^2 the variance between runs that
explains their differences [1]_. The weights only affect the efficiency. The uncertainty is that of the weighted scatter
of the runs about their mean, with one degree of freedom fewer than runs [2]_: it holds whatever makes the runs differ.
The noise within the runs alone gives another one, right if nothing differs from run to run.

Type A is that scatter (or noise), with its degrees of freedom. Type B is the uncertainty of the acceleration applied,
of the mercury of the tilt meter, of a tilt that was not subtracted, and the remainder of a regressed tilt: the same in
all runs, so more runs do not reduce it.

References
----------
.. [1] R. C. Paule and J. Mandel, J. Res. NBS 87 (1982) 377.
.. [2] J. Hartung and G. Knapp, Statistics in Medicine 20 (2001) 1771.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from scipy import optimize, special

from ...core.errors import DataError
from ...core.estimate import Array, Component, Estimate
from ...core.influence import Influence
from ...core.key import Key, Origin
from ...statistics.means import Mean, weighted_mean
from .line import Fitted, fit_line, start_phase
from .plan import APPLIED, Plan
from .readings import Line, Readings, Run
from .slip import SLIP, fits_better_late
from .tilt import G, pad_tilt, tilt_used, without_tilt

RAYLEIGH = float(np.sqrt(np.pi / 2.0))  # mean amplitude of noise over the standard deviation of its part in phase


@dataclass(frozen=True, eq=False)
class Response:
    """Response of one run."""

    name: str  # Of the run
    moved: bool  # False for a null run
    applied: float  # Amplitude of the drive, of a null run that of a moved mass [m/s^2]
    amplitude: float  # In phase with the drive [count/s]
    u: float  # Its standard uncertainty from the lines next to it [count/s]
    dof: float  # Degrees of freedom of ``u``
    quadrature: float = np.nan  # A quarter of a cycle ahead [count/s]; NaN if not known
    u_quadrature: float = np.nan  # Its standard uncertainty [count/s]; NaN if not known
    # Of the pad in phase with the drive, mercury subtracted [rad]; NaN without a meter
    tilt: float = np.nan
    u_tilt: float = np.nan  # Its standard uncertainty [rad]
    coefficient: float = np.nan  # Of the tilt in the readings [count/s/rad]; NaN if nothing was subtracted
    tilt_used: str = "ignored"  # As the plan says, or ``ignored`` without a tilt
    fitted: Fitted | None = None  # Line and drift; None for a run that was reduced before
    # shape (n,): readings that were fitted, tilt subtracted [count/s]
    series: Array = field(default_factory=lambda: np.empty(0))
    # Of the drive at the first dwell of the run [rad]: what repeats with the runs leaks with its cosine and sine
    phase: float = 0.0

    @property
    def scale_factor(self) -> float:
        """Amplitude over what is applied [count/s/(m/s^2)]."""
        return self.amplitude / self.applied

    @property
    def u_scale_factor(self) -> float:
        """Standard uncertainty of it from the noise of the run [count/s/(m/s^2)]."""
        return self.u / self.applied

    def significant(self, floor: float) -> bool:
        """Return whether the response is at least so many standard uncertainties from zero."""
        return abs(self.amplitude) >= floor * self.u


def response_of(plan: Plan, run: Run) -> Response:
    """Return the response of a run.

    Raises
    ------
    DataError
        ``schedule_slip``, if the mass came a dwell late or early from some dwell on; as `line.fit_line`.
    """
    mode = tilt_used(plan, run)
    tilt = None if run.tilt is None or mode == "ignored" else pad_tilt(plan, run)
    try:
        x, p, u_p = without_tilt(plan, run, tilt, mode)
        found = fit_line(run.schedule, x, plan.side_bands)
        meter = None if tilt is None else fit_line(run.schedule, np.where(np.isfinite(x), tilt, np.nan))
    except DataError as error:
        raise DataError([replace(one, where=one.where or run.where or run.name) for one in error.problems]) from None
    if run.moved:
        gain, dwell = fits_better_late(run.schedule, x)
        if gain > SLIP:
            part = "the whole run fits" if dwell == 0 else f"from dwell {dwell + 1} on the readings fit"
            what = f"{run.name}: {part} a mass that comes one dwell off its schedule"
            why = f"the squared signal over noise gains {gain:.0f}; the phase would be wrong"
            do = "Find the lost dwell or move, and correct the schedule or its begin"
            raise DataError(what, run.where, why, do, "schedule_slip")
    tau, u_tau = (np.nan, np.nan) if meter is None else (meter.amplitude, meter.u)
    applied, amplitude, u = run.schedule.amplitude, found.amplitude, found.u
    if mode == "known" and run.moved:
        share = applied / (applied + G * tau)
        amplitude, u = (amplitude + p * tau) * share, u * abs(share)
    if mode == "regressed":
        u = float(np.hypot(u, u_p * tau))
    return Response(run.name, run.moved, applied, amplitude, u, found.dof, found.quadrature, found.u_quadrature, tau,
                    u_tau, p, mode, found, x, start_phase(run.schedule))  # fmt: skip


def tilt_left(responses: Iterable[Response], scale: float) -> float:
    """Return what a regressed tilt leaves in the scale factor, mean over the runs [count/s/(m/s^2)].

    An accelerometer feels gravity times the tilt. Noise of the meter draws the coefficient towards zero (or the meter
    does not stand along the input axis); the difference stays in the response, with the sign of the coefficient.

    Parameters
    ----------
    responses : iterable of Response
        Of all runs.
    scale : float
        Scale factor [count/s/(m/s^2)].
    """
    each = [
        np.sign(one.coefficient) * max(abs(scale) * G - abs(one.coefficient), 0.0) * one.tilt / one.applied
        if one.tilt_used == "regressed" else 0.0 for one in responses if one.moved
    ]  # fmt: skip
    return float(np.mean(each)) if each else 0.0


def response_of_line(line: Line) -> Response:
    """Return the response of a run that was reduced before.

    The mean amplitude of n lines of noise is ``sqrt(pi/2)`` times the standard deviation of the part in phase.
    """
    return Response(line.name, line.moved, line.applied, line.response, line.noise / RAYLEIGH, 2.0 * line.beside)


SCALE, ERROR, DIFFERENCE = "scale_factor", "scale_factor_error", "high_g_difference"
UNIT = "count/s/(m/s^2)"


SOURCES = {"between_runs": "scatter between runs", "within_runs": "noise next to the line of each run"}


NAMES = {
    "source_mass.density": "density of the mass", "source_mass.placing": "places of the mass",
    "source_mass.gravitational_constant": "gravitational constant",
}  # fmt: skip


def estimate_of(
    plan: Plan, readings: Readings, responses: Sequence[Response], both: Combined, scatter: str
) -> Estimate:  # fmt: skip
    """Return the scale factor and the figures it is compared with, SI; `scatter` says which type A counts."""
    found = both.between if scatter == "between_runs" and both.between is not None else both.within
    names, values, slopes, units = [SCALE], [found.value], [1.0], [UNIT]
    if plan.nominal:
        names, values = [*names, ERROR], [*values, found.value / plan.nominal - 1.0]
        slopes, units = [*slopes, 1.0 / plan.nominal], [*units, "1"]
    if plan.high_g is not None:
        names, values = [*names, DIFFERENCE], [*values, found.value / plan.high_g.scale_factor - 1.0]
        slopes, units = [*slopes, 1.0 / plan.high_g.scale_factor], [*units, "1"]
    way = np.array(slopes)
    type_a = Component(Origin(SOURCES[scatter], level=scatter), "A", _outer(way * found.u), found.dof, "t")
    parts = [type_a, *_type_b(plan, readings, responses, found.value, way)]
    if plan.high_g is not None and plan.high_g.u > 0.0:
        own = np.zeros(len(way))
        own[-1] = plan.high_g.u * found.value / plan.high_g.scale_factor**2
        parts.append(Component("high-g scale factor", "B", _outer(own), stated=(plan.high_g.u, UNIT)))
    return Estimate(tuple(Key(name, plan.axis) for name in names), np.array(values), tuple(units), tuple(parts))


def applied_influences(plan: Plan, readings: Readings) -> dict[str, Influence]:
    """Return the relative influences on the amplitude applied by name: of the standards, else of the schedules."""
    stated = {NAMES[name]: plan.standards[name] for name in APPLIED if name in plan.standards}
    if stated:
        return stated
    each = [run.schedule.u_applied for run in readings.series if run.moved]
    each += [line.u_applied or None for line in readings.lines if line.moved]
    known = [u for u in each if u is not None]
    return {"acceleration applied": Influence(float(np.mean(known)))} if known and len(known) == len(each) else {}


def _type_b(
    plan: Plan, readings: Readings, responses: Sequence[Response], scale: float, way: Array
) -> Iterator[Component]:
    for name, one in applied_influences(plan, readings).items():
        u = way * scale * one.u
        yield Component(one.origin(name), "B", _outer(u), one.dof, one.distribution, one.stated, -u[None])
    moved = [one for one in responses if one.moved]
    subtracted = [0.0 if one.tilt_used == "ignored" else abs(one.coefficient) / one.applied for one in moved]
    kept = [scale * G / one.applied if one.tilt_used == "ignored" else 0.0 for one in moved]
    for name, slopes, label in (
        ("tilt_meter.mercury", subtracted, "mercury of the tilt meter"),
        ("pad.tilt", kept, "tilt of the pad, not taken off"),
    ):
        stated, slope = plan.standards.get(name), float(np.mean(slopes))
        if stated is not None and slope:
            u = way * slope * stated.u
            origin = stated.origin(label)
            yield Component(origin, "B", _outer(u), stated.dof, stated.distribution, stated.stated, u[None])
    remainder = tilt_left(responses, scale)
    if remainder:  # all of it as one standard uncertainty
        yield Component("tilt left by the noise of its meter", "B", _outer(way * remainder))


def compared_with(plan: Plan, estimate: Estimate | None) -> dict[str, str]:
    """Return what figures of the estimate are compared with, and the normalised difference, by quantity."""
    if estimate is None:
        return {}
    found = {}
    if plan.nominal:
        found[ERROR] = f"relative to {plan.nominal:.5g} {UNIT}, the scale factor of the chain"
    if plan.high_g is not None:
        i = len(estimate.names) - 1
        normalised = float(estimate.values[i]) / float(estimate.u[i])
        found[DIFFERENCE] = (
            f"relative to {plan.high_g.scale_factor:.5g} {UNIT} at high g; normalised difference {normalised:+.2f}"
        )
    return found


def _outer(u: Array) -> Array:
    return np.outer(u, u)


@dataclass(frozen=True)
class Combined:
    """Mean of runs."""

    within: Mean  # Weighted by the noise of each run, with the uncertainty from that noise alone
    between: Mean | None  # With the uncertainty from the scatter of the runs; None for a single run
    p_value: float  # Probability of at least this scatter from noise alone; NaN for a single run


def combined(values: Array, u: Array, dof: Array) -> Combined:
    """Return the mean of m runs, in one unit."""
    within = weighted_mean(values, u, dof)
    m = len(values)
    if m < 2:
        return Combined(within, None, np.nan)
    chi_square = float(np.sum(((values - within.value) / u) ** 2))
    w = 1.0 / (u**2 + between_variance(values, u))
    mean = float(w @ values / w.sum())
    variance = float(w @ (values - mean) ** 2 / ((m - 1.0) * w.sum()))
    p = float(special.fdtrc(m - 1.0, float(np.sum(dof)), chi_square / (m - 1.0)))
    return Combined(within, Mean(mean, float(np.sqrt(variance)), m - 1.0), p)


def between_variance(values: Array, u: Array) -> float:
    """Return the variance between runs that explains their scatter; 0 if noise explains all of it."""

    def excess(t_2: float) -> float:
        w = 1.0 / (u**2 + t_2)
        mean = w @ values / w.sum()
        return float(w @ (values - mean) ** 2) - (len(values) - 1.0)

    if excess(0.0) <= 0.0:
        return 0.0
    most = float(len(values) * np.ptp(values) ** 2)
    return float(optimize.brentq(excess, 0.0, most, rtol=1e-6))

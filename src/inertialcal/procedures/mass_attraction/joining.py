"""Scale factor from several runs of a moved mass: their mean, what repeats in each of them taken out, and its u.

A run r responds by ``A_r``; over the amplitude applied this is its scale factor. What comes at the same time after the
start of every run, a warming up or a thermostat, responds alike in each of them as long as the drive starts alike, and
no scatter shows it. If runs start at different phases of the drive, as their schedules say, it does not follow the
mass, and is fitted next to it [1]_::

    A_r = A + cos(p_r) L + sin(p_r) M            p_r: by how much the drive of run r is ahead of that of the first

With two phases that differ by d, ``A_r -+ cot(d / 2) B_r`` replaces ``A_r``, B the quadrature: ``A`` and one common
part with opposite signs are left. Half a cycle needs no quadrature; a quarter raises u by ``sqrt(2)``. Phases that
would raise the variance more than `COSTLY` times count as equal.

*Weights* are ``1 / (u_r^2 + t^2)``, u_r from the noise of each run. ``t^2`` is the variance between runs with which the
weighted squares of the residuals reach their lower quartile, rather than their mean [2]_: a variance from few runs is
poorly known, and one that is too small gives one run all the weight.

*Uncertainty.* The residuals between the runs, weighted so, have as many degrees of freedom as there are runs more than
parameters [3]_: they include all that differs from run to run, drift of another shape, gain, places of the mass. The
noise within the runs is known with more degrees of freedom, but includes only itself. The one with the **wider** 95 %
interval is the uncertainty: the interval then holds the truth in 95 % or more of campaigns whether runs scatter or not.

=================================  =====  =====  =====  =====  =====
95 % intervals that hold, %            2      3      4      6     10  runs
=================================  =====  =====  =====  =====  =====
noise alone                         99.2   98.6   98.0   97.1   96.4
scatter = noise of a run            98.0   96.7   96.2   95.5   94.7
scatter = 5 times noise of a run    95.1   95.0   95.1   94.9   95.0
half of the runs 3 times as noisy   99.2   98.7   98.3   97.9   97.1
the same, scatter 2.5 times         94.9   94.6   94.3   94.4   94.8
=================================  =====  =====  =====  =====  =====

(20,000 simulated campaigns each.) The rule that uses the noise wherever the variances of both are in a ratio below its
median held in 91 % of campaigns of two runs, and variances by their mean ratio [2]_ in 91 % if one run has a third of
the noise of the others.

*Assumed:* normal scatter, alike in all runs; what repeats keeps its size and its time after the start of the run.
Real runs break this in three ways, each simulated in the tests: a drift that grows or shrinks from run to run (it does
not cancel, and counts as scatter), runs of different length (the part that repeats differs: scatter), and a gain that
differs with the phase: with two phases it looks like a drift that repeats, and the mean of both gains is stated with
the remark ``repeating_drift``.

References
----------
.. [1] H. E. Swanson and S. Schlamminger, Meas. Sci. Technol. 21 (2010) 115104.
.. [2] R. C. Paule and J. Mandel, J. Res. NBS 87 (1982) 377.
.. [3] J. Hartung and G. Knapp, Statistics in Medicine 20 (2001) 1771.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy import optimize, special

from ...core.errors import DataError
from ...core.estimate import Array, Component, Estimate
from ...core.influence import Influence
from ...core.key import Key, Origin
from ...statistics.intervals import coverage_factor
from ...statistics.means import Mean
from .changes import changes_of
from .line import fit_line, shape_of, start_phase
from .plan import APPLIED, Plan
from .readings import Readings, Run
from .response import Response, response_of, tilt_left
from .tilt import G

ALIKE = np.radians(20.0)  # difference of phases that counts as none
COSTLY = 3.0  # variance with phases over that without
LOWER_QUARTILE = 0.25
EVEN = 1e-3  # relative difference of periods of one drive
EXACT = 1e-6  # smaller is rounding


@dataclass(frozen=True, eq=False)
class Joined:
    """Mean of m runs with the mass moved, in one unit."""

    within: Mean  # With the uncertainty from the noise within the runs
    between: Mean | None  # With the uncertainty from their scatter; None without a degree of freedom
    p_value: float  # Probability of at least this scatter from noise alone; NaN without a degree of freedom
    repeats: Array  # shape (m,): part of each run that comes at the same time of every run; 0 if all start alike
    u_repeats: float = 0.0  # Standard uncertainty of its largest
    phases: Array | None = (
        None  # shape (m,): of the drive, ahead of that of the first run [rad]; None if all start alike
    )

    @property
    def scatter(self) -> str:
        """Source of the uncertainty: ``between_runs`` or ``within_runs``, that with the wider interval."""
        if self.between is None:
            return "within_runs"
        wide = [coverage_factor(one.dof) * one.u for one in (self.within, self.between)]
        return "between_runs" if wide[1] >= wide[0] else "within_runs"

    def by(self, scatter: str) -> Mean:
        """Return the mean with the uncertainty from this source."""
        return self.between if scatter == "between_runs" and self.between is not None else self.within


def joined(responses: Sequence[Response]) -> Joined:
    """Return the mean scale factor of m runs with the mass moved [output unit/(m/s^2)]."""
    ahead = phases_ahead(responses)
    columns, share = _parts(ahead)
    if np.any(share) and not all(np.isfinite(one.u_quadrature) for one in responses):
        columns, share = columns[:, :1], np.zeros(len(responses))
    applied, values, u, dof = np.array([[one.applied, one.amplitude, one.u, one.dof] for one in responses]).T
    if np.any(share):
        values = values + share * np.array([one.quadrature for one in responses])
        u = np.hypot(u, share * np.array([one.u_quadrature for one in responses]))
    return join(values / applied, u / applied, dof, columns, ahead if columns.shape[1] > 1 else None)


def phases_ahead(responses: Sequence[Response]) -> Array:
    """Return by how much the drive of each run starts ahead of that of the first, shape (m,) [rad].

    Phases that differ by rounding are equal. All are 0 if a run was reduced before, or the periods differ.
    """
    known = [(one.phase, one.fitted.frequencies[0]) for one in responses if one.fitted is not None]
    return _ahead(*np.array(known).T) if len(known) == len(responses) else np.zeros(len(responses))


def _ahead(phases: Array, frequencies: Array) -> Array:
    if not np.ptp(frequencies) < EVEN * frequencies.min():
        return np.zeros(len(phases))
    ahead = np.exp(1j * (phases - phases[0]))
    for k in range(len(ahead)):
        same = np.abs(np.angle(ahead / ahead[k])) < ALIKE
        ahead[same] = ahead[np.argmax(same)]
    return np.asarray(np.angle(ahead))


@dataclass(frozen=True, eq=False)
class Quiet:
    """A run without what repeats in each dwell of all runs."""

    run: Run
    line: complex = (
        0.0  # At the drive, taken out of it: in phase, and in quadrature as the imaginary part [output unit]
    )
    m: int = 0  # Runs that what repeats is the mean of

    def response(self, plan: Plan) -> Response:
        """Return the response with its line put back, and the noise that it had before; errors as `response_of`."""
        return self.restored(response_of(plan, self.run))

    def restored(self, found: Response) -> Response:
        """Return the response of the quiet run with its line put back, and the noise that it had before."""
        if not self.m:
            return found
        u, u_quadrature = np.array([found.u, found.u_quadrature]) * np.sqrt(self.m / (self.m - 1.0))
        amplitude, quadrature = found.amplitude + self.line.real, found.quadrature + self.line.imag
        return replace(found, amplitude=amplitude, quadrature=quadrature, u=float(u), u_quadrature=float(u_quadrature),
                       dof=found.dof * (self.m - 1.0) / self.m)  # fmt: skip


def quiet_runs(runs: Sequence[Run]) -> list[Quiet]:
    """Return runs without what repeats in each dwell, where their drives start at different phases.

    A drift that repeats and is near the drive would count as noise, slip or jump of every run. The mean over the runs
    with the mass moved of what the line leaves of each dwell (in a gap, the drift) has no part in the line: amplitudes
    stay. The line itself follows from the phases; any error in it cancels as it does. Jumps, kinks and false readings
    of one run are kept out of the mean: else each of the others would get a part of them.
    """
    moved = [run for run in runs if run.moved]
    phases = np.array([start_phase(run.schedule) for run in moved])
    as_they_are = [Quiet(run) for run in runs]
    if len(moved) < 2 or not np.any(_ahead(phases, np.array([run.schedule.frequency for run in moved]))):
        return as_they_are
    try:
        sound = _repaired(moved)
        rest, lines = _rests(sound)
    except DataError:  # the response of this run says why
        return as_they_are
    repeats = np.nanmean(rest, axis=0)
    turned = np.exp(1j * phases)
    _, common = np.linalg.lstsq(np.column_stack([turned, np.ones(len(moved))]), np.array(lines) * turned, rcond=None)[0]
    quiet = []
    for run in runs:
        angle = 2.0 * np.pi * run.schedule.frequency * (run.schedule.middle - run.schedule.middle[0])
        wave = np.exp(1j * (angle + start_phase(run.schedule)))  # in phase with the drive: its imaginary part
        size = 2.0 * abs(np.mean(shape_of(run.schedule) * wave))
        line = complex(common * np.exp(-1j * start_phase(run.schedule)))
        at_drive = size * (line.real * wave.imag + line.imag * wave.real)
        common_part = np.zeros(len(angle))
        common_part[: len(repeats)] = repeats[: len(angle)]
        quiet.append(Quiet(replace(run, reading=run.reading - common_part - at_drive), line, len(moved)))
    return quiet


def _rests(runs: Sequence[Run]) -> tuple[Array, list[complex]]:
    """Return what the line leaves of each dwell, shape (m, n), NaN beyond the end of a run, and the line of each run.

    Raises
    ------
    DataError
        As `fit_line`.
    """
    shortest, longest = (limit(len(run.reading) for run in runs) for limit in (min, max))
    rest, lines = np.full((len(runs), longest), np.nan), []
    for row, run in zip(rest, runs, strict=True):
        found = fit_line(run.schedule, run.reading)
        part, at = run.reading - found.line, np.arange(len(run.reading))
        gaps = np.isnan(part)
        part[gaps] = np.interp(at[gaps], at[~gaps], found.drift[~gaps])
        row[: len(part)] = part - part[:shortest].mean()
        lines.append(complex(found.amplitude, np.nan_to_num(found.quadrature)))
    return rest, lines


def _repaired(runs: Sequence[Run]) -> list[Run]:
    """Return m runs without the jumps, kinks and false readings that one of them has and the median over them has not.

    The median of two runs is their mean, and both show half of a fault: it belongs to the one whose reading steps more.
    """
    usual = np.nanmedian(_rests(runs)[0], axis=0)
    found = [changes_of(run.schedule, run.reading - usual[: len(run.reading)], moved=False) for run in runs]

    def step(k: int, at: int) -> float:
        before = runs[k].reading[max(at - 3, 0) : at]
        size = abs(runs[k].reading[at] - np.median(before[np.isfinite(before)])) if np.isfinite(before).any() else 0.0
        return float(np.nan_to_num(size))

    sound = []
    for k, (run, own) in enumerate(zip(runs, found, strict=True)):
        rivals = [(j, one.at) for j, other in enumerate(found) if j != k for one in other.found]
        mine = all(step(k, one.at) >= step(j, one.at) for one in own.found for j, at in rivals if abs(at - one.at) <= 1)
        if not (own.found and mine and own.repairable):
            sound.append(run)
            continue
        x = run.reading - usual[: len(run.reading)]
        sizes = own.sizes * (2.0 if len(runs) == 2 else 1.0)
        sound.append(replace(run, reading=replace(own, sizes=sizes).repaired(x) + usual[: len(run.reading)]))
    return sound


def _parts(ahead: Array) -> tuple[Array, Array]:
    """Return the columns of what is fitted, shape (m, k), and the share of the quadrature in each value, shape (m,)."""
    m, share = len(ahead), np.zeros(len(ahead))
    ones = np.ones((m, 1))
    starts = np.unique(ahead)
    if len(starts) == 1:
        return ones, share
    if len(starts) == 2:
        sign = np.where(ahead == 0.0, 1.0, -1.0)
        cotangent = float(1.0 / np.tan(0.5 * starts.sum()))  # the other one is 0
        share = -cotangent * sign if abs(cotangent) > EXACT else share
        columns = np.column_stack([ones, sign])
    else:
        columns = np.column_stack([ones, np.cos(ahead), np.sin(ahead)])
    normal = columns.T @ columns
    if np.linalg.cond(normal) > 1.0 / EXACT:
        return ones, np.zeros(m)
    costs = np.linalg.inv(normal)[0, 0] * m * (1.0 + float(np.max(share**2)))
    return (columns, share) if costs <= COSTLY else (ones, np.zeros(m))


def join(values: Array, u: Array, dof: Array, columns: Array | None = None, phases: Array | None = None) -> Joined:
    """Return the mean of m values with their uncertainties and degrees of freedom, in one unit.

    Parameters
    ----------
    values, u, dof : ndarray, shape (m,)
        Of each run.
    columns : ndarray, shape (m, k), optional
        What is fitted: a column of ones for the mean, then what repeats.
    phases : ndarray, shape (m,), optional
        Kept in the result.
    """
    X = np.ones((len(values), 1)) if columns is None else columns
    spare = len(values) - X.shape[1]
    fit = _fitted(values, u, X, between_variance(values, u, X) if spare else 0.0)
    parts = (fit.weights * u) ** 2
    one_noise = np.ptp(u) < EXACT * u.min() and np.ptp(dof) < EXACT * dof.min()  # of all runs together
    spent = float(dof[0]) if one_noise else float(parts.sum() ** 2 / np.sum(parts**2 / dof))
    within = Mean(fit.mean, float(np.sqrt(parts.sum())), spent)
    between, p = None, np.nan
    if spare:
        between = Mean(fit.mean, float(np.sqrt(fit.covariance[0, 0] * fit.squares / spare)), float(spare))
        noise = _fitted(values, u, X, 0.0).squares
        p = float(special.fdtrc(spare, float(np.sum(dof)), noise / spare))
    repeats = X[:, 1:] @ fit.found[1:]
    largest = X[np.argmax(np.abs(repeats)), 1:]
    share = float(np.sqrt(largest @ fit.covariance[1:, 1:] @ largest / fit.covariance[0, 0]))
    return Joined(within, between, p, repeats, share * max(one.u for one in (within, between) if one), phases)


@dataclass(frozen=True, eq=False)
class _Fit:
    """Weighted least squares."""

    found: Array  # shape (k,)
    covariance: Array  # shape (k, k), for the weights as given
    weights: Array  # shape (m,): of the values in the mean
    squares: float  # Weighted, of the residuals

    @property
    def mean(self) -> float:
        return float(self.found[0])


def _fitted(values: Array, u: Array, X: Array, t_2: float) -> _Fit:
    w = 1.0 / (u**2 + t_2)
    covariance = np.asarray(np.linalg.inv(X.T @ (w[:, None] * X)), dtype=float)
    shares = covariance @ (X.T * w)
    found = shares @ values
    return _Fit(found, covariance, shares[0], float(w @ (values - X @ found) ** 2))


def between_variance(values: Array, u: Array, X: Array) -> float:
    """Return the variance between runs at which the squares of residuals reach their lower quartile; 0 if none does."""
    spare = len(values) - X.shape[1]
    wanted = 2.0 * float(special.gammaincinv(0.5 * spare, LOWER_QUARTILE))

    def excess(t_2: float) -> float:
        return _fitted(values, u, X, t_2).squares - wanted

    if excess(0.0) <= 0.0:
        return 0.0
    most = float(np.ptp(values) ** 2) * len(values) / wanted
    return float(optimize.brentq(excess, 0.0, most, rtol=1e-6))


SCALE, ERROR, DIFFERENCE = "scale_factor", "scale_factor_error", "high_g_difference"


SOURCES = {"between_runs": "scatter between runs", "within_runs": "noise within the runs"}


NAMES = {
    "source_mass.density": "density of the mass", "source_mass.placing": "places of the mass",
    "source_mass.gravitational_constant": "gravitational constant",
}  # fmt: skip


def estimate_of(
    plan: Plan, readings: Readings, responses: Sequence[Response], both: Joined, scatter: str
) -> Estimate:  # fmt: skip
    """Return the scale factor and the figures it is compared with, SI; `scatter` says which type A counts."""
    found = both.by(scatter)
    names, values, slopes, units = [SCALE], [found.value], [1.0], [plan.scale_unit]
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
        parts.append(Component("high-g scale factor", "B", _outer(own), stated=(plan.high_g.u, plan.scale_unit)))
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
    remainder = tilt_left(responses)
    if remainder:
        yield Component("coefficient of the tilt, from the noise of its meter", "B", _outer(way * remainder))


def compared_with(plan: Plan, estimate: Estimate | None) -> dict[str, str]:
    """Return what figures of the estimate are compared with, and the normalised difference, by quantity."""
    if estimate is None:
        return {}
    found = {}
    if plan.nominal:
        found[ERROR] = f"relative to {plan.nominal:.5g} {plan.scale_unit}, the scale factor of the chain"
    if plan.high_g is not None:
        i = len(estimate.names) - 1
        normalised = float(estimate.values[i]) / float(estimate.u[i])
        at_high_g = f"{plan.high_g.scale_factor:.5g} {plan.scale_unit}"
        found[DIFFERENCE] = f"relative to {at_high_g} at high g; normalised difference {normalised:+.2f}"
    return found


def _outer(u: Array) -> Array:
    return np.outer(u, u)

"""Scale factor and recoil arm from the harmonics of several runs: one least squares, weighted by the noise of each.

The reading of a run at the rate W is, with the field F of an offset proof mass along the input axis and across it
(``physics.turned_mass``) and the recoil rates q along it and p across::

    S { cos b [A F_x(phi) - a q cos phi] + sin b [A F_y(phi) - a p sin phi] }        phi = angle of the programme + d

Unknown: scale factor S, recoil arm a, both offsets, the zero d of the angle, and the direction b of the input axis in
the plane, which is known beforehand to its alignment. Where the recoil is stated, the arm is known beforehand too.

*Uncertainty.* The noise within the runs, with its degrees of freedom; or the squares of what the runs leave of cosine
and sine of their turns, which include whatever differs from run to run, with theirs. The one with the wider 95 %
interval is the uncertainty, as for a [moved mass](mass_attraction): it then holds 95 % or more.

Where the runs disagree by more than chance, each likely cause is tried: the sense of one run or of all, two runs
exchanged, one run that is disturbed at its turn. A cause is named if with it, and with no other kind, the runs agree.

Assumed: the scale factor is the same in all runs, nonlinearity is none (it would read as an offset), nothing follows
the turn in all runs alike but attraction and recoil. Real runs break this: heat of the turning motor, currents beside a
magnetic sensor, a cable that pulls; the recoil arm, set against the masses, shows it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from scipy import special

from ...core.estimate import Array
from ...physics.turned_mass import InputAxis, attraction, harmonics, recoil_arm, recoil_rates
from ...statistics.intervals import coverage_factor
from .plan import Plan
from .response import Response

PARAMETERS = ("scale_factor", "recoil_arm", "along", "across", "zero", "direction")
S, ARM, ALONG, ACROSS, ZERO, DIRECTION = range(6)
STEPS = np.array([1e-6, 1e-6, 1e-5, 1e-5, 1e-5, 1e-5])  # of differences; of S and arm relative
LEAST = 1e-9  # size of scale factor and arm for their steps
ROUNDS, CLOSE = 60, 1e-6  # of a standard uncertainty
HALVES = 12  # of a step that leads away
FARTHEST = 0.5  # offset over radius that is tried
DISAGREE = 1e-3  # chance from which causes are looked for
AGREES = 1e-2  # chance from which a cause explains the runs
FEW = 3  # runs, of which none can be left out to see whether the others agree
REVERSED, DISTURBED = "reversed", "disturbed"
SENSES = 1e-6  # of A: responses of both senses closer than this are the same


class Orbit(NamedTuple):
    """What is taken as known in a fit."""

    attraction: float  # A [m/s^2]
    radius: float  # [m]
    rate: float  # n [rad/s]
    axis: InputAxis = "radial"
    arm: tuple[float, float] | None = None  # Recoil arm as stated, with the size that its weight follows [m]
    alignment: float = 0.035  # [rad]


def orbit_of(plan: Plan, rate: float) -> Orbit:
    """Return what a plan takes as known."""
    (mass, radius), arm = plan.turned, None
    if plan.recoil == "stated" and plan.satellite is not None:
        own = recoil_arm(mass, radius, plan.satellite)
        arm = (own, 1e-6 * own)  # what is not known of it is Type B
    return Orbit(attraction(mass, radius), radius, rate, plan.input_axis, arm, plan.alignment)


@dataclass(frozen=True, eq=False)
class Joined:
    """All runs fitted together."""

    values: Array  # By PARAMETERS; offsets over the radius, angles [rad], shape (6,)
    within: Array  # Covariance from the noise of the runs, shape (6, 6)
    dof_within: Array  # shape (6,)
    squares: float  # What cosine and sine of the turns leave, over their noise
    spare: int  # Degrees of freedom of it
    p_value: float  # Chance of as much from noise alone; NaN without a degree of freedom
    residuals: Array  # Of cosine and sine of each run [count/s], shape (runs, 2)
    at_turn: Array  # Cosine and sine as fitted [count/s], shape (runs, 2)

    @property
    def excess(self) -> float:
        """Variance of the scatter over that of the noise."""
        return self.squares / self.spare if self.spare else math.nan

    @property
    def scatter(self) -> str:
        """Source of the uncertainty of the scale factor, that with the wider interval."""
        if not self.spare:
            return "within_runs"
        wide = coverage_factor(float(self.spare)) * math.sqrt(self.excess)
        return "between_runs" if wide >= coverage_factor(float(self.dof_within[S])) else "within_runs"

    def covariance(self, scatter: str) -> Array:
        """Return the covariance from this source, shape (6, 6)."""
        return self.within * self.excess if scatter == "between_runs" else self.within

    def dof(self, scatter: str) -> Array:
        """Return its degrees of freedom, shape (6,)."""
        return np.full(len(self.values), float(self.spare)) if scatter == "between_runs" else self.dof_within


def model(theta: Array, responses: Sequence[Response], orbit: Orbit) -> list[Array]:
    """Return cosine and sine of the harmonics of each run [count/s], shape (2 k,) each."""
    scale, arm, along, across, zero, direction = theta
    towards = scale * np.array([math.cos(direction), math.sin(direction)])
    field = orbit.attraction * harmonics(along, across)
    found = []
    for one in responses:
        recoil = recoil_rates(one.run.turn.rate, orbit.rate, orbit.axis)
        shown = np.array(one.harmonics)
        read = np.tensordot(towards, field[:, shown], 1)
        read[0] -= towards * arm * np.array([float(recoil[0]), float(recoil[1])])  # the first is the turn itself
        turned = (read[:, 0] - 1j * read[:, 1]) * np.exp(1j * zero * shown)
        found.append(np.column_stack([turned.real, -turned.imag]).ravel())
    return found


def join(responses: Sequence[Response], orbit: Orbit) -> Joined:
    """Return the fit of all runs; nothing is judged. A singular one has infinite variances."""
    theta = _start(responses, orbit)
    weights = [np.linalg.inv(one.covariance) for one in responses]
    known = np.zeros(len(theta))
    known[DIRECTION] = 1.0 / orbit.alignment**2
    beforehand = np.array(theta)
    if orbit.arm is not None:
        known[ARM], beforehand[ARM] = 1.0 / orbit.arm[1] ** 2, orbit.arm[0]
        theta[ARM] = orbit.arm[0]
    beforehand[DIRECTION] = 0.0
    if not any(len(one.harmonics) > 1 for one in responses):
        known[ALONG] = known[ACROSS] = 1e4  # nothing shows them: an offset of 1 % or less of the radius is taken

    def left(theta: Array) -> tuple[list[Array], float]:
        """Return what parameters leave of each run, and its squares with those of what is known beforehand."""
        rest = [one.values - own for one, own in zip(responses, model(theta, responses, orbit), strict=True)]
        squares = sum(float(r @ v @ r) for r, v in zip(rest, weights, strict=True))
        return rest, squares + float(known @ (beforehand - theta) ** 2)

    rest, squares = left(theta)
    jacobians: list[Array] = []
    for _ in range(ROUNDS):
        jacobians = _jacobians(theta, responses, orbit)
        normal = np.diag(known) + sum(j.T @ v @ j for j, v in zip(jacobians, weights, strict=True))
        down = known * (beforehand - theta) + sum(
            j.T @ v @ r for j, v, r in zip(jacobians, weights, rest, strict=True)
        )  # fmt: skip
        size = np.sqrt(np.diag(normal))
        step = np.linalg.lstsq(normal / np.outer(size, size), down / size, rcond=1e-12)[0] / size
        if np.all(np.abs(step) * size < CLOSE):
            break
        for _ in range(HALVES):  # a weak response is no line: a whole step may lead away
            tried = theta + step
            tried[[ALONG, ACROSS]] = np.clip(tried[[ALONG, ACROSS]], -FARTHEST, FARTHEST)
            tried[DIRECTION] = np.clip(tried[DIRECTION], -1.0, 1.0)
            now, least = left(tried)
            if least <= squares:
                break
            step = step / 2.0
        else:
            break
        theta, rest, squares = tried, now, least
    covariance = np.linalg.pinv(normal / np.outer(size, size), rcond=1e-12, hermitian=True) / np.outer(size, size)
    shares = [covariance @ j.T @ v for j, v in zip(jacobians, weights, strict=True)]
    own = [each[:2] for each in model(theta, responses, orbit)]
    turns = [one.values[:2] - each for one, each in zip(responses, own, strict=True)]
    squares = float(
        sum(r @ np.linalg.solve(one.covariance[:2, :2], r) for r, one in zip(turns, responses, strict=True))
    )
    spare = max(2 * len(responses) - (3 if orbit.arm is None else 2), 0)
    p = float(special.chdtrc(spare, squares)) if spare else math.nan
    return Joined(theta, covariance, _dof(responses, shares), squares, spare, p, np.array(turns), np.array(own))


def _dof(responses: Sequence[Response], shares: Sequence[Array]) -> Array:
    """Return the degrees of freedom of each parameter, from those of the noise of the runs."""
    white = [np.einsum("ij,jk,ik->i", g, one.white, g) for g, one in zip(shares, responses, strict=True)]
    walk = [np.einsum("ij,jk,ik->i", g, one.walk, g) for g, one in zip(shares, responses, strict=True)]
    if all(one.noise is responses[0].noise for one in responses):
        totals = zip(sum(white), sum(walk), strict=True)
        return np.array([float(responses[0].noise.of(float(a), float(b))[1][0]) for a, b in totals])
    dofs = []
    for k in range(len(PARAMETERS)):
        parts = [one.noise.of(float(a[k]), float(b[k])) for a, b, one in zip(white, walk, responses, strict=True)]
        variance, dof = (np.array([float(part[i][0]) for part in parts]) for i in (0, 1))
        dofs.append(float(variance.sum() ** 2 / max(float(np.sum(variance**2 / dof)), np.finfo(float).tiny)))
    return np.array(dofs)


def _start(responses: Sequence[Response], orbit: Orbit) -> Array:
    """Return parameters to begin with: the line of the cosines over the recoil rates, phase by the largest."""
    lines = np.array([complex(one.values[0], -one.values[1]) for one in responses])
    largest = lines[int(np.argmax(np.abs(lines) / np.array([one.u[0] for one in responses])))]
    zero = float(np.angle(largest))
    if abs(zero) > 0.5 * math.pi:
        zero -= math.copysign(math.pi, zero)
    cosines = (lines * np.exp(-1j * zero)).real
    q = np.array([float(recoil_rates(one.run.turn.rate, orbit.rate, orbit.axis)[0]) for one in responses])
    u = np.array([one.u[0] for one in responses])
    if orbit.arm is None:
        design = np.column_stack([np.full(len(q), orbit.attraction), -q])
        scale, slope = np.linalg.lstsq(design / u[:, None], cosines / u, rcond=None)[0]
        arm = slope / scale if scale else 0.0
    else:
        arm = orbit.arm[0]
        each = orbit.attraction - arm * q
        scale = float(np.sum(each * cosines / u**2) / np.sum((each / u) ** 2))
    return np.array([scale or 1.0, arm, 0.0, 0.0, zero, 0.0])


def _jacobians(theta: Array, responses: Sequence[Response], orbit: Orbit) -> list[Array]:
    """Return the slopes of each run by the parameters, shape (2 k, 6) each."""
    columns = []
    for k in range(len(theta)):
        step = STEPS[k] * (max(abs(theta[k]), LEAST) if k in (S, ARM) else 1.0)
        both = [model(theta + sign * step * np.eye(len(theta))[k], responses, orbit) for sign in (1.0, -1.0)]
        columns.append([(ahead - behind) / (2.0 * step) for ahead, behind in zip(*both, strict=True)])
    return [np.column_stack(each) for each in zip(*columns, strict=True)]


def separable(responses: Sequence[Response], orbit: Orbit) -> bool:
    """Return whether the runs differ in their recoil, so that it can be told from the attraction."""
    q = np.array([float(recoil_rates(one.run.turn.rate, orbit.rate, orbit.axis)[0]) for one in responses])
    return bool(len(q) > 1 and np.ptp(q) > SENSES * np.abs(q).max())


class Cause(NamedTuple):
    """Why runs disagree."""

    kind: str  # `REVERSED` or `DISTURBED`
    run: str  # Which run; empty for all
    p_value: float  # Chance of what is left, with it


def reversed_turn(one: Response) -> Response:
    """Return a response as it is if the mass turned the other way from the same start."""
    values, order = np.array(one.values), []
    for k, harmonic in enumerate(one.harmonics):
        both = 2.0 * harmonic * one.run.turn.angle
        c, s = math.cos(both), math.sin(both)
        order.append((2 * k, np.array([[c, s], [s, -c]])))
    turn = np.zeros((len(values), len(values)))
    for at, block in order:
        turn[at : at + 2, at : at + 2] = block
    run = replace(one.run, turn=replace(one.run.turn, rate=-one.run.turn.rate))
    return replace(one, run=run, values=turn @ values, white=turn @ one.white @ turn.T, walk=turn @ one.walk @ turn.T)


def causes(responses: Sequence[Response], orbit: Orbit) -> list[Cause]:
    """Return what may be wrong with runs that disagree, the likeliest first: all that explain them."""
    every = list(responses)
    tried = [(REVERSED, one.run.name, [*every[:k], reversed_turn(one), *every[k + 1 :]]) for k, one in enumerate(every)]
    tried.append((REVERSED, "", [reversed_turn(one) for one in every]))
    if len(every) > FEW:
        tried += [(DISTURBED, one.run.name, [*every[:k], *every[k + 1 :]]) for k, one in enumerate(every)]
    found = []
    for kind, run, changed in tried:
        if orbit.arm is not None or separable(changed, orbit):
            p = join(changed, orbit).p_value
            found += [Cause(kind, run, p)] if p > AGREES else []
    return sorted(found, key=lambda one: -one.p_value)

"""Matrix of the gyros from rotations: between static positions, where gravity tells the end, or by a known angle.

The rate is ``w = W z`` with ``z = reading - b - G f``, W the inverse of A. Between positions i and j gravity, seen from
the body, is carried by the rate; where it arrives must agree with what the accelerometers then read::

    e = E_j C(w) u_i - E_j u_j          u: unit vectors of specific force, E_j: two axes across u_j

of which the part along gravity is lost: a turn about the vertical tells nothing. A turn by a known angle about a known
axis of the body tells three numbers, ``e = W (integral of z) - angle * axis``: linear in the rate, with no attitude in
it, so that only a turn whose axis stays where it is named is described.

Rows: those of transitions first, two each, then those of turns, three each [rad].

Known beforehand of each rotation: the noise of the gyros over the time that it takes, the errors of both positions, the
stated uncertainties of turns. The scatter between rotations is of one unknown size (``statistics.two_levels``).

A small error dw(t) of the rate turns the attitude at the end by the integral of C(end, t) dw(t), with C(end, t) taking
vectors from the body at t to the body at the end. An error that is a matrix times some signal needs one such integral
for each axis of the rate and each component of the signal.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ....core.errors import DataError
from ....core.estimate import Array
from ....statistics.two_levels import TwoLevels, fit_two_levels
from ..plan import Plan
from ..readings import Rotation
from ._kernels_transitions import fill_sums, through
from .linear_sensor import MATRIX, USELESS, Observability, can_tell, observe
from .outliers import found_outliers

BETWEEN = "scatter between rotations"
ANGLE, ORIENTATION = "turn.angle", "fixture.orientation"
STEPS, HALVINGS = 40, 10
SETTLED = 1e-10
SMALL = 1e-6  # step that is not halved: where it lowers nothing, rounding and the size of a sample decide
SAME_AXIS = 1e-9  # one less the cosine between axes that are the same
# Singular value over the largest, below which a combination is not determined: turns about one axis wobble by 1 deg,
# and the little that the gyros across it then read is no turn about their own axes
WOBBLE = 0.02
ROUNDS = 4  # of leaving out and looking again
REFINED, REFINEMENTS = 1e-8, 6  # step of W from which its weights no longer move it; at most so many

Flags = NDArray[np.bool_]
GYRO_NOISE = "noise of the gyros over a rotation"
POSITIONS = "errors of the positions at both ends"


@dataclass(frozen=True, eq=False)
class Rotated:
    """Matrix of the gyros, and how each rotation agrees."""

    W: Array  # shape (3, 3): inverse of the matrix
    found: TwoLevels | None  # Of the parameters of W that are determined; None where nothing judges them
    observed: Observability  # What the rotations can tell
    by_rest: Array  # shape (9, 12): derivatives of W by bias and g-sensitivity
    by_positions: Array  # shape (9, m, 3): derivatives of W by the unit vectors of the positions
    outliers: Flags  # shape (rotations,): left out
    # shape (rows,): of all rotations, transitions first (two each), then turns (three each) [rad]
    residuals: Array
    deletion: Array  # shape (rows,): deletion residuals [rad]


def solve(plan: Plan, problem: Problem, start: Array, judge: bool = True) -> Rotated:
    """Find W.

    Parameters
    ----------
    plan : Plan
        Standards, risk of an outlier.
    problem : Problem
        Rotations.
    start : ndarray, shape (3, 3)
        W to begin with.
    judge : bool
        Whether rotations that do not agree are left out.

    Raises
    ------
    DataError
        ``no_rotations`` if there are none.
    """
    group = problem.group
    if not len(group):
        raise DataError(
            "no rotations",
            why="at rest, gyros show only their bias",
            do="Turn the unit between positions while recording, or by known angles",
            code="no_rotations",
        )
    outliers = np.zeros(int(group.max()) + 1, dtype=bool)
    W, here = _searched(problem, start, errors(problem, start), ~outliers[group])
    for _ in range(ROUNDS if judge else 0):  # by errors linear in W: a W bent by a wrong rotation may accuse others
        observed = _seen(problem, here.by_W, np.ones(len(group), dtype=bool))
        if not observed.rank:
            break
        y, known = here.by_W @ (W - start).ravel() - here.e, known_errors(plan, problem, here.by_start)
        found = found_outliers(here.by_W @ observed.kept, y, known, group, plan.outlier_risk)
        if np.array_equal(found, outliers):
            break
        outliers = found
        W, here = _searched(problem, W, here, ~outliers[group])
    return _refined(plan, problem, W, here, ~outliers[group], outliers)


def converged(problem: Problem, W: Array, kept: Flags) -> Array:
    """Return where Gauss-Newton with equal weights ends, from a W; ``kept``, shape (rows,): rows that count."""
    return _searched(problem, W, errors(problem, W), kept)[0]


def _searched(problem: Problem, W: Array, here: Errors, kept: Flags) -> tuple[Array, Errors]:
    """Damped Gauss-Newton with equal weights, and the errors at its end; what is not determined stays as it starts."""
    cost, scatter = float(np.sum(here.e[kept] ** 2)), _scatter(problem, kept)
    for _ in range(STEPS):
        left, s, right = np.linalg.svd(here.by_W[kept], full_matrices=False)
        good = can_tell(s, scatter, USELESS, WOBBLE)
        step = -(right[good].T @ (left[:, good].T @ here.e[kept] / s[good])).reshape(3, 3)
        for _ in range(HALVINGS):
            there = errors(problem, W + step)
            new = float(np.sum(there.e[kept] ** 2))
            if new <= cost:
                break
            if np.max(np.abs(step)) <= SMALL:
                return W, here
            step = 0.5 * step
        else:
            break
        W, here, cost = W + step, there, new
        if np.max(np.abs(step)) <= SETTLED:
            break
    return W, here


def _refined(plan: Plan, problem: Problem, W: Array, here: Errors, kept: Flags, outliers: Flags) -> Rotated:
    """Fit with all that is known of the errors, whose covariance moves a little with W."""
    for _ in range(REFINEMENTS):
        observed = _seen(problem, here.by_W, kept)
        found = _two_levels(plan, problem, here, observed.kept, kept)
        if found is None:
            break
        step = (observed.kept @ found.coefficients).reshape(3, 3)
        W = W + step
        here = errors(problem, W)
        if np.max(np.abs(step)) <= REFINED:
            break
    deletion = here.e.copy()
    if found is None:
        gain = np.asarray(observed.kept @ np.linalg.pinv(here.by_W[kept] @ observed.kept))  # of W by each row of errors
    else:
        gain = np.asarray(observed.kept @ found.gain)
        deletion[kept] = -found.deletion
    by_ends = -np.tensordot(gain, by_positions(problem, here.by_start)[kept], axes=1)
    return Rotated(W, found, observed, -gain @ by_rest(problem, W)[kept], by_ends, outliers, here.e, deletion)


def _two_levels(plan: Plan, problem: Problem, here: Errors, determined: Array, kept: Flags) -> TwoLevels | None:
    """Fit with a scatter between rotations, or without where there is none to be seen but the turns are stated."""
    known = known_errors(plan, problem, here.by_start)
    some = {name: part[kept] if part.ndim == 1 else part[np.ix_(kept, kept)] for name, part in known.items()}
    design, y = here.by_W[kept] @ determined, -here.e[kept]
    n, p = design.shape
    if n > p > 0:
        return fit_two_levels(design, y, some)
    stated = ANGLE in known and ORIENTATION in known
    return fit_two_levels(design, y, some, between=0.0) if n == p and stated else None


def _scatter(problem: Problem, kept: Flags) -> float:
    return float(np.sqrt(np.mean(noise_variances(problem)[kept])))


def _seen(problem: Problem, by_W: Array, kept: Flags) -> Observability:
    return observe(by_W[kept], MATRIX, _scatter(problem, kept), smallest=WOBBLE)


@dataclass(frozen=True, eq=False)
class Ends:
    """Specific force at both ends of transitions: unit vectors (k, 3), numbers of the positions (k,), axes across."""

    start: Array
    stop: Array
    before: NDArray[np.int64]
    after: NDArray[np.int64]
    across: Array


def ends_of(transitions: Sequence[Rotation], up: Array) -> Ends:
    """Return where gravity is at both ends of transitions; ``up``, shape (m, 3): unit vectors of all positions."""
    before = np.array([one.before for one in transitions], dtype=np.int64)
    after = np.array([one.after for one in transitions], dtype=np.int64)
    return Ends(up[before], up[after], before, after, across(up[after]))


def across(u: Array) -> Array:
    """Return two unit vectors across each of some, shape (k, 2, 3)."""
    least = np.eye(3)[np.argmin(np.abs(u), axis=1)]
    first = crossed(u, least)
    first /= np.linalg.norm(first, axis=1)[:, None]
    return np.stack([first, crossed(u, first)], axis=1)


def crossed(u: Array, v: Array) -> Array:
    """Return the cross products of vectors, shape (k, 3); for so few ``numpy.cross`` takes several times as long."""
    return np.asarray(u[:, [1, 2, 0]] * v[:, [2, 0, 1]] - u[:, [2, 0, 1]] * v[:, [1, 2, 0]])


@dataclass(frozen=True, eq=False)
class Problem:
    """All that is needed to find W: transitions, turns, and what is known of their errors."""

    moves: Packed  # Transitions
    ends: Ends  # Of the transitions
    turns: Packed  # Turns
    turned: Array  # Their known vectors [rad]
    noise: Array  # shape (3,): white noise of the gyros: standard deviation of a sample at rest [rad/s]
    up_variance: Array  # shape (m,): of the unit vectors of the positions, about each axis across [rad^2]

    @property
    def sizes(self) -> tuple[int, int]:
        """Numbers of transitions and turns."""
        return len(self.moves.first) - 1, len(self.turns.first) - 1

    @property
    def group(self) -> NDArray[np.int64]:
        """Rotation of each row."""
        k, t = self.sizes
        return np.concatenate([np.repeat(np.arange(k), 2), k + np.repeat(np.arange(t), 3)])


@dataclass(frozen=True, eq=False)
class Errors:
    """Errors of all rows, and what changes them.

    Parameters
    ----------
    e : ndarray, shape (rows,)
        [rad]
    by_W : ndarray, shape (rows, 9)
        Derivatives by W, row by row.
    by_start : ndarray, shape (2 k, 3)
        Derivatives of those of transitions by the unit vector at the start.
    """

    e: Array
    by_W: Array  # noqa: N815 - W as in the equations
    by_start: Array


def errors(problem: Problem, W: Array) -> Errors:
    """Return the errors of all rows for a W."""
    ends, (C, by_z) = problem.ends, carried_along(problem.moves, W, problem.moves.z)
    end = np.einsum("kij,kj->ki", C, ends.start)
    e = np.einsum("kai,ki->ka", ends.across, end)
    by_W = _lever(ends, end) @ by_z.reshape(-1, 3, 9)
    total = problem.turns.sums[0]
    by_W_turn = np.einsum("ij,tl->tijl", np.eye(3), total)
    return Errors(
        np.concatenate([e.ravel(), (total @ W.T - problem.turned).ravel()]),
        np.concatenate([by_W.reshape(-1, 9), by_W_turn.reshape(-1, 9)]),
        (ends.across @ C).reshape(-1, 3),
    )


def ends_missed(problem: Problem, W: Array, bias: Array, g_sensitivity: Array) -> tuple[Array, Array]:
    """Return the errors of all rotations by each of j gyros, with more bias and g-sensitivity than were taken off.

    Parameters
    ----------
    problem : Problem
        k transitions and t turns.
    W : ndarray, shape (j, 3, 3)
        Inverse of the matrix.
    bias : ndarray, shape (j, 3)
        Of the gyros [rad/s].
    g_sensitivity : ndarray, shape (j, 3, 3)
        What they read of specific force [(rad/s)/(m/s^2)].

    Returns
    -------
    of_moves, of_turns : ndarray, shapes (j, k, 2), (j, t, 3)
        [rad]
    """
    total, force, time = problem.turns.sums
    C = carried(problem.moves, W, bias, g_sensitivity)
    end = np.einsum("nkij,kj->nki", C, problem.ends.start)
    turned = total - time[:, None] * bias[:, None] - force @ np.swapaxes(g_sensitivity, 1, 2)
    of_turns = turned @ np.swapaxes(W, 1, 2) - problem.turned
    return np.einsum("kai,nki->nka", problem.ends.across, end), np.asarray(of_turns)


def _lever(ends: Ends, end: Array) -> Array:
    """Change of the errors of transitions by a small rotation of the body at the end, shape (k, 2, 3)."""
    x, y, z = end.T
    zero = np.zeros(len(end))
    cross = np.stack([zero, -z, y, z, zero, -x, -y, x, zero], axis=1).reshape(-1, 3, 3)
    return np.asarray(ends.across @ cross)


def by_rest(problem: Problem, W: Array) -> Array:
    """Return the derivatives of all rows by bias, then by g-sensitivity row by row, shape (rows, 12)."""
    moves, ends = problem.moves, problem.ends
    C, integrals = carried_along(moves, W, np.column_stack([np.ones(len(moves.f)), moves.f]))
    lever = _lever(ends, np.einsum("kij,kj->ki", C, ends.start))
    moved = (lever @ integrals.reshape(-1, 3, 12)).reshape(-1, 2, 3, 4)
    found = -np.einsum("kajl,jr->kalr", moved, W)  # l: one, then the components of f; r: gyro
    _, force, time = problem.turns.sums
    found_turn = -np.einsum("jr,tl->tjlr", W, np.column_stack([time, force]))
    return np.concatenate([_in_order(found), _in_order(found_turn)])


def _in_order(found: Array) -> Array:
    """Return derivatives (k, a, 4, gyro) by one and f as rows by bias and by g-sensitivity, shape (k a, 12)."""
    by_bias, by_g = found[:, :, 0], np.swapaxes(found[:, :, 1:], 2, 3).reshape(*found.shape[:2], 9)
    return np.concatenate([by_bias, by_g], axis=2).reshape(-1, 12)


def by_positions(problem: Problem, by_start: Array) -> Array:
    """Return the derivatives of all rows by the unit vectors of all positions, shape (rows, m, 3)."""
    k, t = problem.sizes
    ends, rows = problem.ends, np.arange(2 * k)
    wide = np.zeros((2 * k + 3 * t, len(problem.up_variance), 3))
    wide[rows, np.repeat(ends.before, 2)] += by_start
    wide[rows, np.repeat(ends.after, 2)] -= ends.across.reshape(-1, 3)
    return wide


def known_errors(plan: Plan, problem: Problem, by_start: Array) -> dict[str, Array]:
    """Return the covariances of all rows that are known, by source."""
    k, t = problem.sizes
    found = {GYRO_NOISE: noise_variances(problem)}
    if k:
        wide = by_positions(problem, by_start)
        scaled = (wide * np.sqrt(problem.up_variance)[None, :, None]).reshape(len(wide), -1)
        found[POSITIONS] = np.asarray(scaled @ scaled.T)
    angle, pose = plan.standards.get(ANGLE), plan.standards.get(ORIENTATION)
    if t and angle is not None:
        found[ANGLE] = _turn_covariance(problem, angle.u)
    if t and pose is not None:
        found[ORIENTATION] = _axis_covariance(problem, pose.u)
    return found


def noise_variances(problem: Problem) -> Array:
    """Variances of the rows by the noise of the gyros."""
    noise = float(np.mean(problem.noise**2))
    return noise * np.concatenate([np.repeat(problem.moves.squares, 2), np.repeat(problem.turns.squares, 3)])


def _turn_covariance(problem: Problem, u: float) -> Array:
    """Covariance of all rows by angles that are each uncertain by u [rad]."""
    k, t = problem.sizes
    covariance = np.zeros((2 * k + 3 * t, 2 * k + 3 * t))
    for row, vector in enumerate(problem.turned):
        at = slice(2 * k + 3 * row, 2 * k + 3 * row + 3)
        covariance[at, at] = u**2 * np.outer(vector, vector) / max(float(vector @ vector), 1e-300)
    return covariance


def _axis_covariance(problem: Problem, u: float) -> Array:
    """Covariance of all rows by axes that are each off by u [rad], the same in all turns about one, there and back."""
    k, t = problem.sizes
    covariance = np.zeros((2 * k + 3 * t, 2 * k + 3 * t))
    for row, one in enumerate(problem.turned):
        for column, other in enumerate(problem.turned):
            size = float(np.linalg.norm(one) * np.linalg.norm(other))
            if abs(float(one @ other)) < (1.0 - SAME_AXIS) * size or size == 0.0:
                continue
            at = (slice(2 * k + 3 * i, 2 * k + 3 * i + 3) for i in (row, column))
            covariance[tuple(at)] = u**2 * (float(one @ other) * np.eye(3) - np.outer(other, one))
    return covariance


def angles(problem: Problem, W: Array) -> Array:
    """Angle between where gravity was carried to and where it is, of each transition [rad], shape (k,)."""
    if not problem.sizes[0]:
        return np.empty(0)
    end = np.einsum("kij,kj->ki", carried(problem.moves, W[None])[0], problem.ends.start)
    return angle_between(end, problem.ends.stop)


def angle_between(u: Array, v: Array) -> Array:
    """Return the angle between unit vectors, shape (k,) [rad]."""
    return np.asarray(np.arctan2(np.linalg.norm(crossed(u, v), axis=1), np.sum(u * v, axis=1)))


@dataclass(frozen=True, eq=False)
class Packed:
    """Samples of all rotations in a row."""

    z: Array  # shape (n, 3): readings of the gyros less bias and g-sensitivity [rad/s]
    f: Array  # shape (n, 3): specific force [m/s^2]
    h: Array  # shape (n,): time to the next sample [s], 0 from the last of a rotation
    first: NDArray[np.int64]  # shape (k + 1,): where each begins, and the end

    @cached_property
    def _summed(self) -> tuple[Array, Array, Array, Array]:
        k = len(self.first) - 1
        found = np.empty((k, 3)), np.empty((k, 3)), np.empty(k), np.empty(k)
        fill_sums(self.z, self.f, self.h, self.first, *found)
        return found

    @property
    def squares(self) -> Array:
        """Sums of h^2, shape (k,) [s^2]: the variance of an integral over that of a sample."""
        return self._summed[3]

    @property
    def sums(self) -> tuple[Array, Array, Array]:
        """Integrals of z (k, 3), f (k, 3) and one (k,) over each rotation, by trapezoids."""
        return self._summed[:3]


def packed(rotations: Sequence[Rotation], z: Sequence[Array], f: Sequence[Array]) -> Packed:
    """Return the samples of rotations in a row."""
    first = np.cumsum([0, *(len(one.seconds) for one in rotations)])
    empty = np.empty((0, 3))
    h = np.diff(np.concatenate([np.empty(0), *(one.seconds for one in rotations), np.zeros(1)]))
    h[first[1:][np.diff(first) > 0] - 1] = 0.0
    whole, force = (np.ascontiguousarray(np.concatenate([empty, *parts])) for parts in (z, f))
    return Packed(whole, force, h, first.astype(np.int64))


def carried(samples: Packed, W: Array, bias: Array | None = None, G: Array | None = None) -> Array:
    """Return what rotations do to vectors by each of j gyros.

    Parameters
    ----------
    samples : Packed
        k rotations.
    W : ndarray, shape (j, 3, 3)
        The rate is W (z - bias - G f).
    bias, G : ndarray, shapes (j, 3), (j, 3, 3), optional
        None by default.

    Returns
    -------
    ndarray, shape (j, k, 3, 3)
        Takes vectors from the body at the start to the body at the end.
    """
    return _through(samples, W, bias, G, np.empty((len(samples.z), 0)))[0]


def carried_along(samples: Packed, W: Array, signal: Array) -> tuple[Array, Array]:
    """Return what rotations do to vectors, and the integrals of C(end, t) times a signal.

    Parameters
    ----------
    samples : Packed
        k rotations.
    W : ndarray, shape (3, 3)
        The rate is W z.
    signal : ndarray, shape (n, m)
        On the clock of the samples.

    Returns
    -------
    C : ndarray, shape (k, 3, 3)
        Takes vectors from the body at the start to the body at the end.
    integrals : ndarray, shape (k, 3, 3, m)
        [:, :, j, l] for component l of the signal along axis j.
    """
    (C,), (at_start,) = _through(samples, W[None], None, None, np.ascontiguousarray(signal))
    return C, np.einsum("kpi,klji->kpjl", C, at_start)  # j, i: axis of the rate, of the body at the start


def _through(samples: Packed, W: Array, bias: Array | None, G: Array | None, signal: Array) -> tuple[Array, Array]:
    j, k = len(W), len(samples.first) - 1
    end, integrals = np.empty((j, k, 3, 3)), np.empty((j, k, signal.shape[1], 3, 3))
    none = np.zeros((j, 3)) if bias is None else bias, np.zeros((j, 3, 3)) if G is None else G
    through(samples.z, samples.f, samples.h, samples.first, np.ascontiguousarray(W), *none, signal, end, integrals)
    return end, integrals

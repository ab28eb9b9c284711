"""Matrix of the gyros from rotations: between static positions, where gravity tells the end, or by a known angle.

The rate is ``w = W z`` with ``z = reading - b - G f``, W the inverse of A. Between positions i and j gravity, seen from
the body, is carried by the rate; where it arrives must agree with what the accelerometers then read::

    e = E_j C(w) u_i - E_j u_j          u: unit vectors of specific force, E_j: two axes across u_j

of which the part along gravity is lost: a turn about the vertical tells nothing. A turn by a known angle about a known
axis of the body tells three numbers, ``e = W (integral of z) - angle * axis``: linear in the rate, with no attitude in
it, so that only a turn whose axis stays where it is named is described.

The errors known of each: the noise of the gyros over the time that it takes, the errors of both positions, the stated
uncertainties of turns. The scatter between rotations beside it is of one unknown size (``statistics.two_levels``).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...core.errors import DataError
from ...core.estimate import Array
from ...statistics.two_levels import TwoLevels, fit_two_levels
from ._kernels_transitions import through
from .observability import Observed, observed
from .outliers import found_outliers
from .plan import Plan
from .readings import Rotation

GYRO_NOISE = "noise of the gyros over a rotation"
POSITIONS = "errors of the positions at both ends"
ANGLE, ORIENTATION = "turn.angle", "fixture.orientation"
BETWEEN = "scatter between rotations"
STEPS = 40
SETTLED = 1e-10
W_NAMES = tuple(
    f"scale_factor_error_{a}" if a == b else f"misalignment_{a}{b}" for a in ("x", "y", "z") for b in ("x", "y", "z")
)

Flags = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Packed:
    """Samples of all rotations in a row.

    Parameters
    ----------
    z, f : ndarray, shape (n, 3)
        Readings of the gyros less bias and g-sensitivity [rad/s], specific force [m/s^2].
    h : ndarray, shape (n,)
        Time to the next sample [s].
    first : ndarray of int, shape (k + 1,)
        Where each begins, and the end.
    """

    z: Array
    f: Array
    h: Array
    first: NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Ends:
    """Specific force at both ends of transitions: unit vectors (k, 3), numbers of the positions (k,), axes across."""

    start: Array
    stop: Array
    before: NDArray[np.int64]
    after: NDArray[np.int64]
    across: Array


@dataclass(frozen=True, eq=False)
class Rotated:
    """Matrix of the gyros, and how each rotation agrees.

    Parameters
    ----------
    W : ndarray, shape (3, 3)
        Inverse of the matrix.
    found : TwoLevels or None
        Of the parameters of W that are told; None where nothing judges them.
    seen : Observed
        What the rotations can tell.
    by_rest : ndarray, shape (9, 12)
        Derivatives of W by bias and g-sensitivity.
    by_positions : ndarray, shape (9, m, 3)
        Derivatives of W by the unit vectors of the positions.
    outliers : ndarray of bool, shape (rotations,)
        Left out.
    residuals, deletion : ndarray, shape (rows,)
        Of the rows of all rotations, transitions first (two each), then turns (three each) [rad].
    """

    W: Array
    found: TwoLevels | None
    seen: Observed
    by_rest: Array
    by_positions: Array
    outliers: Flags
    residuals: Array
    deletion: Array


def packed(rotations: Sequence[Rotation], z: Sequence[Array], f: Sequence[Array]) -> Packed:
    """Return the samples of rotations in a row."""
    sizes = np.array([0, *(len(one.seconds) for one in rotations)])
    h = np.concatenate([np.append(np.diff(one.seconds), 0.0) for one in rotations]) if rotations else np.empty(0)
    empty = np.empty((0, 3))
    return Packed(
        np.ascontiguousarray(np.concatenate([empty, *z])),
        np.ascontiguousarray(np.concatenate([empty, *f])),
        h,
        np.cumsum(sizes).astype(np.int64),
    )


def carried(samples: Packed, W: Array) -> tuple[Array, Array, Array, Array]:
    """Return C (k, 3, 3) and the integrals by z, f (k, 3, 9) and one (k, 3, 3) of each rotation."""
    k = len(samples.first) - 1
    C, by_1 = np.empty((k, 3, 3)), np.empty((k, 3, 3))
    by_z, by_f = np.empty((k, 3, 9)), np.empty((k, 3, 9))
    through(samples.z, samples.f, samples.h, samples.first, np.ascontiguousarray(W), C, by_z, by_f, by_1)
    return C, by_z, by_f, by_1


def ends_of(transitions: Sequence[Rotation], up: Array) -> Ends:
    """Return where gravity is at both ends of transitions; ``up``, shape (m, 3): unit vectors of all positions."""
    before = np.array([one.before for one in transitions], dtype=np.int64)
    after = np.array([one.after for one in transitions], dtype=np.int64)
    return Ends(up[before], up[after], before, after, across(up[after]))


def across(u: Array) -> Array:
    """Return two unit vectors across each of some, shape (k, 2, 3)."""
    least = np.eye(3)[np.argmin(np.abs(u), axis=1)]
    first = np.cross(u, least)
    first /= np.linalg.norm(first, axis=1)[:, None]
    return np.stack([first, np.cross(u, first)], axis=1)


def transition_errors(samples: Packed, ends: Ends, W: Array) -> tuple[Array, Array, Array, Array]:
    """Return errors (2 k,) [rad], and their derivatives by W (2 k, 9), by bias and G (2 k, 12), by start (2 k, 3)."""
    C, by_z, by_f, by_1 = carried(samples, W)
    end = np.einsum("kij,kj->ki", C, ends.start)
    e = np.einsum("kai,ki->ka", ends.across, end)
    lever = np.einsum("kai,kil->kal", ends.across, _cross_matrix(end))  # of a small rotation of the body
    by_W = lever @ by_z
    by_bias = -lever @ by_1 @ W
    columns = by_f.reshape(len(C), 3, 3, 3)  # (k, axis of the rate, row of W z, component of f)
    by_g = -np.einsum("kai,kijl,jr->karl", lever, columns, W).reshape(len(C), 2, 9)
    by_rest = np.concatenate([by_bias, by_g], axis=2)
    return e.ravel(), by_W.reshape(-1, 9), by_rest.reshape(-1, 12), (ends.across @ C).reshape(-1, 3)


def _cross_matrix(v: Array) -> Array:
    """Matrices of the cross products with v, shape (k, 3, 3)."""
    zero = np.zeros(len(v))
    x, y, z = v.T
    return np.stack([zero, -z, y, z, zero, -x, -y, x, zero], axis=1).reshape(-1, 3, 3)


def turn_errors(samples: Packed, turned: Array, W: Array) -> tuple[Array, Array, Array]:
    """Return errors (3 k,) [rad] of turns by the vectors ``turned`` (k, 3), derivatives by W and by bias and G."""
    k = len(samples.first) - 1
    by_W, by_rest = np.zeros((k, 3, 9)), np.zeros((k, 3, 12))
    total, force, time = sums(samples)
    for j in range(3):
        by_W[:, j, 3 * j : 3 * j + 3] = total
    by_rest[:, :, :3] = -time[:, None, None] * W
    by_rest[:, :, 3:] = -np.einsum("jr,kl->kjrl", W, force).reshape(k, 3, 9)
    return (total @ W.T - turned).ravel(), by_W.reshape(-1, 9), by_rest.reshape(-1, 12)


def sums(samples: Packed) -> tuple[Array, Array, Array]:
    """Return the integrals of z, f and one over each rotation, by trapezoids."""
    total, force, time = [], [], []
    for a, b in zip(samples.first[:-1], samples.first[1:], strict=True):
        h = samples.h[a : b - 1]
        weight = 0.5 * (np.append(h, 0.0) + np.append(0.0, h))
        total.append(weight @ samples.z[a:b])
        force.append(weight @ samples.f[a:b])
        time.append(weight.sum())
    return np.array(total).reshape(-1, 3), np.array(force).reshape(-1, 3), np.array(time)


@dataclass(frozen=True, eq=False)
class Problem:
    """All that is needed to find W: transitions, turns, and what is known of their errors.

    Parameters
    ----------
    moves, ends : Packed, Ends
        Transitions.
    turns, turned : Packed, ndarray (t, 3)
        Turns and their known vectors [rad].
    noise : ndarray, shape (3,)
        White noise of the gyros: standard deviation of a sample at rest [rad/s].
    up_variance : ndarray, shape (m,)
        Of the unit vectors of the positions, about each axis across [rad^2].
    """

    moves: Packed
    ends: Ends
    turns: Packed
    turned: Array
    noise: Array
    up_variance: Array

    @property
    def sizes(self) -> tuple[int, int]:
        """Numbers of transitions and turns."""
        return len(self.moves.first) - 1, len(self.turns.first) - 1

    @property
    def group(self) -> NDArray[np.int64]:
        """Rotation of each row."""
        k, t = self.sizes
        return np.concatenate([np.repeat(np.arange(k), 2), k + np.repeat(np.arange(t), 3)])


def errors(problem: Problem, W: Array) -> tuple[Array, Array, Array, Array]:
    """Return errors of all rows, derivatives by W and by bias and G, and those of transitions by the start."""
    e, by_W, by_rest, by_start = transition_errors(problem.moves, problem.ends, W)
    e_turn, by_W_turn, by_rest_turn = turn_errors(problem.turns, problem.turned, W)
    return np.concatenate([e, e_turn]), np.vstack([by_W, by_W_turn]), np.vstack([by_rest, by_rest_turn]), by_start


def known_errors(plan: Plan, problem: Problem, by_start: Array) -> dict[str, Array]:
    """Return the covariances of all rows that are known, by source."""
    k, t = problem.sizes
    found = {GYRO_NOISE: noise_variances(problem)}
    if k:
        found[POSITIONS] = _position_covariance(problem, by_start)
    angle, pose = plan.standards.get(ANGLE), plan.standards.get(ORIENTATION)
    if t and angle is not None:
        found[ANGLE] = _turn_covariance(problem, angle.u, along=True)
    if t and pose is not None:
        found[ORIENTATION] = _turn_covariance(problem, pose.u, along=False)
    return found


def _by_positions(problem: Problem, by_start: Array) -> Array:
    """Return the derivatives of all rows by the unit vectors of all positions, shape (rows, m, 3)."""
    k, t = problem.sizes
    wide = np.zeros((2 * k + 3 * t, len(problem.up_variance), 3))
    for row in range(k):
        wide[2 * row : 2 * row + 2, problem.ends.before[row]] += by_start[2 * row : 2 * row + 2]
        wide[2 * row : 2 * row + 2, problem.ends.after[row]] -= problem.ends.across[row]
    return wide


def _position_covariance(problem: Problem, by_start: Array) -> Array:
    wide = _by_positions(problem, by_start)
    scaled = (wide * np.sqrt(problem.up_variance)[None, :, None]).reshape(len(wide), -1)
    return np.asarray(scaled @ scaled.T)


def _turn_covariance(problem: Problem, u: float, along: bool) -> Array:
    k, t = problem.sizes
    covariance = np.zeros((2 * k + 3 * t, 2 * k + 3 * t))
    for row, vector in enumerate(problem.turned):
        outer = np.outer(vector, vector) / max(float(vector @ vector), 1e-300)
        own = outer if along else float(vector @ vector) * (np.eye(3) - outer)
        at = slice(2 * k + 3 * row, 2 * k + 3 * row + 3)
        covariance[at, at] = u**2 * own
    return covariance


def solve(plan: Plan, problem: Problem, start: Array) -> Rotated:
    """Find W.

    Parameters
    ----------
    plan : Plan
        Standards, risk of an outlier.
    problem : Problem
        Rotations.
    start : ndarray, shape (3, 3)
        W to begin with.

    Raises
    ------
    DataError
        ``no_rotations`` if there are none.
    """
    group = problem.group
    if not len(group):
        raise DataError(
            "no rotations",
            why="gyros that rest tell their bias alone",
            do="Turn the unit between positions while recording, or by known angles",
            code="no_rotations",
        )
    everyone = np.ones(len(group), dtype=bool)
    W = converged(problem, start, everyone)
    e, by_W, _, by_start = errors(problem, W)
    seen = _seen(problem, by_W, everyone)
    known = known_errors(plan, problem, by_start)
    outliers = np.zeros(int(group.max()) + 1, dtype=bool)
    if seen.rank:
        y = by_W @ (W - start).ravel() - e
        outliers = found_outliers(by_W @ seen.kept, y, known, group, plan.outlier_risk)
    kept = ~outliers[group]
    return _refined(plan, problem, converged(problem, W, kept), kept, outliers)


def _refined(plan: Plan, problem: Problem, W: Array, kept: Flags, outliers: Flags) -> Rotated:
    found = None
    for _ in range(6):
        e, by_W, by_rest, by_start = errors(problem, W)
        seen = _seen(problem, by_W, kept)
        found = _two_levels(plan, problem, by_W @ seen.kept, -e, by_start, kept)
        if found is None:
            break
        step = (seen.kept @ found.coefficients).reshape(3, 3)
        W = W + step
        if np.max(np.abs(step)) <= 1e-8:
            break
    e, by_W, by_rest, by_start = errors(problem, W)
    deletion = e.copy()
    if found is not None:
        deletion[kept] = -found.deletion
    gain = _gain(found, seen, by_W, kept)
    by_positions = _by_positions(problem, by_start)[kept]
    derivatives = -np.tensordot(gain, by_positions, axes=1)
    return Rotated(W, found, seen, -gain @ by_rest[kept], derivatives, outliers, e, deletion)


def _gain(found: TwoLevels | None, seen: Observed, by_W: Array, kept: Flags) -> Array:
    """Change of W by each row of errors, shape (9, rows)."""
    if found is not None:
        return np.asarray(seen.kept @ found.gain)
    return np.asarray(seen.kept @ np.linalg.pinv(by_W[kept] @ seen.kept))


def _two_levels(
    plan: Plan, problem: Problem, design: Array, y: Array, by_start: Array, kept: Flags
) -> TwoLevels | None:
    """Fit with a scatter between rotations, or without where there is none to be seen but the turns are stated."""
    known = known_errors(plan, problem, by_start)
    some = {name: part[kept] if part.ndim == 1 else part[np.ix_(kept, kept)] for name, part in known.items()}
    n, p = int(np.sum(kept)), design.shape[1]
    if n > p > 0:
        return fit_two_levels(design[kept], y[kept], some)
    stated = ANGLE in known and ORIENTATION in known
    return fit_two_levels(design[kept], y[kept], some, between=0.0) if n == p and stated else None


def _seen(problem: Problem, by_W: Array, kept: Flags) -> Observed:
    scatter = float(np.sqrt(np.mean(noise_variances(problem)[kept])))
    return observed(by_W[kept], W_NAMES, scatter)


def noise_variances(problem: Problem) -> Array:
    """Variances of the rows by the noise of the gyros."""
    noise = float(np.mean(problem.noise**2))
    found = [np.sum(part.h[a:b] ** 2) for part in (problem.moves, problem.turns)
             for a, b in zip(part.first[:-1], part.first[1:], strict=True)]  # fmt: skip
    k, t = problem.sizes
    return np.repeat(noise * np.array(found), np.concatenate([np.full(k, 2), np.full(t, 3)]).astype(np.int64))


def converged(problem: Problem, W: Array, kept: Flags) -> Array:
    """Gauss-Newton with equal weights, damped; what is not told stays as it starts."""
    e, by_W, _, _ = errors(problem, W)
    cost = float(np.sum(e[kept] ** 2))
    for _ in range(STEPS):
        step = np.linalg.lstsq(by_W[kept], -e[kept], rcond=1e-4)[0].reshape(3, 3)
        for _ in range(10):
            e_trial, by_W_trial, _, _ = errors(problem, W + step)
            new = float(np.sum(e_trial[kept] ** 2))
            if new <= cost:
                break
            step = 0.5 * step
        else:
            break
        W, e, by_W, cost = W + step, e_trial, by_W_trial, new
        if np.max(np.abs(step)) <= SETTLED:
            break
    return W


def angles(problem: Problem, W: Array) -> Array:
    """Angle between where gravity was carried to and where it is, of each transition [rad], shape (k,)."""
    if not problem.sizes[0]:
        return np.empty(0)
    C = carried(problem.moves, W)[0]
    end = np.einsum("kij,kj->ki", C, problem.ends.start)
    sine = np.linalg.norm(np.cross(end, problem.ends.stop), axis=1)
    return np.asarray(np.arctan2(sine, np.sum(end * problem.ends.stop, axis=1)))

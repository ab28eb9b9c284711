"""Arcs: what a gyro and a magnetometer say together over a stretch of minutes, whatever the attitude at its start.

Over an arc the readings of the gyro, less its bias b, turn the body from its first sample to each other one: P_k(b).
With the field of the earth R_k along the orbit, in axes that do not turn, and one unknown attitude A a magnetometer
reads

    B_k = m + (1 + s) P_k(b) A R_k + noise

A stands for the whole arc and is estimated with it; b, m (and s, where asked) are common to all arcs. The noise of
the gyro adds up to a random walk of the attitude within the arc: P_k is off by a rotation whose variance grows with
the time from its start. Residuals are therefore weighted by their whole covariance, that of both sensors (generalised
least squares), in the axes of the start of the arc, where the walk has one direction for all samples:

    C_ij = sigma^2 delta_ij + N^2 min(t_i, t_j) [F_i] [F_j]^T          F = A R, [F] v = F x v

An arc has its own attitude and shares no reading with another: so the pieces that overlap in residuals of pairs of
samples, and their correlation, are inside one arc, and arcs are independent. The covariance of the figures is taken
from the scatter of the arcs (each left out in turn), so that it holds as well where weights are not quite right and
where the field differs from its model within an arc.

References
----------
.. [1] J. L. Crassidis, F. L. Markley, J. Guid. Control Dyn. 20 (1997) 1080 (attitude from vectors, left as unknown).
.. [2] A. C. Cameron, D. L. Miller, J. Human Resources 50 (2015) 317 (clustered scatter, jackknife of clusters).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...core.errors import DataError
from ...core.estimate import Array

NODES = 60  # means of an arc that are weighted against each other
STEPS, STILL = 40, 1e-6  # of the search; step over uncertainty at which it ends
FLAT = 1e-9  # of the information on an attitude, below which a direction has none


@dataclass(frozen=True, eq=False)
class Arc:
    """A stretch without gap."""

    times: Array  # shape (n,): of the samples with a reading of the field, from the start of the arc [s]
    rates: Array  # shape (steps, 3): mean rate between neighbouring samples of the gyro [rad/s]
    interval: float  # between those [s]
    at: np.ndarray  # shape (n,): which sample of the gyro each reading of the field belongs to
    field: Array  # shape (n, 3): as read [T]
    reference: Array  # shape (n, 3): along the orbit, in axes that do not turn [T]
    start: float  # after the start of the record [s]
    moved: Array | None = None  # shape (n, 3, k): change of the reference by influences of its own [T]
    record: int = 0  # which it is of

    @property
    def length(self) -> float:
        """From its first to its last sample of the gyro [s]."""
        return len(self.rates) * self.interval


@dataclass(frozen=True)
class Noise:
    """What residuals are weighted by."""

    field: float  # of one reading of the magnetometer, any axis [T]
    walk: float  # angle random walk of the gyro [rad/sqrt(s)]


def turned(arcs: Sequence[Arc], bias: Array) -> list[Array]:
    """Return the rotations from the start of each arc to its readings of the field, shape (n, 3, 3).

    All arcs are turned at once, a sample at a time: the shorter ones stand still at their end.
    """
    most = max(len(one.rates) for one in arcs)
    angles = np.zeros((len(arcs), most, 3))
    for i, one in enumerate(arcs):
        angles[i, : len(one.rates)] = -(one.rates - bias) * one.interval
    steps = rotations(angles)
    every = np.empty((len(arcs), most + 1, 3, 3))
    every[:, 0] = np.eye(3)
    for k in range(most):
        np.matmul(steps[:, k], every[:, k], out=every[:, k + 1])
    return [every[i, one.at] for i, one in enumerate(arcs)]


def rotations(vectors: Array) -> Array:
    """Return the rotations about so many vectors by their lengths, shape (..., 3, 3)."""
    angle = np.linalg.norm(vectors, axis=-1)[..., None, None]
    across = cross_matrix(vectors)
    safe = np.where(angle > 1e-12, angle, 1.0)
    one = np.where(angle > 1e-12, np.sin(safe) / safe, 1.0)
    two = np.where(angle > 1e-12, 2.0 * (np.sin(0.5 * safe) / safe) ** 2, 0.5)
    return np.eye(3) + one * across + two * (across @ across)


def cross_matrix(vectors: Array) -> Array:
    """Return the matrices that make the vector product with each vector, shape (..., 3, 3)."""
    out = np.zeros((*vectors.shape, 3))
    x, y, z = vectors[..., 0], vectors[..., 1], vectors[..., 2]
    out[..., 0, 1], out[..., 0, 2], out[..., 1, 2] = -z, y, -x
    out[..., 1, 0], out[..., 2, 0], out[..., 2, 1] = z, -y, x
    return out


@dataclass(frozen=True, eq=False)
class Equations:
    """One arc about a point of the search: information on the common unknowns, and what it pulls them by."""

    information: Array  # shape (p, p)
    pull: Array  # shape (p,)
    others: Array  # shape (p, 12 + k): information between them and influences that are not estimated
    squares: float  # of weighted residuals
    left: Array  # shape (n,): length of what each reading leaves, without weights [T]


@dataclass(frozen=True, eq=False)
class Solution:
    """Common unknowns of all arcs."""

    values: Array  # shape (p,): bias [rad/s], bias of the magnetometer [T], its scale factor errors (1)
    equations: tuple[Equations, ...]

    @property
    def information(self) -> Array:
        """Of all arcs, shape (p, p)."""
        return np.asarray(sum(one.information for one in self.equations))

    @property
    def covariance(self) -> Array:
        """By the scatter of the arcs, each left out in turn, shape (p, p)."""
        k = len(self.equations)
        left = self.left_out
        return (k - 1) / k * (left.T @ left)

    @property
    def left_out(self) -> Array:
        """Change of the unknowns where each arc is left out, to first order, shape (arcs, p)."""
        whole = self.information
        return np.array([-np.linalg.lstsq(whole - one.information, one.pull, rcond=None)[0] for one in self.equations])

    @property
    def forecast(self) -> Array:
        """Covariance by the weights alone: as good as the noise that they state, shape (p, p)."""
        return np.asarray(np.linalg.inv(self.information), dtype=float)

    @property
    def dof(self) -> Array:
        """Degrees of freedom of the scatter of the arcs, by how evenly they share the information, shape (p,)."""
        inverse = self.forecast
        shares = np.array([np.diag(inverse @ one.information @ inverse) for one in self.equations])
        return np.asarray(np.maximum(shares.sum(axis=0) ** 2 / np.sum(shares**2, axis=0) - 1.0, 1.0))

    def changes(self) -> Array:
        """Change of the unknowns where one unit of each influence is left out of account, shape (12 + k, p).

        Nine entries of the gyro's matrix, row by row (axis that reads, axis that turns); then a uniform error of the
        field along three axes [T]; then those of the arcs' own (``Arc.moved``).
        """
        return np.linalg.solve(self.information, np.asarray(sum(one.others for one in self.equations))).T


def solved(arcs: Sequence[Arc], start: Array, noise: Noise, scale: bool) -> Solution:
    """Return the common unknowns that fit all arcs best.

    Parameters
    ----------
    arcs : sequence of Arc
        Two at least.
    start : ndarray, shape (6,)
        Bias [rad/s] and bias of the magnetometer [T] from which the search begins.
    noise : Noise
        That residuals are weighted by.
    scale : bool
        Estimate the scale factor errors of the magnetometer as well.

    Raises
    ------
    DataError
        ``not_observable`` if the arcs leave an unknown open.
    """
    values = np.concatenate([start, np.zeros(3)]) if scale else np.array(start, dtype=float)
    now = equations(arcs, values, noise)
    damping = 1e-3
    for _ in range(STEPS):
        information = np.asarray(sum(one.information for one in now))
        pull = np.asarray(sum(one.pull for one in now))
        diagonal = np.diag(information)
        if not (diagonal > 0.0).all():
            break
        step = np.linalg.lstsq(information + damping * np.diag(diagonal), pull, rcond=None)[0]
        tried = equations(arcs, values + step, noise)
        if sum(one.squares for one in tried) <= sum(one.squares for one in now) * (1.0 + 1e-12):
            values, now, damping = values + step, tried, damping * 0.1
            if float(step @ information @ step) < STILL:
                break
        elif damping > 1e8:
            break
        else:
            damping *= 10.0
    found = Solution(values, tuple(now))
    scaled = _correlation_scaled(found.information)
    if not np.isfinite(scaled).all() or np.linalg.cond(scaled) > 1e12:
        why = "neither the field in the body nor the attitude turns enough"
        do = "Record longer, or while turning about another axis"
        raise DataError("the record leaves a bias open", why=why, do=do, code="not_observable")
    return found


def _correlation_scaled(information: Array) -> Array:
    size = np.sqrt(np.abs(np.diag(information)))
    return np.asarray(information / np.outer(size, size))


def equations(arcs: Sequence[Arc], values: Array, noise: Noise) -> list[Equations]:
    """Return what each arc knows about a point of the search, its attitude solved for.

    Parameters
    ----------
    arcs : sequence of Arc
        Of all recordings.
    values : ndarray, shape (p,)
        Bias [rad/s], bias of the magnetometer [T], and where estimated its scale factor errors (1).
    noise : Noise
        That residuals are weighted by.
    """
    bias, offset = values[:3], values[3:6]
    scale = values[6:] if len(values) > 6 else np.zeros(3)
    return [_of_arc(one, turns, bias, offset, scale, len(values), noise)
            for one, turns in zip(arcs, turned(arcs, bias), strict=True)]  # fmt: skip


def _of_arc(arc: Arc, turns: Array, bias: Array, offset: Array, scale: Array, size: int, noise: Noise) -> Equations:
    """Return the equations of one arc: its attitude solved for, residuals and their changes as means of nodes."""
    body = (arc.field - offset) / (1.0 + scale)
    attitude = _attitude(np.einsum("kji,kj->ki", turns, body), arc.reference)
    seen = arc.reference @ attitude.T  # F: in the body at the start
    now = np.einsum("kij,kj->ki", turns, seen)
    back = np.transpose(turns, (0, 2, 1))
    residual = np.einsum("kij,kj->ki", back, body - now)
    across = -cross_matrix(seen)  # change of F by a small rotation of the attitude
    swept, moved = _swept(arc, turns, bias)
    by_bias = across @ swept
    columns = [by_bias, back / (1.0 + scale)]
    if size > 6:
        columns.append(back * (now / (1.0 + scale))[:, None, :])
    # what is not estimated: nine entries of the gyro's matrix (rows: axis that reads), and a uniform error of the field
    others = [np.einsum("kij,kjl->kil", across, moved), np.broadcast_to(attitude, (len(seen), 3, 3))]
    if arc.moved is not None:
        others.append(attitude @ arc.moved)
    design = np.concatenate([*columns, *others, across], axis=2)
    parts = np.array_split(np.arange(len(seen)), min(NODES, len(seen)))
    first = np.array([one[0] for one in parts])
    count = np.array([len(one) for one in parts], dtype=float)
    mean = np.add.reduceat(design, first, axis=0) / count[:, None, None]
    means = np.add.reduceat(residual, first, axis=0) / count[:, None]
    times = np.add.reduceat(arc.times, first) / count
    through = np.add.reduceat(across, first, axis=0) / count[:, None, None]
    whitened = _whitened(times, count, through, noise, np.concatenate([mean, means[:, :, None]], axis=2))
    wanted, left, own, rest = np.split(whitened, [size, whitened.shape[1] - 4, whitened.shape[1] - 1], axis=1)
    values, vectors = np.linalg.eigh(own.T @ own)
    free = values > FLAT * values[-1]
    basis = own @ (vectors[:, free] / np.sqrt(values[free]))
    wanted, left, rest = (part - basis @ (basis.T @ part) for part in (wanted, left, rest))
    return Equations(
        wanted.T @ wanted, (wanted.T @ rest)[:, 0], wanted.T @ left, float(np.sum(rest**2)),
        np.linalg.norm(residual, axis=1),
    )  # fmt: skip


def _swept(arc: Arc, turns: Array, bias: Array) -> tuple[Array, Array]:
    """Return what one unit of bias turns the attitude by, shape (n, 3, 3), and of each entry of the matrix, (n, 3, 9).

    In the axes of the start of the arc. A bias taken off turns the body the other way, and so on along the arc; between
    readings of the field the turns in between count as those at the later one.
    """
    steps = np.diff(arc.times, prepend=0.0)
    back = np.transpose(turns, (0, 2, 1))
    swept = np.cumsum(back * steps[:, None, None], axis=0)
    rate = arc.rates[np.minimum(arc.at, len(arc.rates) - 1)] - bias
    # d(reading)_i = sum_j e_ij w_j: a reading that is too large turns the body too far, against the bias
    entries = (back[:, :, :, None] * rate[:, None, None, :]).reshape(len(rate), 3, 9)
    return swept, np.cumsum(entries * steps[:, None, None], axis=0)


def _attitude(body: Array, reference: Array) -> Array:
    """Return the rotation from reference to body that fits best (Wahba's problem, by singular values)."""
    left, _, right = np.linalg.svd(body.T @ reference)
    sign = math.copysign(1.0, float(np.linalg.det(left) * np.linalg.det(right)))
    return np.asarray(left @ np.diag([1.0, 1.0, sign]) @ right)


def _whitened(times: Array, count: Array, through: Array, noise: Noise, columns: Array) -> Array:
    """Return columns whose noise is white and of size 1, shape (3 nodes, columns)."""
    n = len(times)
    walk = noise.walk**2 * np.minimum.outer(times, times)
    stacked = through.reshape(3 * n, 3)
    covariance = (stacked @ stacked.T) * np.repeat(np.repeat(walk, 3, axis=0), 3, axis=1)
    covariance[np.diag_indices(3 * n)] += np.repeat(noise.field**2 / count, 3)
    factor = np.linalg.cholesky(covariance)
    from scipy.linalg import solve_triangular  # noqa: PLC0415 - starts slowly

    return np.asarray(solve_triangular(factor, columns.reshape(3 * n, -1), lower=True))

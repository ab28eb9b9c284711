r"""Shift of one axis over flights: level, drift and change with temperature, and the scatter of launches.

Flip i of flight f, of age t and at temperature T, is off the ground model by ::

    y_fi = level + drift (t - t_0) + slope (T - T_0) + launch_f + noise_fi         noise_fi: u_fi, known

What launch and turn-on shift is a random component: drawn anew for each flight (``fresh``, covariance tau^2 I), or
added to what earlier launches left (``kept``, tau^2 min(f, g)). tau^2 is that at which the generalised mean square of
the flights is one (Paule and Mandel [1]_), and 0 where they scatter less. Flips of one flight that differ by more than
their uncertainties explain widen these.

Intervals are those of Student's t with as many degrees of freedom as flights are left over [2]_: tau is known no
better. Where launches are about as small as what flips do not know, tau may be found 0 by chance, and these are too
short. The generalised sum of squares is chi-squared of as many degrees of freedom, whatever tau is; the tau at which it
is each quantile of that is what tau may be (its confidence distribution [3]_). A figure is off by a mixture of normals,
with the variance that it has at each of these: where 95 % of the mixture is wider than Student's t, the uncertainty is
as much larger, at the same degrees of freedom. Of launches that show, the mixture is Student's t.

The level of a flight that is yet to fly is predicted with what the launches before left (universal kriging).

References
----------
.. [1] R. C. Paule and J. Mandel, J. Res. Natl. Bur. Stand. 87 (1982) 377.
.. [2] G. Knapp and J. Hartung, Stat. Med. 22 (2003) 2693.
.. [3] W. Viechtbauer, Stat. Med. 26 (2007) 37: the Q-profile, here at all its levels.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy import special

from ...core.estimate import Array

SURE = 0.01  # probability of flips of one flight that differ so much, below which their uncertainties are widened
DOUBLINGS, HALVINGS = 200, 60
NODES = 24  # of Gauss and Legendre, over the probability of tau
_AT, _SHARE = np.polynomial.legendre.leggauss(NODES)
LEVEL, WEIGHT = 0.5 * (1.0 + _AT), 0.5 * _SHARE
P = 0.975


@dataclass(frozen=True, eq=False)
class Fit:
    """Of one axis: N flips of F flights, p coefficients."""

    design: Array  # shape (N, p)
    group: NDArray[np.int64]  # shape (N,): flight of each flip, in order of time
    shift: Array  # shape (N,): measured less ground [m/s^2]
    u: Array  # shape (N,): of each flip, widened [m/s^2]
    tau: float  # Standard deviation of launches [m/s^2]; 0 where not known
    may_be: Array  # shape (NODES,): what it may be, at the nodes of probability; none where not known or stated
    dof: float  # Flights left over; 0 where none are, infinite where tau is stated
    kept: bool
    widened: float  # By how much uncertainties of flips were widened
    p_value: float  # Probability of flips of one flight that differ so much; 1 where none are repeated
    mean_square: float  # Of the flights, with launches left out: 1 where noise alone explains them; NaN without dof

    @property
    def coefficients(self) -> Array:
        """Level, drift, slope: those that there are [SI]."""
        return np.asarray(self.weights @ self.shift)

    @property
    def weights(self) -> Array:
        """Coefficients from shifts, shape (p, N)."""
        return np.asarray(self._best(np.eye(self.design.shape[1]), ahead=False)[0][0])

    @property
    def covariance(self) -> Array:
        """Of noise and launches, shape (N, N)."""
        return np.asarray(self._covariances[0])

    @property
    def flights(self) -> int:
        """Number of flights."""
        return int(self.group.max()) + 1

    @cached_property
    def _variances(self) -> Array:
        """Of launches: at tau, and at all that it may be; shape (1 + nodes,)."""
        return np.append(self.tau, self.may_be) ** 2

    @cached_property
    def _covariances(self) -> Array:
        pattern = _pattern(self.flights, self.kept)[np.ix_(self.group, self.group)]
        return np.asarray(np.diag(self.u**2) + self._variances[:, None, None] * pattern)

    def _best(self, rows: Array, ahead: bool) -> tuple[Array, Array]:
        """Return weights and covariances of `predicted` at each tau, shapes (1 + nodes, m, N) and (1 + nodes, m, m)."""
        size = np.abs(self.design).max(axis=0)
        before = np.zeros((len(self._variances), len(self.group), 1))
        if ahead and self.kept:
            before[..., 0] = self._variances[:, None] * self.group
        solved = np.linalg.solve(self._covariances, np.concatenate(
            [np.broadcast_to(self.design / size, (len(before), *self.design.shape)), before], axis=2))  # fmt: skip
        inside, left = solved[..., :-1], solved[..., -1]
        own = np.linalg.inv((self.design / size).T @ inside)
        gap = np.repeat((rows / size)[None], len(before), axis=0)
        gap[:, 0] -= (before.transpose(0, 2, 1) @ inside)[:, 0]
        weights = gap @ own @ inside.transpose(0, 2, 1)
        weights[:, 0] += left
        covariance = gap @ own @ gap.transpose(0, 2, 1)
        if ahead and self.kept:
            covariance[:, 0, 0] += self._variances * (self.flights - 1) - np.sum(before[..., 0] * left, axis=1)
        return weights, 0.5 * (covariance + covariance.transpose(0, 2, 1))

    def predicted(self, rows: Array, ahead: bool = True) -> tuple[Array, Array]:
        """Return weights of the flips for points of a flight to come, and their covariance without its own launch.

        Parameters
        ----------
        rows : ndarray, shape (m, p)
            Of a design; the first has the launches before in it, the others are changes of it.
        ahead : bool
            Whether the launches before are in the first; else it is of the coefficients alone.

        Returns
        -------
        tuple of ndarray, shapes (m, N) and (m, m)
        """
        weights, covariance = self._best(rows, ahead)
        wider = self._wider(covariance.diagonal(axis1=1, axis2=2))
        return weights[0], covariance[0] * np.outer(wider, wider)

    def launch(self, row: Array) -> float:
        """Return the variance that its own launch adds to a point of a flight to come; row of shape (p,)."""
        alone = self._best(row[None], ahead=True)[1][:, 0]
        each = np.column_stack([alone, alone[:, 0] + self._variances])
        without, whole = each[0] * self._wider(each) ** 2
        return float(whole - without)

    def _wider(self, variances: Array) -> Array:
        """Return by how much uncertainties are larger than those at tau, from variances, shape (1 + nodes, m)."""
        u = np.sqrt(np.where(variances > 0.0, variances, 1.0))  # of what is not estimated the row is zero
        if not len(self.may_be):
            return np.ones(u.shape[1])
        return np.asarray(np.maximum(_half(u[1:]) / (special.stdtrit(self.dof, P) * u[0]), 1.0))


def fitted(
    design: Array, shift: Array, u: Array, group: NDArray[np.int64], between: int, kept: bool, stated: float | None
) -> Fit:
    """Return the fit of shifts.

    Parameters
    ----------
    design : ndarray, shape (N, p)
        Level first.
    shift, u : ndarray, shape (N,)
        [m/s^2]
    group : ndarray, shape (N,)
        Flight of each, counted from 0 in order of time.
    between : int
        Coefficients that only differences between flights tell.
    kept : bool
        Whether launches add up.
    stated : float or None
        Standard deviation of launches that is known from elsewhere [m/s^2].
    """
    widened, p_value = _within(shift, u, group, design)
    u = u * widened
    flights = int(group.max()) + 1
    free = max(flights - between, 0)
    tau, may_be, mean_square = stated or 0.0, np.empty(0), math.nan
    if free > 0:
        square = _square(design, shift, u, group, _pattern(flights, kept))
        mean_square = float(square(np.zeros(1))[0]) / free
        if stated is None:
            wanted = np.append(free, special.chdtri(free, LEVEL))
            tau, *others = np.sqrt(_roots(square, wanted, float(np.min(u)) ** 2)).tolist()
            may_be = np.array(others)
    dof = math.inf if stated is not None else float(free)
    return Fit(design, group, shift, u, tau, may_be, dof, kept, widened, p_value, mean_square)


def _pattern(flights: int, kept: bool) -> Array:
    at = np.arange(flights)
    return np.asarray(np.minimum.outer(at, at), dtype=float) if kept else np.eye(flights)


def _square(
    design: Array, shift: Array, u: Array, group: NDArray[np.int64], pattern: Array
) -> Callable[[Array], Array]:
    """Return the generalised sum of squares of the flights by the variance of launches, shape (n,) of shape (n,).

    In the space in which noise and launches of the flights are both diagonal; what flips of one flight differ by tells
    coefficients, too, whatever launches do.
    """
    design = design / np.abs(design).max(axis=0)
    total = np.bincount(group, weights=1.0 / u**2)
    mean = np.zeros((len(total), len(group)))
    mean[group, np.arange(len(group))] = 1.0 / u**2 / total[group]
    sizes, turn = np.linalg.eigh(pattern * np.sqrt(np.outer(total, total)))
    sizes = np.maximum(sizes, 0.0)
    rows, values = (turn.T @ (np.sqrt(total) * (mean @ each).T).T for each in (design, shift))
    inside, apart = (((each - (mean @ each)[group]).T / u).T for each in (design, shift))
    fixed, driven = inside.T @ inside, inside.T @ apart

    def square(variance: Array) -> Array:
        weights = 1.0 / (1.0 + variance[:, None] * sizes)
        normal = np.einsum("fp,nf,fq->npq", rows, weights, rows) + fixed
        found = np.linalg.solve(normal, (weights * values @ rows + driven)[..., None])[..., 0]
        return np.asarray(np.sum(weights * (values - found @ rows.T) ** 2, axis=1))

    return square


def _roots(square: Callable[[Array], Array], wanted: Array, start: float) -> Array:
    """Return the variances at which a falling sum of squares is as wanted; 0 where it is smaller throughout."""
    low, high = np.zeros(len(wanted)), np.full(len(wanted), start)
    for _ in range(DOUBLINGS):
        over = square(high) > wanted
        if not over.any():
            break
        low, high = np.where(over, high, low), np.where(over, 2.0 * high, high)
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        over = square(middle) > wanted
        low, high = np.where(over, middle, low), np.where(over, high, middle)
    return np.where(square(np.zeros(len(wanted))) <= wanted, 0.0, high)


def _half(deviations: Array) -> Array:
    """Return half the 95 % interval of mixtures of normals, shape (m,), from deviations at the nodes, (nodes, m)."""
    low, high = (float(special.ndtri(P)) * end for end in (deviations.min(axis=0), deviations.max(axis=0)))
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        over = WEIGHT @ special.ndtr(middle / deviations) > P
        low, high = np.where(over, low, middle), np.where(over, middle, high)
    return np.asarray(high)


def _within(shift: Array, u: Array, group: NDArray[np.int64], design: Array) -> tuple[float, float]:
    """Return by how much flips of one flight differ beyond their uncertainties, and its probability."""
    flights = int(group.max()) + 1
    columns = np.column_stack([np.eye(flights)[group], design[:, 1:]]) / u[:, None]
    found, _, rank, _ = np.linalg.lstsq(columns, shift / u, rcond=1e-10)
    free = len(shift) - int(rank)
    if free < 1:
        return 1.0, 1.0
    total = float(np.sum((shift / u - columns @ found) ** 2))
    p_value = float(special.gammaincc(0.5 * free, 0.5 * total))
    return (math.sqrt(max(total / free, 1.0)) if p_value < SURE else 1.0), p_value

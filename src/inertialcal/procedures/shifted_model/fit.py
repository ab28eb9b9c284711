r"""Shift of one axis over flights: level, drift and change with temperature, and the scatter of launches.

Flip i of flight f, of age t and at temperature T, is off the ground model by ::

    y_fi = level + drift (t - t_0) + slope (T - T_0) + launch_f + noise_fi         noise_fi: u_fi, known

What launch and turn-on shift is a random component: drawn anew for each flight (``fresh``, covariance tau^2 I), or
added to what earlier launches left (``kept``, tau^2 min(f, g)). tau^2 is that at which the generalised mean square of
the flights is one (Paule and Mandel [1]_), and 0 where they scatter less. Intervals are those of Student's t with as
many degrees of freedom as flights are left over [2]_: tau is known no better. Flips of one flight that differ by more
than their uncertainties explain widen these.

The level of a flight that is yet to fly is predicted with what the launches before left (universal kriging).

References
----------
.. [1] R. C. Paule and J. Mandel, J. Res. Natl. Bur. Stand. 87 (1982) 377.
.. [2] G. Knapp and J. Hartung, Stat. Med. 22 (2003) 2693.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import special

from ...core.estimate import Array

SURE = 0.01  # probability of flips of one flight that differ so much, below which their uncertainties are widened
DOUBLINGS, HALVINGS = 200, 200


@dataclass(frozen=True, eq=False)
class Fit:
    """Of one axis: N flips of F flights, p coefficients."""

    design: Array  # shape (N, p)
    group: NDArray[np.int64]  # shape (N,): flight of each flip, in order of time
    shift: Array  # shape (N,): measured less ground [m/s^2]
    covariance: Array  # shape (N, N): of noise and launches
    weights: Array  # shape (p, N): coefficients from shifts
    tau: float  # Standard deviation of launches [m/s^2]; 0 where not known
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
    def spread(self) -> Array:
        """Their covariance."""
        return np.asarray(self.weights @ self.covariance @ self.weights.T)

    @property
    def flights(self) -> int:
        """Number of flights."""
        return int(self.group.max()) + 1

    def launches(self) -> tuple[Array, float]:
        """Return the covariance of a flight to come with each flip, and its variance less that of its own launch."""
        before = self.tau**2 * self.group if self.kept else np.zeros(len(self.group))
        return before.astype(float), (self.tau**2 * (self.flights - 1) if self.kept else 0.0)

    def predicted(self, rows: Array) -> tuple[Array, Array]:
        """Return weights of the flips for points of a flight to come, and their covariance without its own launch.

        Parameters
        ----------
        rows : ndarray, shape (m, p)
            Of a design; the first has the launches before in it, the others are changes of it.

        Returns
        -------
        tuple of ndarray, shapes (m, N) and (m, m)
        """
        inverse = np.linalg.inv(self.covariance)
        before, own = self.launches()
        weights = rows @ self.weights
        weights[0] += before @ inverse - (before @ inverse @ self.design) @ self.weights
        covariance = weights @ self.covariance @ weights.T
        common = weights @ before
        covariance[0] -= common
        covariance[:, 0] -= common
        covariance[0, 0] += own
        return weights, 0.5 * (covariance + covariance.T)


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
    flights = int(group.max()) + 1
    widened, p_value = _within(shift, u, group, design)
    u = u * widened
    pattern = np.minimum.outer(np.arange(flights), np.arange(flights)).astype(float) if kept else np.eye(flights)
    pattern = pattern[np.ix_(group, group)]
    mean = np.zeros((flights, len(group)))
    mean[group, np.arange(len(group))] = 1.0 / u**2
    mean /= mean.sum(axis=1, keepdims=True)
    free = flights - between

    def square(variance: float) -> float:
        covariance = np.diag(u**2) + variance * pattern
        left = mean @ (shift - design @ (_weights(design, covariance) @ shift))
        return float(left @ np.linalg.solve(mean @ covariance @ mean.T, left))

    variance, mean_square = 0.0, math.nan
    if free > 0:
        mean_square = square(0.0) / free
    if stated is not None:
        variance = stated**2
    elif free > 0:
        variance = _root(square, float(free), float(np.min(u)) ** 2)
    covariance = np.diag(u**2) + variance * pattern
    dof = math.inf if stated is not None else float(max(free, 0))
    return Fit(design, group, shift, covariance, _weights(design, covariance), math.sqrt(variance), dof, kept, widened,
               p_value, mean_square)  # fmt: skip


def _weights(design: Array, covariance: Array) -> Array:
    inside = np.linalg.solve(covariance, design)
    return np.asarray(np.linalg.solve(design.T @ inside, inside.T))


def _root(square: Callable[[float], float], wanted: float, start: float) -> float:
    """Return the variance at which a falling sum of squares is as wanted; 0 where it is smaller throughout."""
    if square(0.0) <= wanted:
        return 0.0
    low, high = 0.0, start
    for _ in range(DOUBLINGS):
        if square(high) <= wanted:
            break
        low, high = high, 2.0 * high
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        if middle in (low, high):
            break
        low, high = (middle, high) if square(middle) > wanted else (low, middle)
    return high


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

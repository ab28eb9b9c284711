"""|f| = g: errors of length of positions of unknown orientation, their derivatives, and Gauss-Newton on them.

The parameters are scaled to one size: the entries of T, lower triangular, times gravity, and b, all [m/s^2]; formulas
in ``accelerometer``.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ....core.axes import AXES
from ....core.errors import DataError
from ....core.estimate import Array
from .linear_sensor import BIAS, MATRIX

LOWER = ((0, 0), (1, 0), (1, 1), (2, 0), (2, 1), (2, 2))
ROW, COLUMN = np.array(LOWER).T
NAMES = tuple(MATRIX[3 * i + j] for i, j in LOWER) + BIAS  # of the parameters of T and b, told in the words of A
COARSE = 0.02  # singular value over the largest, below which the first steps leave a combination alone
PLANE = 0.06  # spread of the positions across a plane [gravities], below which they lie in it
STEPS, HALVINGS = 60, 12
SETTLED = 1e-9  # of gravity

Flags = NDArray[np.bool_]


def check_plane(r: Array, g: float) -> None:
    """Refuse positions that all lie in one plane: what is across it nobody sees."""
    middle = r - r.mean(axis=0)
    spread, axes = np.linalg.svd(middle / g, full_matrices=False)[1:]
    if spread[-1] < PLANE * np.sqrt(len(r)):
        across = ", ".join(
            f"{value:+.2f} {axis}" for value, axis in zip(axes[-1], AXES, strict=True) if abs(value) > 0.1
        )
        raise DataError(
            f"all positions lie in one plane, across {across}",
            why="bias, scale factor and misalignment across it change no reading",
            do="Lay the unit so that each of its axes points up, and down, at least once",
            code="one_plane",
        )


def nominal(g: float) -> Array:
    """Return T = I and b = 0, in scaled parameters: entries of T times g."""
    return np.concatenate([[g * (i == j) for i, j in LOWER], np.zeros(3)])


def parts(theta: Array, g: float) -> tuple[Array, Array]:
    """Return T and b of scaled parameters."""
    T = np.zeros((3, 3))
    T[ROW, COLUMN] = theta[:6] / g
    return T, theta[6:]


def lengths(theta: Array, r: Array, g: float) -> tuple[Array, Array, Array]:
    """Return errors of length (m,), derivatives by the scaled parameters (m, 9), unit vectors (m, 3)."""
    T, b = parts(theta, g)
    d = r - b
    x = d @ T.T
    length = np.sqrt(np.einsum("mi,mi->m", x, x))
    u = x / length[:, None]
    jacobian = np.empty((len(r), 9))
    jacobian[:, :6] = u[:, ROW] * d[:, COLUMN] / g
    jacobian[:, 6:] = -(u @ T)
    return length - g, jacobian, u


def converged(r: Array, g: float, root: Array, theta: Array, cut: float) -> Array:
    """Return where damped Gauss-Newton with weights root^2 ends; what is not told stays as it starts."""
    e, jacobian, _ = lengths(theta, r, g)
    cost = float(np.sum((root * e) ** 2))
    for _ in range(STEPS):
        step = np.linalg.lstsq(jacobian * root[:, None], -root * e, rcond=cut)[0]
        for _ in range(HALVINGS):
            trial = theta + step
            e_trial, jacobian_trial, _ = lengths(trial, r, g)
            new = float(np.sum((root * e_trial) ** 2))
            if new <= cost:
                break
            step = 0.5 * step
        else:
            break
        theta, e, jacobian, cost = trial, e_trial, jacobian_trial, new
        if np.max(np.abs(step)) <= SETTLED * g:
            break
    return np.asarray(theta)


def variances(theta: Array, u: Array, inside: Array, g: float) -> Array:
    """Return the variance of each length from the noise inside its position, shape (m,)."""
    T = parts(theta, g)[0]
    return np.asarray(np.sum((u @ T) ** 2 * inside, axis=1))


def forward(theta: Array, g: float) -> tuple[Array, Array]:
    """Return A = T^-1 and b as twelve values, and their derivatives by the scaled parameters, shape (12, 9)."""
    T, b = parts(theta, g)
    A = np.linalg.inv(T)
    derivative = np.zeros((12, 9))
    for column, (i, j) in enumerate(LOWER):
        derivative[:9, column] = -np.outer(A[:, i], A[j]).ravel() / g
    derivative[9:, 6:] = np.eye(3)
    return np.concatenate([A.ravel(), b]), derivative


def told_forward(told: Flags) -> Flags:
    """Return which of the twelve are told, where those of T and b are."""
    found = np.zeros(12, dtype=bool)
    for column, (i, j) in enumerate(LOWER):
        found[3 * i + j] = told[column]
    found[9:] = told[6:]
    return found

"""Kernels: attitude from samples of the rate through many rotations at once.

A vector fixed in space, seen from the body, obeys ``u' = -w x u``. Over a step the body turns by::

    phi = h (w_0 + w_1) / 2 + h^2 / 12 (w_0 x w_1)

for a rate that is linear in time (Magnus expansion, fourth order).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ....core.estimate import Array
from ....statistics._kernels import compiled

Rate = tuple[float, float, float]
SERIES = 0.02  # square of the angle [rad^2] below which five terms of a series are exact to rounding


@compiled
def through(
    z: Array, f: Array, h: Array, first: NDArray[np.int64], W: Array, bias: Array, G: Array, signal: Array,
    end: Array, integrals: Array,
) -> None:  # fmt: skip
    """Integrate rotations k = 0 .. len(first) - 2, samples first[k] to first[k + 1] - 1, by each of some gyros j.

    Parameters
    ----------
    z, f : ndarray, shape (n, 3)
        What the gyros read, and the specific force.
    h : ndarray, shape (n,)
        Time to the next sample [s]; that of the last one of a rotation is not used.
    W, bias, G : ndarray, shapes (j, 3, 3), (j, 3), (j, 3, 3)
        The rate is ``W (z - bias - G f)``.
    signal : ndarray, shape (n, m)
        Weighed in the integrals.
    end : ndarray, shape (j, k, 3, 3)
        Out: takes vectors from the body at the start to the body at the end.
    integrals : ndarray, shape (j, k, m, 3, 3)
        Out: over time, by trapezoids, of the matrix that takes vectors from the start to a sample times the signal.
    """
    for j in range(len(W)):
        for k in range(len(first) - 1):
            U, total = end[j, k], integrals[j, k]
            total[:] = 0.0
            U[:] = 0.0
            U[0, 0] = U[1, 1] = U[2, 2] = 1.0
            before = 0.0
            for n in range(first[k], first[k + 1]):
                last = n + 1 == first[k + 1]
                step = 0.0 if last else h[n]
                weight = 0.5 * (before + step)
                _add(weight, U, signal[n], total)
                before = step
                if n == first[k]:
                    now = _rate(z[n], f[n], W[j], bias[j], G[j])
                if not last:
                    then = _rate(z[n + 1], f[n + 1], W[j], bias[j], G[j])
                    _turn_back(now, then, step, U)
                    now = then


@compiled
def _add(weight: float, U: Array, signal: Array, total: Array) -> None:
    """Add a sample to the integrals."""
    for m in range(len(signal)):
        size = weight * signal[m]
        for i in range(3):
            for c in range(3):
                total[m, i, c] += size * U[i, c]


@compiled
def _rate(z: Array, f: Array, W: Array, bias: Array, G: Array) -> Rate:
    """Return the rate of a reading."""
    x = z[0] - bias[0] - (G[0, 0] * f[0] + G[0, 1] * f[1] + G[0, 2] * f[2])
    y = z[1] - bias[1] - (G[1, 0] * f[0] + G[1, 1] * f[1] + G[1, 2] * f[2])
    v = z[2] - bias[2] - (G[2, 0] * f[0] + G[2, 1] * f[1] + G[2, 2] * f[2])
    return (
        W[0, 0] * x + W[0, 1] * y + W[0, 2] * v,
        W[1, 0] * x + W[1, 1] * y + W[1, 2] * v,
        W[2, 0] * x + W[2, 1] * y + W[2, 2] * v,
    )


@compiled
def fill_sums(
    z: Array, f: Array, h: Array, first: NDArray[np.int64], total: Array, force: Array, time: Array, squares: Array
) -> None:
    """Fill the integrals of z, f (k, 3) and one (k,) over each rotation, by trapezoids, and the sums of h^2 (k,)."""
    for k in range(len(first) - 1):
        total[k], force[k], time[k], squares[k] = 0.0, 0.0, 0.0, 0.0
        before = 0.0
        for n in range(first[k], first[k + 1]):
            step = 0.0 if n + 1 == first[k + 1] else h[n]
            weight = 0.5 * (before + step)
            for i in range(3):
                total[k, i] += weight * z[n, i]
                force[k, i] += weight * f[n, i]
            time[k] += weight
            squares[k] += h[n] * h[n]
            before = step


@compiled
def join(
    C: Array, up: Array, before: NDArray[np.int64], after: NDArray[np.int64], axes: Array, chain: NDArray[np.int64]
) -> None:
    """Carry axes (m, 2, 3) across the vertical, and the number of their chain (m,), through rotations in turn."""
    first = np.empty(3)
    for k in range(len(before)):
        a, u = axes[before[k], 0], up[after[k]]
        along = 0.0
        for i in range(3):
            first[i] = C[k, i, 0] * a[0] + C[k, i, 1] * a[1] + C[k, i, 2] * a[2]
            along += first[i] * u[i]
        size = 0.0
        for i in range(3):
            first[i] -= along * u[i]
            size += first[i] * first[i]
        found = axes[after[k]]
        for i in range(3):
            found[0, i] = first[i] / np.sqrt(size)
        for i in range(3):
            i1, i2 = (i + 1) % 3, (i + 2) % 3
            found[1, i] = u[i1] * found[0, i2] - u[i2] * found[0, i1]
        chain[after[k]] = chain[before[k]]


@compiled
def _turn_back(w0: Rate, w1: Rate, h: float, U: Array) -> None:
    """Multiply U by the matrix exponential of minus the cross product with phi."""
    c = h * h / 12.0
    x = 0.5 * h * (w0[0] + w1[0]) + c * (w0[1] * w1[2] - w0[2] * w1[1])
    y = 0.5 * h * (w0[1] + w1[1]) + c * (w0[2] * w1[0] - w0[0] * w1[2])
    z = 0.5 * h * (w0[2] + w1[2]) + c * (w0[0] * w1[1] - w0[1] * w1[0])
    s = x * x + y * y + z * z
    if s < SERIES:
        a = 1.0 - s / 6.0 * (1.0 - s / 20.0 * (1.0 - s / 42.0 * (1.0 - s / 72.0)))
        b = 0.5 - s / 24.0 * (1.0 - s / 30.0 * (1.0 - s / 56.0 * (1.0 - s / 90.0)))
    else:
        angle = np.sqrt(s)
        a, b = np.sin(angle) / angle, (1.0 - np.cos(angle)) / s
    xx, xy, xz = 1.0 - b * (y * y + z * z), a * z + b * x * y, -a * y + b * x * z
    yx, yy, yz = -a * z + b * x * y, 1.0 - b * (x * x + z * z), a * x + b * y * z
    zx, zy, zz = a * y + b * x * z, -a * x + b * y * z, 1.0 - b * (x * x + y * y)
    for j in range(3):
        p, q, r = U[0, j], U[1, j], U[2, j]
        U[0, j] = xx * p + xy * q + xz * r
        U[1, j] = yx * p + yy * q + yz * r
        U[2, j] = zx * p + zy * q + zz * r

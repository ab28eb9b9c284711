"""Kernel: attitude from gyro samples through many rotations at once, with what it owes to each parameter.

A vector fixed in space, seen from the body, obeys ``u' = -w x u``. Over a step the body turns by::

    phi = h (w_0 + w_1) / 2 + h^2 / 12 (w_0 x w_1)

for a rate that is linear in time (Magnus expansion, fourth order). A small error dw(t) of the rate turns the end
attitude by the integral of C(end, t) dw(t), so that the derivatives by all entries of a matrix are three integrals.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ...core.estimate import Array


@njit(cache=True)
def through(
    z: Array, f: Array, h: Array, first: NDArray[np.int64], W: Array, C: Array, by_z: Array, by_f: Array, by_1: Array
) -> None:
    """Integrate rotations k = 0 .. len(first) - 2, samples first[k] to first[k + 1] - 1.

    ``z`` (n, 3): gyro readings less bias and g-sensitivity, ``f`` (n, 3): specific force, ``h`` (n): time to the next
    sample [s] (that of the last is not used), ``W`` (3, 3): rate is W z. Out: ``C`` (k, 3, 3) takes vectors from the
    body at the start to the body at the end, ``by_z``, ``by_f`` (k, 3, 9) and ``by_1`` (k, 3, 3): integrals of
    C(end, t) times z, f and one; column 3 j + l of the first two is the part of input axis j by component l.
    """
    E = np.empty((3, 3))
    w0, w1, phi = np.empty(3), np.empty(3), np.empty(3)
    for k in range(len(first) - 1):
        for i in range(3):
            for j in range(3):
                C[k, i, j] = 1.0 if i == j else 0.0
                by_1[k, i, j] = 0.0
            for j in range(9):
                by_z[k, i, j] = 0.0
                by_f[k, i, j] = 0.0
        for n in range(first[k], first[k + 1] - 1):
            step = h[n]
            for i in range(3):
                w0[i] = W[i, 0] * z[n, 0] + W[i, 1] * z[n, 1] + W[i, 2] * z[n, 2]
                w1[i] = W[i, 0] * z[n + 1, 0] + W[i, 1] * z[n + 1, 1] + W[i, 2] * z[n + 1, 2]
            c = step * step / 12.0
            phi[0] = 0.5 * step * (w0[0] + w1[0]) + c * (w0[1] * w1[2] - w0[2] * w1[1])
            phi[1] = 0.5 * step * (w0[1] + w1[1]) + c * (w0[2] * w1[0] - w0[0] * w1[2])
            phi[2] = 0.5 * step * (w0[2] + w1[2]) + c * (w0[0] * w1[1] - w0[1] * w1[0])
            _turned_back(phi, E)
            _add(z, n, 0.5 * step, by_z[k])
            _add(f, n, 0.5 * step, by_f[k])
            for i in range(3):
                by_1[k, i, i] += 0.5 * step
            _turn(E, C[k])
            _turn(E, by_z[k])
            _turn(E, by_f[k])
            _turn(E, by_1[k])
            _add(z, n + 1, 0.5 * step, by_z[k])
            _add(f, n + 1, 0.5 * step, by_f[k])
            for i in range(3):
                by_1[k, i, i] += 0.5 * step


@njit(cache=True)
def _turned_back(phi: Array, E: Array) -> None:
    """Matrix exponential of minus the cross product with phi."""
    x, y, z = phi[0], phi[1], phi[2]
    square = x * x + y * y + z * z
    if square < 1e-8:
        a, b = 1.0 - square / 6.0, 0.5 - square / 24.0
    else:
        angle = np.sqrt(square)
        a, b = np.sin(angle) / angle, (1.0 - np.cos(angle)) / square
    E[0, 0], E[0, 1], E[0, 2] = 1.0 - b * (y * y + z * z), a * z + b * x * y, -a * y + b * x * z
    E[1, 0], E[1, 1], E[1, 2] = -a * z + b * x * y, 1.0 - b * (x * x + z * z), a * x + b * y * z
    E[2, 0], E[2, 1], E[2, 2] = a * y + b * x * z, -a * x + b * y * z, 1.0 - b * (x * x + y * y)


@njit(cache=True)
def _add(x: Array, n: int, weight: float, out: Array) -> None:
    for j in range(3):
        for m in range(3):
            out[j, 3 * j + m] += weight * x[n, m]


@njit(cache=True)
def _turn(E: Array, out: Array) -> None:
    for j in range(out.shape[1]):
        a, b, c = out[0, j], out[1, j], out[2, j]
        for i in range(3):
            out[i, j] = E[i, 0] * a + E[i, 1] * b + E[i, 2] * c

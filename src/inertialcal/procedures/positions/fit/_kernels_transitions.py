"""Kernel: attitude from samples of the rate through many rotations at once.

A vector fixed in space, seen from the body, obeys ``u' = -w x u``. Over a step the body turns by::

    phi = h (w_0 + w_1) / 2 + h^2 / 12 (w_0 x w_1)

for a rate that is linear in time (Magnus expansion, fourth order).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ....core.estimate import Array
from ....statistics._kernels import compiled

SERIES = 0.02  # square of the angle [rad^2] below which five terms of a series are exact to rounding


@compiled
def through(w: Array, h: Array, first: NDArray[np.int64], weighted: Array, end: Array) -> None:
    """Integrate rotations k = 0 .. len(first) - 2, samples first[k] to first[k + 1] - 1.

    ``w`` (n, 3): rate, ``h`` (n): time to the next sample [s] (that of the last is not used). Out: ``weighted`` (n, 9):
    the matrix that takes vectors from the body at the start to the body at a sample, row by row, times what the sample
    weighs in an integral over time by trapezoids; ``end`` (k, 3, 3): that matrix for the last sample.
    """
    for k in range(len(first) - 1):
        U = end[k]
        for i in range(3):
            for j in range(3):
                U[i, j] = 1.0 if i == j else 0.0
        before = 0.0
        for n in range(first[k], first[k + 1]):
            last = n + 1 == first[k + 1]
            step = 0.0 if last else h[n]
            for i in range(3):
                for j in range(3):
                    weighted[n, 3 * i + j] = 0.5 * (before + step) * U[i, j]
            before = step
            if not last:
                _turn_back(w[n], w[n + 1], step, U)


@compiled
def _turn_back(w0: Array, w1: Array, h: float, U: Array) -> None:
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

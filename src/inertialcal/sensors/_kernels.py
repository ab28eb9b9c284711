"""Compiled loops: arrays in, preallocated arrays out, no checks."""

from __future__ import annotations

import numba

from ..core.estimate import Array


@numba.njit(cache=True, inline="always")
def _left(reading: float, shift: float, powers: Array, sensor: int, away: float) -> float:
    """Return the reading less the bias at a temperature, by Horner's rule."""
    bent = 0.0
    for j in range(powers.shape[0] - 1, -1, -1):
        bent = (bent + powers[j, sensor]) * away
    return reading - (shift + bent)


@numba.njit(cache=True)
def straight_3(
    matrix: Array, shift: Array, powers: Array, reference: Array, temperature: Array, readings: Array, out: Array
) -> None:
    """Fill ``out`` with matrix (readings - shift - sum_j powers[j - 1] (temperature - reference)^j).

    Three sensors a row; ``temperature`` has one row or n, and one column or three. The same operations in the same
    order as ``equation.offset`` and ``matrices.mixed``: the same bits.
    """
    down = 1 if temperature.shape[0] > 1 else 0
    y, z = (1, 2) if temperature.shape[1] > 1 else (0, 0)
    for n in range(readings.shape[0]):
        t = n * down
        a = _left(readings[n, 0], shift[0], powers, 0, temperature[t, 0] - reference[0])
        b = _left(readings[n, 1], shift[1], powers, 1, temperature[t, y] - reference[1])
        c = _left(readings[n, 2], shift[2], powers, 2, temperature[t, z] - reference[2])
        out[n, 0] = matrix[0, 0] * a + matrix[0, 1] * b + matrix[0, 2] * c
        out[n, 1] = matrix[1, 0] * a + matrix[1, 1] * b + matrix[1, 2] * c
        out[n, 2] = matrix[2, 0] * a + matrix[2, 1] * b + matrix[2, 2] * c

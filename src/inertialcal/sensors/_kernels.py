"""Compiled loops: arrays in, preallocated arrays out, no checks.

The same operations in the same order as ``equation``, ``nonlinearity`` and ``matrices``, row by row. They hold no
lock of the interpreter, and no row looks at another: threads may share the rows, and the bits stay.
"""

from __future__ import annotations

import numba
import numpy as np

from ..core.estimate import Array
from .nonlinearity import DIGITS, STEPS

compiled = numba.njit(cache=True, nogil=True, error_model="numpy")


@compiled
def subtract_bias_3(
    shift: Array, powers: Array, reference: Array, temperature: Array, readings: Array, out: Array
) -> None:
    """Fill ``out`` with readings - shift - sum_j powers[j - 1] (temperature - reference)^j, by Horner's rule.

    Readings (n, 3); ``shift`` has one row or n, ``temperature`` too, and one column or three.
    """
    down, below = (1 if temperature.shape[0] > 1 else 0), (1 if shift.shape[0] > 1 else 0)
    across = 1 if temperature.shape[1] > 1 else 0
    for n in range(readings.shape[0]):
        for i in range(3):
            away = temperature[n * down, i * across] - reference[i]
            bent = 0.0
            for j in range(powers.shape[0] - 1, -1, -1):
                bent = (bent + powers[j, i]) * away
            out[n, i] = readings[n, i] - (shift[n * below, i] + bent)


@compiled
def straighten_3(asymmetry: Array, out: Array) -> None:
    """Undo the asymmetry of three sensors in place, as ``nonlinearity.inverse``; each within -2 to 2."""
    half = 0.5 * asymmetry
    for n in range(out.shape[0]):
        for i in range(3):
            out[n, i] = out[n, i] / (1.0 + half[i] * np.copysign(1.0, out[n, i]))


@compiled
def unbend(curve: Array, out: Array) -> None:
    """Undo the curve of one sensor in place, (n,), as ``nonlinearity.inverse``; NaN beyond the branch.

    ``curve`` is K1', K2, K3, the ends of the rising branch, and the smallest slope where that has no end.
    """
    asymmetry, second, third, low, high, lowest = curve[0], curve[1], curve[2], curve[3], curve[4], curve[5]
    for n in range(out.shape[0]):
        reading = out[n]
        side = -1.0 if reading < 0.0 else 1.0
        near, far = 0.0, low if side < 0.0 else high
        if np.isinf(far):
            far = 2.0 * reading / lowest
        u = far
        if not side * (u * (1.0 + u * (second + u * third)) + 0.5 * asymmetry * abs(u) - reading) >= 0.0:
            out[n] = np.nan
            continue
        first = reading / (1.0 + 0.5 * side * asymmetry)
        if side * first < side * far:
            u = first
        for _ in range(STEPS):
            excess = side * (u * (1.0 + u * (second + u * third)) + 0.5 * asymmetry * abs(u) - reading)
            if excess >= 0.0:
                far = u
            if excess <= 0.0:
                near = u
            slope = 1.0 + 0.5 * asymmetry * np.sign(u) + u * (2.0 * second + 3.0 * third * u)
            new = u - side * excess / slope if slope > 0.0 else np.nan
            if not (side * new >= side * near and side * new <= side * far):
                new = 0.5 * (near + far)
            still = abs(new - u) <= DIGITS * abs(new)
            u = new
            if still:
                break
        out[n] = u


@compiled
def _mix(matrix: Array, row: Array) -> None:
    """Replace a row by matrix times it; an entry of zero takes nothing, not even a missing reading."""
    a, b, c = row[0], row[1], row[2]
    for i in range(3):
        total = 0.0
        if matrix[i, 0] != 0.0:
            total += matrix[i, 0] * a
        if matrix[i, 1] != 0.0:
            total += matrix[i, 1] * b
        if matrix[i, 2] != 0.0:
            total += matrix[i, 2] * c
        row[i] = total


@compiled
def mix_3(matrix: Array, out: Array) -> None:
    """Replace each row of ``out``, (n, 3), by one matrix times it."""
    for n in range(out.shape[0]):
        _mix(matrix, out[n])


@compiled
def _invert(matrix: Array, out: Array) -> bool:
    """Fill ``out`` with the inverse of a matrix by cofactors; return False if it is singular."""
    for i in range(3):
        p, q = (i + 1) % 3, (i + 2) % 3
        out[0, i] = matrix[p, 1] * matrix[q, 2] - matrix[p, 2] * matrix[q, 1]
        out[1, i] = matrix[p, 2] * matrix[q, 0] - matrix[p, 0] * matrix[q, 2]
        out[2, i] = matrix[p, 0] * matrix[q, 1] - matrix[p, 1] * matrix[q, 0]
    determinant = matrix[0, 0] * out[0, 0] + matrix[0, 1] * out[1, 0] + matrix[0, 2] * out[2, 0]
    if determinant == 0.0:
        return False
    for i in range(3):
        for j in range(3):
            out[i, j] = out[i, j] / determinant
    return True


@compiled
def solve_3(matrices: Array, reference: Array, temperature: Array, out: Array) -> bool:
    """Replace each row of ``out``, (n, 3), by M(T)^-1 times it; return False at the first M that is singular.

    ``matrices`` are M_0, M_1, ...; each row of M is taken at the temperature of its sensor, shape (n, 1 or 3).
    """
    across = 1 if temperature.shape[1] > 1 else 0
    last = matrices.shape[0] - 1
    here, inverse = np.empty((3, 3)), np.empty((3, 3))
    for n in range(out.shape[0]):
        for i in range(3):
            away = temperature[n, i * across] - reference[i]
            for j in range(3):
                total = matrices[last, i, j]
                for power in range(last - 1, -1, -1):
                    total = total * away + matrices[power, i, j]
                here[i, j] = total
        if not _invert(here, inverse):
            return False
        _mix(inverse, out[n])
    return True

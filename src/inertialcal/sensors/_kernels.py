"""Compiled loops: arrays in, preallocated arrays out, no checks.

The same operations in the same order as ``equation``, ``nonlinearity`` and ``matrices``, row by row. They hold no
lock of the interpreter, and no row looks at another: threads may share the rows, and the bits stay.

A block of rows is taken through all steps while it lies in the fastest cache, as columns: a loop over one column
without a branch in it becomes vector instructions.
"""

from __future__ import annotations

import numpy as np

from ..core.estimate import Array
from ..statistics._kernels import compiled
from .model.nonlinearity import DIGITS, HALLEY_STEPS, ROUNDING, STEEP, STEPS, UNDONE

BLOCK = 512  # rows


@compiled
def undo_3(
    shift: Array,
    powers: Array,
    reference: Array,
    temperature: Array,
    curves: Array,
    matrices: Array,
    readings: Array,
    out: Array,
) -> bool:
    """Fill ``out``, (n, 3), with the inputs of readings; return False if M is singular at some temperature.

    Parameters
    ----------
    shift : ndarray, shape (1 or n, 3)
        Bias, but for ``powers``, (j, 3), of the temperature away from ``reference``, (3,).
    temperature : ndarray, shape (n, 1 or 3)
        Not looked at where there are no powers and one matrix.
    curves : ndarray, shape (3, 6)
        Of each sensor K1', K2, K3, the ends of the rising branch, the smallest slope where that has no end.
    matrices : ndarray, shape (j, 3, 3)
        M_0, M_1, ...; one alone is M^-1 of all rows.
    """
    away, u = np.empty((3, BLOCK)), np.empty((3, BLOCK))
    spare = np.empty((9, BLOCK))
    regular = True
    for start in range(0, len(out), BLOCK):
        stop = min(start + BLOCK, len(out))
        for i in range(3):
            if len(powers) > 0 or len(matrices) > 1:
                _heat(reference[i], temperature[start:stop, i if temperature.shape[1] > 1 else 0], away[i])
            base = shift[start:stop, i] if len(shift) > 1 else shift[:, i]
            _subtract_bias(base, powers[:, i], away[i], readings[start:stop, i], u[i, : stop - start], spare[0])
            _unbend(curves[i], u[i, : stop - start], spare[0])
        if len(matrices) > 1:
            _matrices_at(matrices, away, spare, stop - start)
            regular = _solve(spare, u, out[start:stop]) and regular
        else:
            _mix(matrices[0], u, out[start:stop])
    return regular


@compiled
def _heat(reference: float, temperature: Array, away: Array) -> None:
    for n in range(len(temperature)):
        away[n] = temperature[n] - reference


@compiled
def _subtract_bias(shift: Array, powers: Array, away: Array, readings: Array, u: Array, spare: Array) -> None:
    """Fill ``u`` with readings - shift - sum_j powers[j - 1] away^j, by Horner's rule; one shift or one a reading."""
    spare[:] = 0.0
    for j in range(len(powers) - 1, -1, -1):
        coefficient = powers[j]
        for n in range(len(u)):
            spare[n] = (spare[n] + coefficient) * away[n]
    if len(shift) == 1:
        same = shift[0]
        for n in range(len(u)):
            u[n] = readings[n] - (same + spare[n])
    else:
        for n in range(len(u)):
            u[n] = readings[n] - (shift[n] + spare[n])


@compiled
def _unbend(curve: Array, u: Array, spare: Array) -> None:
    """Undo the curve of one sensor in place, as ``nonlinearity.inverse``; NaN beyond the branch."""
    if curve[1] != 0.0 or curve[2] != 0.0:
        _approach(curve, u, spare)
        for n in range(len(u)):
            u[n] = _bracket(curve, u[n]) if np.isnan(spare[n]) else spare[n]
    elif curve[0] != 0.0:
        half = 0.5 * curve[0]
        for n in range(len(u)):
            rate = 1.0 - half if u[n] < 0.0 else 1.0 + half
            u[n] = u[n] / (rate if rate > 0.0 else np.nan)


@compiled
def _approach(curve: Array, readings: Array, found: Array) -> None:
    """Fill ``found`` as ``nonlinearity.approached``: NaN where the steps do not settle."""
    second, third, low, high = curve[1], curve[2], curve[3], curve[4]
    up, down = 1.0 + 0.5 * curve[0], 1.0 - 0.5 * curve[0]
    bend_up, bend_down = second / up, second / down
    turn_up, turn_down = 2.0 * bend_up * bend_up - third / up, 2.0 * bend_down * bend_down - third / down
    for n in range(len(readings)):
        reading = readings[n]
        negative = reading < 0.0
        rate = down if negative else up
        bend = bend_down if negative else bend_up
        turn = turn_down if negative else turn_up
        lowest = low if negative else 0.0
        highest = 0.0 if negative else high
        u = reading / rate
        u = u * (1.0 - u * (bend - u * turn))
        slope, curvature, step = 0.0, 0.0, 0.0
        for _ in range(HALLEY_STEPS):
            excess = u * (rate + u * (second + u * third)) - reading
            curvature = second + 3.0 * third * u
            slope = rate + u * (second + curvature)
            step = excess * slope / (slope * slope - excess * curvature)
            u = u - step
        left = abs((curvature * curvature - third * slope) * step * step * step)
        final = (left <= ROUNDING * abs(u * slope * slope)) & (slope >= STEEP) & (u >= lowest) & (u <= highest)
        found[n] = u if final else np.nan


@compiled
def _bracket(curve: Array, reading: float) -> float:
    """Return one input as ``nonlinearity.bracketed``."""
    asymmetry, second, third = curve[0], curve[1], curve[2]
    side = -1.0 if reading < 0.0 else 1.0
    near, far = 0.0, curve[3] if side < 0.0 else curve[4]
    if np.isinf(far):
        far = 2.0 * reading / curve[5]
    u = far
    if not side * (u * (1.0 + u * (second + u * third)) + 0.5 * asymmetry * abs(u) - reading) >= 0.0:
        return np.nan
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
        if abs(new - u) <= DIGITS * abs(new):
            return new
        u = new
    missed = abs(u * (1.0 + u * (second + u * third)) + 0.5 * asymmetry * abs(u) - reading)
    return u if missed <= UNDONE * abs(reading) else np.nan


@compiled
def _mix(matrix: Array, u: Array, out: Array) -> None:
    """Fill the rows of ``out`` with one matrix times each; an entry of zero takes nothing, not even a missing one."""
    a, b, c = matrix[0, 0], matrix[0, 1], matrix[0, 2]
    d, e, f = matrix[1, 0], matrix[1, 1], matrix[1, 2]
    g, h, k = matrix[2, 0], matrix[2, 1], matrix[2, 2]
    for n in range(len(out)):
        x, y, z = u[0, n], u[1, n], u[2, n]
        out[n, 0] = 0.0 + _share(a, x) + _share(b, y) + _share(c, z)
        out[n, 1] = 0.0 + _share(d, x) + _share(e, y) + _share(f, z)
        out[n, 2] = 0.0 + _share(g, x) + _share(h, y) + _share(k, z)


@compiled
def _share(entry: float, u: float) -> float:
    return entry * u if entry != 0.0 else 0.0


@compiled
def _matrices_at(matrices: Array, away: Array, entries: Array, size: int) -> None:
    """Fill the rows of ``entries`` with M_00, M_01, ... of each reading; a row of M has the heat of its sensor."""
    last = len(matrices) - 1
    for i in range(3):
        heat = away[i, :size]
        for j in range(3):
            entry = entries[3 * i + j, :size]
            entry[:] = matrices[last, i, j]
            for power in range(last - 1, -1, -1):
                coefficient = matrices[power, i, j]
                for n in range(size):
                    entry[n] = entry[n] * heat[n] + coefficient


@compiled
def _solve(entries: Array, u: Array, out: Array) -> bool:
    """Fill the rows of ``out`` with the inverse, by cofactors, times each; return False if one is singular."""
    singular = 0
    for n in range(len(out)):
        a, b, c = entries[0, n], entries[1, n], entries[2, n]
        d, e, f = entries[3, n], entries[4, n], entries[5, n]
        g, h, k = entries[6, n], entries[7, n], entries[8, n]
        x, y, z = u[0, n], u[1, n], u[2, n]
        first, second, third = e * k - f * h, f * g - d * k, d * h - e * g
        determinant = a * first + b * second + c * third
        singular += determinant == 0.0
        p, q, r = first / determinant, (h * c - k * b) / determinant, (b * f - c * e) / determinant
        out[n, 0] = 0.0 + _share(p, x) + _share(q, y) + _share(r, z)
        p, q, r = second / determinant, (k * a - g * c) / determinant, (c * d - a * f) / determinant
        out[n, 1] = 0.0 + _share(p, x) + _share(q, y) + _share(r, z)
        p, q, r = third / determinant, (g * b - h * a) / determinant, (a * e - b * d) / determinant
        out[n, 2] = 0.0 + _share(p, x) + _share(q, y) + _share(r, z)
    return singular == 0

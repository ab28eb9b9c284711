"""Kernel: rounds of linearisation about the tilts of positions that a fixture gives (the head of ``fixture``)."""

from __future__ import annotations

import numpy as np

from ....core.estimate import Array
from ....statistics._kernels import reordered
from ._kernels_components import FINE, blocks_of, find_components


@reordered
def lay(
    r: Array, inside: Array, g: float, direction: Array, axes: Array, same: Array, back: Array, stated: Array,
    wanted: Array, assumed: bool, hidden: Array, unknown: float, rounds: int, settled: float, values: Array,
    stretch: Array, design: Array, y: Array, Z: Array, turned: Array, S: Array, seen: Array, between: Array,
    theta: Array, information: Array, inverse: Array, gain: Array, bare: Array, P: Array, coefficients: Array,
) -> tuple[int, float, float]:  # fmt: skip
    """Fill the fit of twelve numbers that is linear about the tilts it finds.

    Parameters
    ----------
    r, inside : ndarray, shape (m, 3)
        Readings, and their variances by the noise inside.
    g : float
        Gravity.
    direction, axes, same : ndarray, shapes (m, 3), (m, 3, 2), (m, m)
        As ``Tilts`` has them.
    back : ndarray, shape (12, p)
        The numbers by the coefficients.
    stated, wanted : ndarray, shape (2,)
        Of the errors of faces and of laying: the variance that is stated, NaN where none is; 1 where it is found.
    assumed : bool
        Whether the scatter between positions is not told.
    hidden : ndarray, shape (3 m,)
        Variances that are then taken for it, at most what the residuals show; empty for a share of these alone.
    unknown : float
        That share.
    rounds, settled : int, float
        Of the linearisation.
    values, stretch : ndarray, shapes (12,), (m,)
        Out: as ``Laid`` has them.
    design, y, Z : ndarray, shapes (3 m, p), (3 m,), (3 m, 2 m)
        Out: the fit, linear about the tilts; ``Z`` is zero before.
    turned : ndarray, shape (2, 3 m, 3 m)
        Out: what tilts of variance one do to the readings, of faces and of laying.
    S, seen, between : ndarray, shapes (m, m), (3 m,), (3 m,)
        Out: covariance of half the squares of the tilts, and the readings by these; variances that are taken for a
        scatter that is not told.
    theta, information, inverse, gain, bare, P, coefficients
        Out: the variances that are found, what is known of them, and the fit with them.

    Returns
    -------
    int, float, float
        What became of it, the logarithm of the restricted likelihood, and the variance of all residuals.
    """
    m, p = len(r), back.shape[1]
    n = 3 * m
    blocks, first = np.empty(n, dtype=np.int64), np.empty(m + 1, dtype=np.int64)
    first = first[: blocks_of(same, blocks, first) + 1]
    place = np.empty(n, dtype=np.int64)
    for i in range(n):
        place[i] = i // 3
    usual = np.zeros(12)
    for i in range(3):
        usual[4 * i] = 1.0
    values[:] = usual
    stretch[:] = 1.0
    tilt, spread = np.zeros((m, 2)), np.zeros((2 * m, 2 * m))
    lever, up = np.zeros((m, 3, 2)), np.empty(3)
    fixed, pull, weighted = np.zeros((n, n)), np.empty(n), np.empty((n, p))
    found = (0 if assumed else 1) + int(wanted[0] + wanted[1])
    patterns, start = np.zeros((found, n, n)), np.full(found, np.nan)
    most, likely, state = 0.0, np.nan, FINE
    for number in range(rounds):
        A = values[:9].copy().reshape(3, 3)
        for k in range(m):
            for i in range(3):
                up[i] = direction[k, i] * stretch[k] + axes[k, i, 0] * tilt[k, 0] + axes[k, i, 1] * tilt[k, 1]
            for i in range(3):
                row = 3 * k + i
                whole, level = 0.0, 0.0
                for a in range(2):
                    one = 0.0
                    for j in range(3):
                        one += g * A[i, j] * (axes[k, j, a] - direction[k, j] * tilt[k, a])
                    lever[k, i, a] = Z[row, 2 * k + a] = one
                    whole += one * tilt[k, a]
                for j in range(3):
                    level += g * direction[k, j] * A[i, j]
                seen[row] = level
                y[row] = r[k, i] - g * up[i] + whole
                for h in range(p):
                    one = back[9 + i, h]
                    for j in range(3):
                        one += g * up[j] * back[3 * i + j, h]
                    design[row, h] = one
        for k in range(m):
            for h in range(m):
                for i in range(3):
                    for j in range(3):
                        one = lever[k, i, 0] * lever[h, j, 0] + lever[k, i, 1] * lever[h, j, 1]
                        turned[0, 3 * k + i, 3 * h + j] = same[k, h] * one
                        turned[1, 3 * k + i, 3 * h + j] = one if k == h else 0.0
        if assumed and number == 0:
            most = _left_over(design, y)
        shared = False
        for k in range(m):
            for h in range(m):
                total = 0.0
                for a in range(2):
                    for c in range(2):
                        total += spread[2 * k + a, 2 * h + c] ** 2
                S[k, h] = 0.5 * total
                shared = shared or total != 0.0
        fixed[:] = 0.0
        for i in range(n):
            between[i] = 0.0 if not assumed else (min(hidden[i], most) if len(hidden) else unknown * most)
            fixed[i, i] = inside[i // 3, i % 3] + between[i]
        for which in range(2):
            if not np.isnan(stated[which]):
                for i in range(n):
                    for j in range(n):
                        fixed[i, j] += stated[which] * turned[which, i, j]
        at = 0
        if not assumed:
            for i in range(n):
                patterns[0, i, i] = 1.0
            at = 1
        for which in range(2):
            if wanted[which] > 0.0:
                patterns[at] = turned[which]
                at += 1
        state, likely = find_components(
            design, y, fixed, patterns, blocks, first, seen, place, S if shared else S[:0, :0], start, theta,
            information, inverse, weighted, bare, P, pull,
        )  # fmt: skip
        if state != FINE:
            return state, np.nan, most
        start[:] = theta
        for h in range(p):
            coefficients[h] = 0.0
            for i in range(n):
                one = 0.0
                for a in range(p):
                    one += bare[h, a] * weighted[i, a]
                gain[h, i] = one
                coefficients[h] += one * y[i]
        for i in range(12):
            values[i] = usual[i]
            for h in range(p):
                values[i] += back[i, h] * coefficients[h]
        face, laying, at = stated[0], stated[1], 0 if assumed else 1
        if wanted[0] > 0.0:
            face = theta[at]
            at += 1
        if wanted[1] > 0.0:
            laying = theta[at]
        face, laying = 0.0 if np.isnan(face) else face, 0.0 if np.isnan(laying) else laying
        moved = _tilts(direction, same, face, laying, lever, P, pull, tilt, spread, stretch)
        if moved < settled:
            break
    return state, likely, most


@reordered
def _left_over(design: Array, y: Array) -> float:
    """Return the variance of the residuals of a plain fit, by modified Gram and Schmidt."""
    n, p = design.shape
    basis, left = design.T.copy(), y.copy()
    for a in range(p):
        size = 0.0
        for i in range(n):
            size += basis[a, i] ** 2
        size = np.sqrt(size)
        along = 0.0
        for i in range(n):
            basis[a, i] /= size
            along += basis[a, i] * left[i]
        for i in range(n):
            left[i] -= along * basis[a, i]
        for c in range(a + 1, p):
            along = 0.0
            for i in range(n):
                along += basis[a, i] * basis[c, i]
            for i in range(n):
                basis[c, i] -= along * basis[a, i]
    total = 0.0
    for i in range(n):
        total += left[i] * left[i]
    return float(total / (n - p))


@reordered
def _tilts(
    direction: Array, same: Array, face: float, laying: float, lever: Array, P: Array, pull: Array, tilt: Array,
    spread: Array, stretch: Array,
) -> float:  # fmt: skip
    """Fill the tilts that the readings tell, their covariance, and the lengths; return how far lengths moved."""
    m = len(direction)
    told, each, through = np.zeros((m, 2)), np.zeros((m, 2)), np.zeros((2 * m, 3 * m))
    for k in range(m):
        for a in range(2):
            for i in range(3):
                told[k, a] += lever[k, i, a] * pull[3 * k + i]
                for j in range(3 * m):
                    through[2 * k + a, j] += lever[k, i, a] * P[3 * k + i, j]  # Z' P
    whole, half = np.zeros((2 * m, 2 * m)), np.zeros((2 * m, 2 * m))
    for k in range(2 * m):
        for h in range(m):
            for a in range(2):
                for i in range(3):
                    whole[k, 2 * h + a] += through[k, 3 * h + i] * lever[h, i, a]  # Z' P Z
    for k in range(m):
        for h in range(m):
            size = face * same[k, h] + (laying if k == h else 0.0)
            if size != 0.0:
                for a in range(2):
                    each[k, a] += size * told[h, a]
                    for j in range(2 * m):
                        half[2 * k + a, j] += size * whole[2 * h + a, j]
    for k in range(2 * m):
        for h in range(m):
            for a in range(2):
                spread[k, 2 * h + a] = 0.0
        for h in range(m):
            for c in range(m):
                size = face * same[c, h] + (laying if c == h else 0.0)
                if size != 0.0:
                    for a in range(2):
                        spread[k, 2 * h + a] -= half[k, 2 * c + a] * size
        for h in range(m):
            size = face * same[k // 2, h] + (laying if k // 2 == h else 0.0)
            spread[k, 2 * h + k % 2] += size
    moved = 0.0
    for k in range(m):
        many = 0.0
        tilt[k, 0] = tilt[k, 1] = 0.0
        for h in range(m):
            many += same[k, h]
            for a in range(2):
                tilt[k, a] += same[k, h] * each[h, a]
        length = 1.0
        for a in range(2):
            tilt[k, a] /= many
            length -= 0.5 * (tilt[k, a] ** 2 + (each[k, a] - tilt[k, a]) ** 2 + spread[2 * k + a, 2 * k + a])
        moved = max(moved, abs(length - stretch[k]))
        stretch[k] = length
    return float(moved)

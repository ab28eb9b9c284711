"""Kernels: restricted likelihood of readings whose covariance is in blocks but for what squares of tilts share.

With blocks B of readings, u a number a reading, and S a covariance of m places::

    V = B + U S U'          U: u of each reading in the column of its place

so that the inverse is that of the blocks and of an (m, m) matrix (Woodbury). Without places, and with one block, V is
any covariance.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ....core.estimate import Array
from ....statistics._kernels import reordered
from ....statistics._kernels_levels import inverse_of, root_of

ITERATIONS = 60
SETTLED = 1e-6  # change of a variance, of the largest reading's variance
LEAST = 1e-12  # of the largest variance: information below which a variance is not told
FINE, BROKEN, EXACT, NO_SCATTER = range(4)  # what becomes of a fit
EPS = 2.220446049250313e-16

Indices = NDArray[np.int64]


@reordered
def blocks_of(same: Array, blocks: Indices, first: Indices) -> int:
    """Fill the readings face by face, three a position, and where each face begins; return how many there are."""
    m, count, at = len(same), 0, 0
    taken = np.zeros(m, dtype=np.bool_)
    first[0] = 0
    for k in range(m):
        if taken[k]:
            continue
        taken[k] = True
        waiting, begin = np.empty(m, dtype=np.int64), at
        waiting[0], many, done = k, 1, 0
        while done < many:
            i = waiting[done]
            done += 1
            for h in range(m):
                if not taken[h] and same[i, h] != 0.0:
                    taken[h] = True
                    waiting[many] = h
                    many += 1
        for i in range(many):
            for a in range(3):
                blocks[begin + 3 * i + a] = 3 * waiting[i] + a
        at = begin + 3 * many
        count += 1
        first[count] = at
    return count


@reordered
def _solved(M: Array, columns: Array) -> float:
    """Replace columns by M^-1 of them, and M by rubbish; return the logarithm of its determinant, NaN if none."""
    n, log = len(M), 0.0
    for k in range(n):
        best = k
        for i in range(k + 1, n):
            if abs(M[i, k]) > abs(M[best, k]):
                best = i
        if not abs(M[best, k]) > 0.0:
            return np.nan
        if best != k:
            for j in range(n):
                M[k, j], M[best, j] = M[best, j], M[k, j]
            for j in range(columns.shape[1]):
                columns[k, j], columns[best, j] = columns[best, j], columns[k, j]
        log += np.log(abs(M[k, k]))
        for i in range(k + 1, n):
            share = M[i, k] / M[k, k]
            if share != 0.0:
                for j in range(k + 1, n):
                    M[i, j] -= share * M[k, j]
                for j in range(columns.shape[1]):
                    columns[i, j] -= share * columns[k, j]
    for k in range(n - 1, -1, -1):
        for i in range(k + 1, n):
            for j in range(columns.shape[1]):
                columns[k, j] -= M[k, i] * columns[i, j]
        for j in range(columns.shape[1]):
            columns[k, j] /= M[k, k]
    return float(log)


@reordered
def _whole_inverse(
    B: Array, blocks: Indices, first: Indices, u: Array, place: Indices, S: Array, inverse: Array
) -> float:
    """Fill (B + U S U')^-1; return the logarithm of the determinant, NaN where it is not positive."""
    n, m, log = len(B), len(S), 0.0
    inverse[:] = 0.0
    for b in range(len(first) - 1):
        rows = blocks[first[b] : first[b + 1]]
        c = len(rows)
        own, root, turned = np.empty((c, c)), np.empty((c, c)), np.empty((c, c))
        for i in range(c):
            for j in range(c):
                own[i, j] = B[rows[i], rows[j]]
        one = inverse_of(own, root, turned)
        if np.isnan(one):
            return np.nan
        log += one
        for i in range(c):
            for j in range(c):
                inverse[rows[i], rows[j]] = turned[i, j]
    if not m:
        return float(log)
    seen, moved = np.zeros((n, m)), np.zeros((m, m))  # B^-1 U, U' B^-1 U
    for b in range(len(first) - 1):
        rows = blocks[first[b] : first[b + 1]]
        for i in rows:
            for j in rows:
                seen[i, place[j]] += inverse[i, j] * u[j]
    for b in range(len(first) - 1):
        rows = blocks[first[b] : first[b + 1]]
        for i in rows:
            for j in rows:
                moved[place[i], place[j]] += u[i] * inverse[i, j] * u[j]
    M, K = np.zeros((m, m)), S.copy()
    for i in range(m):
        M[i, i] = 1.0
        for k in range(m):
            for j in range(m):
                M[i, j] += S[i, k] * moved[k, j]
    one = _solved(M, K)
    if np.isnan(one):
        return np.nan
    along = np.zeros((m, n))  # K U' B^-1
    for b in range(len(first) - 1):
        rows = blocks[first[b] : first[b + 1]]
        done = -1
        for i in rows:  # a place at a time: the readings of one stand together
            h = place[i]
            if h == done:
                continue
            done = h
            for k in range(m):
                for j in rows:
                    along[k, j] += K[k, h] * seen[j, h]
    for b in range(len(first) - 1):
        rows = blocks[first[b] : first[b + 1]]
        done = -1
        for i in rows:
            h = place[i]
            if h == done:
                continue
            done = h
            for k in rows:
                share = seen[k, h]
                for j in range(n):
                    inverse[k, j] -= share * along[h, j]
    return float(log + one)


@reordered
def _projected(
    design: Array, left: Array, inverse: Array, weighted: Array, bare: Array, P: Array, pull: Array
) -> float:
    """Fill V^-1 X, (X' V^-1 X)^-1, P, and P y; return the logarithm of the determinant of X' V^-1 X."""
    n, p = design.shape
    weighted[:] = 0.0
    for i in range(n):
        for k in range(n):
            share = inverse[i, k]
            if share != 0.0:
                for j in range(p):
                    weighted[i, j] += share * design[k, j]
    normal, root = np.zeros((p, p)), np.empty((p, p))
    for k in range(n):
        for i in range(p):
            for j in range(i + 1):
                normal[i, j] += design[k, i] * weighted[k, j]
    log = inverse_of(normal, root, bare)
    if np.isnan(log):
        return np.nan
    half = np.zeros((n, p))
    for k in range(n):
        for i in range(p):
            for j in range(p):
                half[k, j] += weighted[k, i] * bare[i, j]
    for i in range(n):
        for j in range(i + 1):
            total = 0.5 * (inverse[i, j] + inverse[j, i])
            for k in range(p):
                total -= half[i, k] * weighted[j, k]
            P[i, j] = P[j, i] = total
    for i in range(n):
        total = 0.0
        for j in range(n):
            total += P[i, j] * left[j]
        pull[i] = total
    return log


@reordered
def _likelihood(
    design: Array, left: Array, fixed: Array, patterns: Array, theta: Array, floor: float, blocks: Indices,
    first: Indices, u: Array, place: Indices, S: Array, constant: float, inverse: Array, weighted: Array, bare: Array,
    P: Array, pull: Array,
) -> float:  # fmt: skip
    """Return the logarithm of the restricted likelihood, and fill what it is made of."""
    n = len(design)
    B = np.zeros((n, n))
    for b in range(len(first) - 1):
        rows = blocks[first[b] : first[b + 1]]
        for i in rows:
            for j in rows:
                total = fixed[i, j]
                for k in range(len(patterns)):
                    total += theta[k] * patterns[k, i, j]
                B[i, j] = total
            B[i, i] += floor
    log = _whole_inverse(B, blocks, first, u, place, S, inverse)
    if np.isnan(log):
        return np.nan
    also = _projected(design, left, inverse, weighted, bare, P, pull)
    square = 0.0
    for i in range(n):
        square += left[i] * pull[i]
    return float(-0.5 * (log + also - constant) - 0.5 * square)


@reordered
def _score(
    patterns: Array, unit: Array, blocks: Indices, first: Indices, P: Array, pull: Array, score: Array,
    information: Array,
) -> None:  # fmt: skip
    """Fill the slope of the restricted likelihood by each theta over its unit, and their information."""
    k, n = len(patterns), len(P)
    moved = np.zeros((k, n, n))  # Q P: as rows of P are
    for a in range(k):
        for b in range(len(first) - 1):
            rows = blocks[first[b] : first[b + 1]]
            for i in rows:
                for h in rows:
                    share = unit[a] * patterns[a, i, h]
                    if share != 0.0:
                        for j in range(n):
                            moved[a, i, j] += share * P[h, j]
    for a in range(k):
        total = 0.0
        for b in range(len(first) - 1):
            rows = blocks[first[b] : first[b + 1]]
            for i in rows:
                total -= moved[a, i, i]
                for j in rows:
                    total += unit[a] * pull[i] * patterns[a, i, j] * pull[j]
        score[a] = 0.5 * total
        for c in range(a + 1):
            total = 0.0
            for i in range(n):
                for j in range(n):
                    total += moved[a, i, j] * moved[c, j, i]
            information[a, c] = information[c, a] = 0.5 * total


@reordered
def _least(A: Array, b: Array, found: Array) -> None:
    """Fill the x of least x'A x / 2 - b'x with none below zero, of so few that all choices can be tried."""
    k = len(b)
    best = 0.0
    found[:] = 0.0
    for choice in range(1, 2**k):
        some = np.array([i for i in range(k) if choice >> i & 1])
        c = len(some)
        own, root, inverse = np.empty((c, c)), np.empty((c, c)), np.empty((c, c))
        for i in range(c):
            for j in range(c):
                own[i, j] = A[some[i], some[j]]
        if np.isnan(inverse_of(own, root, inverse)):
            continue
        x, value, inside = np.zeros(c), 0.0, True
        for i in range(c):
            for j in range(c):
                x[i] += inverse[i, j] * b[some[j]]
            value -= 0.5 * x[i] * b[some[i]]
            inside = inside and x[i] >= 0.0
        if inside and value < best:
            best = value
            found[:] = 0.0
            for i in range(c):
                found[some[i]] = x[i]


@reordered
def find_components(
    design: Array, y: Array, fixed: Array, patterns: Array, blocks: Indices, first: Indices, u: Array,
    place: Indices, S: Array, start: Array, theta: Array, information: Array, inverse: Array, weighted: Array,
    bare: Array, P: Array, pull: Array,
) -> tuple[int, float]:  # fmt: skip
    """Fill theta of greatest restricted likelihood, none below zero, and the fit with it.

    Parameters
    ----------
    design, y : ndarray, shapes (n, p), (n,)
        As `fit_components` takes them.
    fixed : ndarray, shape (n, n)
        The known covariance, in blocks.
    patterns : ndarray, shape (k, n, n)
        In the same blocks.
    blocks, first : ndarray of int, shapes (n,), (blocks + 1,)
        Readings block by block, those of a place together, and where each block begins.
    u, place, S : ndarray, shapes (n,), (n,), (m, m)
        The known covariance beyond blocks.
    start : ndarray, shape (k,)
        Theta to begin with; NaN for equal parts.
    theta, information : ndarray, shapes (k,), (k, k)
        Out: variances, and what is known of them.
    inverse, weighted, bare, P, pull : ndarray, shapes (n, n), (n, p), (p, p), (n, n), (n,)
        Out: V^-1, V^-1 X, covariance of the coefficients, projector, P y.

    Returns
    -------
    int, float
        What became of it, and the logarithm of the restricted likelihood up to a constant of the design.
    """
    n, p = design.shape
    k, q = len(patterns), n - p
    normal, root, plain = np.zeros((p, p)), np.empty((p, p)), np.empty((p, p))
    for h in range(n):
        for i in range(p):
            for j in range(i + 1):
                normal[i, j] += design[h, i] * design[h, j]
    constant = root_of(normal, root)
    if np.isnan(constant):
        return BROKEN, np.nan
    inverse_of(normal, root, plain)
    left, x, c = y.copy(), np.empty(p), np.empty(p)
    for _ in range(2):  # the second takes off what rounding left
        x[:] = 0.0
        for h in range(n):
            for i in range(p):
                x[i] += design[h, i] * left[h]
        for i in range(p):
            c[i] = 0.0
            for j in range(p):
                c[i] += plain[i, j] * x[j]
        for h in range(n):
            for i in range(p):
                left[h] -= design[h, i] * c[i]
    square, whole, known = 0.0, 0.0, False
    for h in range(n):
        square += left[h] * left[h]
        whole += y[h] * y[h]
    for i in range(n):
        for j in range(n):
            known = known or fixed[i, j] != 0.0
    if not known and np.sqrt(square) <= n * EPS * np.sqrt(whole):
        return EXACT, np.nan
    theta[:] = 0.0
    information[:] = 0.0
    unit = np.ones(k)
    if k:
        total = max(square, _trace(fixed, design, plain, blocks, first) + _shared(u, place, S, design, plain)) / q
        at = np.empty(k)
        for a in range(k):
            size = max(_trace(patterns[a], design, plain, blocks, first) / q, 1e-300)
            unit[a] = total / size
            at[a] = 1.0 / k if np.isnan(start[a]) else start[a] / unit[a]
        floor = LEAST * total
        arrays = (inverse, weighted, bare, P, pull)
        best = _likelihood(
            design, left, fixed, patterns, at * unit, floor, blocks, first, u, place, S, constant, *arrays
        )
        if np.isnan(best):
            return BROKEN, np.nan
        score, target, A, b = np.empty(k), np.empty(k), np.empty((k, k)), np.empty(k)
        for _ in range(ITERATIONS):
            _score(patterns, unit, blocks, first, P, pull, score, information)
            trace = 0.0
            for a in range(k):
                trace += information[a, a]
            for a in range(k):
                b[a] = score[a]
                for i in range(k):
                    A[a, i] = information[a, i] + (LEAST * trace if a == i else 0.0)
                    b[a] += information[a, i] * at[i]
            _least(A, b, target)
            share, new, found = 1.0, best, False
            while share > 1e-4:
                new = _likelihood(
                    design, left, fixed, patterns, (at + share * (target - at)) * unit, floor, blocks, first, u, place,
                    S, constant, *arrays,
                )  # fmt: skip
                if np.isnan(new):
                    return BROKEN, np.nan
                if new >= best - 1e-12 * abs(best):
                    found = True
                    break
                share *= 0.5
            if not found:
                break
            moved, largest = 0.0, 1.0
            for a in range(k):
                moved = max(moved, abs(share * (target[a] - at[a])))
                at[a] += share * (target[a] - at[a])
                largest = max(largest, at[a])
            done = abs(new - best) <= SETTLED * max(1.0, abs(best)) and moved <= SETTLED * largest
            best = max(best, new)
            if done:
                break
        if not found:  # what the last trial left
            _likelihood(design, left, fixed, patterns, at * unit, floor, blocks, first, u, place, S, constant, *arrays)
        _score(patterns, unit, blocks, first, P, pull, score, information)
        for a in range(k):
            theta[a] = at[a] * unit[a]
            for i in range(k):
                information[a, i] /= unit[a] * unit[i]
    likely = _likelihood(
        design, left, fixed, patterns, theta, 0.0, blocks, first, u, place, S, constant,
        inverse, weighted, bare, P, pull,
    )  # fmt: skip
    if np.isnan(likely):
        return NO_SCATTER, np.nan
    return FINE, likely


@reordered
def _trace(V: Array, design: Array, plain: Array, blocks: Indices, first: Indices) -> float:
    """Return the trace of a covariance in blocks, of the contrasts that no coefficient moves."""
    p, total = design.shape[1], 0.0
    row = np.empty(p)
    for b in range(len(first) - 1):
        rows = blocks[first[b] : first[b + 1]]
        for i in rows:
            total += V[i, i]
            row[:] = 0.0
            for j in rows:
                for h in range(p):
                    row[h] += V[i, j] * design[j, h]
            for a in range(p):
                for h in range(p):
                    total -= design[i, a] * plain[a, h] * row[h]
    return float(total)


@reordered
def _shared(u: Array, place: Indices, S: Array, design: Array, plain: Array) -> float:
    """Return the same of U S U'."""
    m, p = len(S), design.shape[1]
    total, seen, half = 0.0, np.zeros((m, p)), np.zeros((m, p))
    if not m:
        return total
    for i in range(len(u)):
        total += u[i] * u[i] * S[place[i], place[i]]
        for h in range(p):
            seen[place[i], h] += u[i] * design[i, h]
    for k in range(m):
        for i in range(p):
            for h in range(p):
                half[k, h] += seen[k, i] * plain[i, h]
    for k in range(m):
        for i in range(m):
            for h in range(p):
                total -= S[k, i] * half[k, h] * seen[i, h]
    return float(total)

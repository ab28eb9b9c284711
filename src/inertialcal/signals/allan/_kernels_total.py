"""Compiled loops of the total variances: arrays in, preallocated arrays out, no checks.

A stretch of 3 m samples of y, less a line, is mirrored at both ends and goes on for ever with the period 6 m. Its sums
over windows of m have second differences z; wanted is the sum of z^2 over one period, and over all stretches. With S
the sum of the samples of a stretch before each, z is for starts s after (and, the stretch reversed, before) its own::

    s = 0              S(3m) - 3 S(2m) + 3 S(m) - S(0)                            twice
    0 < s <= m         2 S(3m) - S(3m - s) - 3 S(2m + s) + 3 S(m + s) - S(s)      twice: z(s) = z(3m - s)
    m < s < 2m         -4 S(3m) - S(3m - s) + 3 S(4m - s) + 3 S(m + s) - S(s)
    0 < s <= m         -2 S(0) + S(s) + 3 S(m - s) - 3 S(2m - s) + S(3m - s)      twice
    m < s < 2m         4 S(0) + S(s) + S(3m - s) - 3 S(s - m) - 3 S(2m - s)

Over all starts of stretches i and all s, the sum of a product of two such S is one pass over the record: each S(i + s)
meets a whole row of the other, whose sum is a difference of two running sums (over every second point, where one index
falls as the other rises). So no averaging time costs more than the record has samples, where the definition costs m
times as many. A line taken off a block changes nothing, and keeps the digits.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...core.estimate import Array
from ...statistics._kernels import compiled, reordered

Whole = NDArray[np.int64]

DIRECT = 16  # largest averaging factor whose stretches are looked at one by one
REACH = 3  # stretches that start in a block, in averaging factors


@reordered
def _edge(p: Array, m: int, first: int, step: int) -> float:
    """Sum of squared second differences about the m - 1 points next to an end, mirrored there with the sign turned."""
    total = 0.0
    for j in range(1, m):
        d = 2.0 * p[first] - p[first + step * (m - j)] - 2.0 * p[first + step * j] + p[first + step * (j + m)]
        total += d * d
    return total


@compiled
def add_edges(p: Array, factors: Whole, out: Array) -> None:
    """Add the terms of the total variance whose windows reach beyond an end of the integrated signal."""
    for k in range(len(factors)):
        out[k] += _edge(p, factors[k], 0, 1) + _edge(p, factors[k], len(p) - 1, -1)


@compiled
def regions(m: int, weight: Array, first: Whole, last: Whole, size: Array, at: Whole, turn: Whole) -> None:
    """Fill the table of the module head: z = sum of size S(at + turn s), s from first to last; 5 terms a region."""
    size[:] = 0.0
    weight[:] = np.array([2.0, 2.0, 1.0, 2.0, 1.0])
    first[:] = np.array([0, 1, m + 1, 1, m + 1])
    last[:] = np.array([0, m, 2 * m - 1, m, 2 * m - 1])
    size[0] = np.array([1.0, -3.0, 3.0, -1.0, 0.0])
    size[1] = np.array([2.0, -1.0, -3.0, 3.0, -1.0])
    size[2] = np.array([-4.0, -1.0, 3.0, 3.0, -1.0])
    size[3] = np.array([-2.0, 1.0, 3.0, -3.0, 1.0])
    size[4] = np.array([4.0, 1.0, 1.0, -3.0, -3.0])
    at[0] = np.array([3 * m, 2 * m, m, 0, 0])
    at[1] = np.array([3 * m, 3 * m, 2 * m, m, 0])
    at[2] = np.array([3 * m, 3 * m, 4 * m, m, 0])
    at[3] = np.array([0, 0, m, 2 * m, 3 * m])
    at[4] = np.array([0, 0, 3 * m, -m, 2 * m])
    turn[0] = np.array([0, 0, 0, 0, 0])
    turn[1] = np.array([0, -1, 1, 1, 1])
    turn[2] = np.array([0, -1, -1, 1, 1])
    turn[3] = np.array([0, 1, -1, -1, -1])
    turn[4] = np.array([0, 1, -1, 1, -1])


@reordered
def _products(
    g: Array, sums: Array, twos: Array, a: int, e: int, b: int, f: int, many: int, low: int, high: int
) -> float:
    """Sum of g[i + a + e s] g[i + b + f s] over i < many and s from low to high; e, f are -1, 0 or 1.

    ``sums``: of the g before each; ``twos[v + 2]``: of g[v], g[v - 2], ...
    """
    total = 0.0
    if e == 0 and f == 0:
        for i in range(many):
            total += g[i + a] * g[i + b]
        return total * (high - low + 1)
    if f == 0:
        a, e, b, f = b, f, a, e
    if e == 0:
        near, far = b + min(f * low, f * high), b + max(f * low, f * high) + 1
        for i in range(many):
            total += g[i + a] * (sums[i + far] - sums[i + near])
        return total
    if e == f:
        begin, end = (low, many - 1 + high) if e > 0 else (-high, many - 1 - low)
        most = min(many, high - low + 1)
        for u in range(begin, end + 1):
            total += min(min(u - begin, end - u) + 1, most) * (g[u + a] * g[u + b])
        return total
    if e < 0:
        a, b = b, a
    for u in range(low, many + high):
        near, far = max(low, u - many + 1), min(high, u)
        total += g[u + a] * (twos[u + b - 2 * near + 2] - twos[u + b - 2 * far])
    return total


@compiled
def _fill_local(y: Array, g: Array) -> None:
    """Fill the sums of the samples before each, less the line through the means of the two halves."""
    n = len(y)
    half = n // 2
    one, other = 0.0, 0.0
    for i in range(half):
        one += y[i]
        other += y[n - 1 - i]
    slope = (other - one) / (half * (n - half))
    level = (one + other) / (2 * half) - slope * 0.5 * (n - 1)
    g[0] = 0.0
    for i in range(n):
        g[i + 1] = g[i] + (y[i] - level - slope * i)


@compiled
def _slope(g: Array, i: int, m: int) -> float:
    """Slope that is taken off the stretch that starts at i: between the means of its halves."""
    half, rest = 3 * m // 2, 3 * m - 3 * m // 2
    early, late = (g[i + half] - g[i]) / half, (g[i + 3 * m] - g[i + rest]) / half
    return float((late - early) / rest)


@compiled
def _slopes_part(
    g: Array, moments: Array, m: int, many: int, weight: Array, first: Whole, last: Whole, size: Array, at: Whole,
    turn: Whole,
) -> float:  # fmt: skip
    """Return what the slopes of the stretches change in the sum of squares."""
    squares = 0.0
    bend = np.zeros((5, 3))  # of a unit slope: z = bend[0] + bend[1] s + bend[2] s^2
    powers = np.zeros((5, 3))  # sums of 1, s, s^2
    for r in range(5):
        for k in range(5):
            a, e, c = float(at[r, k]), float(turn[r, k]), size[r, k]
            bend[r, 0] += 0.5 * c * a * (a - 1.0)
            bend[r, 1] += 0.5 * c * e * (2.0 * a - 1.0)
            bend[r, 2] += 0.5 * c * e * e
        for s in range(first[r], last[r] + 1):
            z = bend[r, 0] + s * (bend[r, 1] + s * bend[r, 2])
            squares += weight[r] * z * z
            powers[r, 0] += 1.0
            powers[r, 1] += s
            powers[r, 2] += float(s) * s
    total = 0.0
    for i in range(many):
        crossed = 0.0
        for r in range(5):
            if last[r] < first[r]:
                continue
            part = 0.0
            for k in range(5):
                c, start, e = size[r, k], i + at[r, k], turn[r, k]
                if c == 0.0:
                    continue
                if e == 0:
                    here = bend[r, 0] * powers[r, 0] + bend[r, 1] * powers[r, 1] + bend[r, 2] * powers[r, 2]
                    part += c * g[start] * here
                    continue
                near, far = start + min(e * first[r], e * last[r]), start + max(e * first[r], e * last[r]) + 1
                zero, one, two = (
                    moments[0, far] - moments[0, near],
                    moments[1, far] - moments[1, near],
                    moments[2, far] - moments[2, near],
                )
                u = float(start)
                once, twice = e * (one - u * zero), two - 2.0 * u * one + u * u * zero
                part += c * (bend[r, 0] * zero + bend[r, 1] * once + bend[r, 2] * twice)
            crossed += weight[r] * part
        slope = _slope(g, i, m)
        total += slope * (slope * squares - 2.0 * crossed)
    return total


@compiled
def stretches_at_once(y: Array, m: int, start: int, stop: int) -> float:
    """Return the sum of z^2 over one period of each stretch that starts from ``start`` to before ``stop``."""
    weight, first, last = np.empty(5), np.empty(5, dtype=np.int64), np.empty(5, dtype=np.int64)
    size, at, turn = np.empty((5, 5)), np.empty((5, 5), dtype=np.int64), np.empty((5, 5), dtype=np.int64)
    regions(m, weight, first, last, size, at, turn)
    total, block = 0.0, REACH * m
    g = np.empty(block + 3 * m)
    twos, moments = np.zeros(len(g) + 2), np.zeros((3, len(g) + 1))
    for begin in range(start, stop, block):
        many = min(block, stop - begin)
        n = many + 3 * m
        local = g[:n]
        _fill_local(y[begin : begin + n - 1], local)
        for v in range(n):
            twos[v + 2] = twos[v] + local[v]
            moments[0, v + 1] = moments[0, v] + local[v]
            moments[1, v + 1] = moments[1, v] + v * local[v]
            moments[2, v + 1] = moments[2, v] + float(v) * v * local[v]
        for r in range(5):
            if last[r] < first[r]:
                continue
            for k in range(5):
                for j in range(k + 1):
                    c = weight[r] * size[r, k] * size[r, j] * (2.0 if j < k else 1.0)
                    if c != 0.0:
                        total += c * _products(
                            local, moments[0], twos, at[r, k], turn[r, k], at[r, j], turn[r, j], many, first[r], last[r]
                        )
        total += _slopes_part(local, moments, m, many, weight, first, last, size, at, turn)
    return total


@compiled
def stretches_one_by_one(y: Array, m: int, start: int, stop: int) -> float:
    """Return the same, each stretch mirrored as the definition has it."""
    n = 3 * m
    half, rest = n // 2, n - n // 2
    x, total = np.empty(3 * n), 0.0
    for i in range(start, stop):
        early, late = 0.0, 0.0
        for j in range(half):
            early += y[i + j] - y[i]
            late += y[i + rest + j] - y[i]
        slope = (late - early) / half / rest
        for j in range(n):
            here = y[i + j] - y[i] - slope * j
            x[n - 1 - j], x[n + j], x[3 * n - 1 - j] = here, here, here
        z = 0.0
        for j in range(m):
            z += x[j] - 2.0 * x[j + m] + x[j + 2 * m]
        total += z * z
        for j in range(1, 6 * m):
            z += x[j - 1 + 3 * m] - x[j - 1] - 3.0 * (x[j - 1 + 2 * m] - x[j - 1 + m])
            total += z * z
    return total

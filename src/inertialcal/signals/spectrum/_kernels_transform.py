"""Compiled transforms, eight at a time: arrays in, preallocated arrays out, no checks.

Value j of eight complex signals lies in 16 places from 16 j on: eight real parts, and eight imaginary ones. Each pass
is of one factor of the length, and leaves the values in order [1]_: no step sorts them.

References
----------
.. [1] W. T. Cochran et al., IEEE Trans. Audio Electroacoust. 15 (1967) 45: Stockham's ordering of the fast transform.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...core.estimate import Array
from ...statistics._kernels import compiled, reordered
from .._kernels_lanes import LANES, eight, load, store

Whole = NDArray[np.int64]
WIDE = 2 * LANES  # places of a value
TOGETHER = 4  # groups of eight columns that are read together: lines of a cache are read whole
HALF, HIGH = 0.5, np.sqrt(0.75)  # cosine and sine of a third
C1, C2 = np.cos(0.4 * np.pi), np.cos(0.8 * np.pi)  # of a fifth
S1, S2 = np.sin(0.4 * np.pi), np.sin(0.8 * np.pi)


@compiled
def _set(y: Array, i: int, re: Array, im: Array, turns: Array, k: int) -> None:
    """Store values that are turned by the k-th complex number."""
    c, s = eight(turns[2 * k]), eight(turns[2 * k + 1])
    store(y, i, re * c - im * s)
    store(y, i + LANES, im * c + re * s)


@compiled
def _twos(x: Array, y: Array, m: int, s: int, turns: Array) -> None:
    far, to = WIDE * s * m, WIDE * s
    for k in range(m):
        for j in range(s * k, s * (k + 1)):
            i, o = WIDE * j, WIDE * (j + k * s)
            a, ai, b, bi = load(x, i), load(x, i + LANES), load(x, i + far), load(x, i + far + LANES)
            store(y, o, a + b)
            store(y, o + LANES, ai + bi)
            _set(y, o + to, a - b, ai - bi, turns, k)


@compiled
def _threes(x: Array, y: Array, m: int, s: int, turns: Array) -> None:
    far, to, half, high = WIDE * s * m, WIDE * s, eight(HALF), eight(HIGH)
    for r in range(m):
        k = 2 * r
        for j in range(s * r, s * (r + 1)):
            i, o = WIDE * j, WIDE * (j + k * s)
            a, ai, b, bi = load(x, i), load(x, i + LANES), load(x, i + far), load(x, i + far + LANES)
            c, ci = load(x, i + 2 * far), load(x, i + 2 * far + LANES)
            t, ti, d, di = b + c, bi + ci, high * (b - c), high * (bi - ci)
            store(y, o, a + t)
            store(y, o + LANES, ai + ti)
            u, ui = a - half * t, ai - half * ti
            _set(y, o + to, u + di, ui - d, turns, k)
            _set(y, o + 2 * to, u - di, ui + d, turns, k + 1)


@compiled
def _fours(x: Array, y: Array, m: int, s: int, turns: Array) -> None:
    far, to = WIDE * s * m, WIDE * s
    for r in range(m):
        k = 3 * r
        for j in range(s * r, s * (r + 1)):
            i, o = WIDE * j, WIDE * (j + k * s)
            a, ai, c, ci = load(x, i), load(x, i + LANES), load(x, i + 2 * far), load(x, i + 2 * far + LANES)
            b, bi, d, di = (
                load(x, i + far),
                load(x, i + far + LANES),
                load(x, i + 3 * far),
                load(x, i + 3 * far + LANES),
            )
            t, ti, u, ui = a + c, ai + ci, a - c, ai - ci
            v, vi, w, wi = b + d, bi + di, b - d, bi - di
            store(y, o, t + v)
            store(y, o + LANES, ti + vi)
            _set(y, o + to, u + wi, ui - w, turns, k)
            _set(y, o + 2 * to, t - v, ti - vi, turns, k + 1)
            _set(y, o + 3 * to, u - wi, ui + w, turns, k + 2)


@compiled
def _fives(x: Array, y: Array, m: int, s: int, turns: Array) -> None:
    far, to = WIDE * s * m, WIDE * s
    c1, c2, s1, s2 = eight(C1), eight(C2), eight(S1), eight(S2)
    for r in range(m):
        k = 4 * r
        for j in range(s * r, s * (r + 1)):
            i, o = WIDE * j, WIDE * (j + k * s)
            a, ai = load(x, i), load(x, i + LANES)
            b, bi, e, ei = (
                load(x, i + far),
                load(x, i + far + LANES),
                load(x, i + 4 * far),
                load(x, i + 4 * far + LANES),
            )
            c, ci = load(x, i + 2 * far), load(x, i + 2 * far + LANES)
            d, di = load(x, i + 3 * far), load(x, i + 3 * far + LANES)
            t, ti, u, ui = b + e, bi + ei, b - e, bi - ei
            v, vi, w, wi = c + d, ci + di, c - d, ci - di
            store(y, o, a + t + v)
            store(y, o + LANES, ai + ti + vi)
            p, pi, q, qi = a + c1 * t + c2 * v, ai + c1 * ti + c2 * vi, s1 * u + s2 * w, s1 * ui + s2 * wi
            _set(y, o + to, p + qi, pi - q, turns, k)
            _set(y, o + 4 * to, p - qi, pi + q, turns, k + 3)
            p, pi, q, qi = a + c2 * t + c1 * v, ai + c2 * ti + c1 * vi, s2 * u - s1 * w, s2 * ui - s1 * wi
            _set(y, o + 2 * to, p + qi, pi - q, turns, k + 1)
            _set(y, o + 3 * to, p - qi, pi + q, turns, k + 2)


@compiled
def transformed(x: Array, y: Array, factors: Whole, turns: Array) -> Array:
    """Return the transform of eight signals of x, in x or y, whichever it ends in; both are used up.

    ``turns`` holds, pass by pass, exp(-2 pi i j k / n) for j from 0 on and k from 1 to before the factor.
    """
    n, at = 1, 0
    for factor in factors:
        n *= factor
    left = n
    for factor in factors:
        s = n // left
        left //= factor
        if factor == 2:
            _twos(x, y, left, s, turns[at:])
        elif factor == 3:
            _threes(x, y, left, s, turns[at:])
        elif factor == 4:
            _fours(x, y, left, s, turns[at:])
        else:
            _fives(x, y, left, s, turns[at:])
        at += 2 * (factor - 1) * left
        x, y = y, x
    return x


@compiled
def fill_columns(
    one: Array, other: Array, levels: Array, taper: Array, p: int, q: int, factors: Whole, turns: Array,
    between: Array, x: Array, y: Array, middle: Array, wide: int,
) -> None:  # fmt: skip
    """Fill the turned transforms of columns of two real signals, p values of eight columns at a time.

    Signals are each less a level and weighted. Of ``middle``, each column has its real parts, and ``wide`` places on
    its imaginary ones. ``between`` holds what values are turned by: by the place of a column among eight, as
    `transformed` has them, and by the first of each eight, p complex numbers.
    """
    first, second = eight(levels[0]), eight(levels[1])
    for start in range(0, q, LANES * TOGETHER):
        groups = min(TOGETHER, (q - start + LANES - 1) // LANES)
        for j in range(p):
            for g in range(groups):
                i, o = j * q + min(start + LANES * g, q - LANES), WIDE * (g * p + j)
                weight = load(taper, i)
                store(x, o, (load(one, i) - first) * weight)
                store(x, o + LANES, (load(other, i) - second) * weight)
        for g in range(groups):
            column = min(start + LANES * g, q - LANES)  # the last group may have columns of the one before
            found = transformed(x[WIDE * g * p : WIDE * (g + 1) * p], y[: WIDE * p], factors, turns)
            own = between[WIDE * p + 2 * p * (start // LANES + g) :]
            for i in range(0, WIDE * p, WIDE):
                h = i // LANES
                u, v, re, im = eight(own[h]), eight(own[h + 1]), load(found, i), load(found, i + LANES)
                a, b = load(between, i), load(between, i + LANES)
                c, s = a * u - b * v, b * u + a * v
                store(found, i, re * c - im * s)
                store(found, i + LANES, im * c + re * s)
            for lane in range(LANES):
                o = 2 * wide * (column + lane)
                for k in range(p):
                    middle[o + k] = found[WIDE * k + lane]
                    middle[o + wide + k] = found[WIDE * k + LANES + lane]


@compiled
def add_rows(
    middle: Array, wide: int, p: int, q: int, factors: Whole, turns: Array, x: Array, y: Array, power: Array
) -> None:
    """Add the power of the transforms of rows, q values of eight at a time: at l wide + k that of frequency l p + k."""
    for start in range(0, p, LANES):
        row = min(start, p - LANES)
        for j in range(q):
            store(x, WIDE * j, load(middle, 2 * wide * j + row))
            store(x, WIDE * j + LANES, load(middle, 2 * wide * j + wide + row))
        found = transformed(x[: WIDE * q], y[: WIDE * q], factors, turns)
        for k in range(q):
            i, o = WIDE * k, wide * k + row
            if row == start:
                re, im = load(found, i), load(found, i + LANES)
                store(power, o, load(power, o) + re * re + im * im)
            else:
                for lane in range(start - row, LANES):
                    power[o + lane] += found[i + lane] ** 2 + found[i + LANES + lane] ** 2


@reordered
def _mean(part: Array) -> float:
    total = 0.0
    for i in range(len(part)):
        total += part[i]
    return total / len(part)


@compiled
def _fill_eight(z: Array, starts: Whole, levels: Array, taper: Array, x: Array) -> None:
    """Fill one half of all places: written out, for a loop over eight takes four times as long."""
    a, b, c, d = z[starts[0] :], z[starts[1] :], z[starts[2] :], z[starts[3] :]
    e, f, g, h = z[starts[4] :], z[starts[5] :], z[starts[6] :], z[starts[7] :]
    la, lb, lc, ld = levels[0], levels[1], levels[2], levels[3]
    le, lf, lg, lh = levels[4], levels[5], levels[6], levels[7]
    for i in range(len(taper)):
        weight, o = taper[i], WIDE * i
        x[o] = (a[i] - la) * weight
        x[o + 1] = (b[i] - lb) * weight
        x[o + 2] = (c[i] - lc) * weight
        x[o + 3] = (d[i] - ld) * weight
        x[o + 4] = (e[i] - le) * weight
        x[o + 5] = (f[i] - lf) * weight
        x[o + 6] = (g[i] - lg) * weight
        x[o + 7] = (h[i] - lh) * weight


@compiled
def fill_segments(z: Array, starts: Whole, taper: Array, x: Array) -> None:
    """Fill two times eight segments, real and imaginary parts, each less its mean and weighted; 0 where there are less.

    ``starts``: of the segments, of which eight at most are real parts, and the rest, behind them, imaginary ones.
    """
    n, many = len(taper), len(starts)
    levels, every = np.zeros(WIDE), np.full(WIDE, starts[0])  # there is something to read for all
    for s in range(many):
        every[s], levels[s] = starts[s], _mean(z[starts[s] : starts[s] + n])
    _fill_eight(z, every[:LANES], levels[:LANES], taper, x)
    if many > LANES:
        _fill_eight(z, every[LANES:], levels[LANES:], taper, x[LANES:])
    for s in range(many, LANES if many <= LANES else WIDE):
        for i in range(s, WIDE * n, WIDE):
            x[i] = 0.0
    if many <= LANES:
        for i in range(LANES, WIDE * n, WIDE):
            x[i : i + LANES] = 0.0


@compiled
def add_whole(x: Array, power: Array) -> None:
    """Add the power of eight transforms of pairs of real signals, (n // 2 + 1,): half of that at k and at n - k."""
    n, both = len(x) // WIDE, np.empty(LANES)
    for k in range(len(power)):
        i, j = WIDE * k, WIDE * (n - k if k > 0 else 0)
        a, b, c, d = load(x, i), load(x, i + LANES), load(x, j), load(x, j + LANES)
        store(both, 0, (a * a + b * b) + (c * c + d * d))
        one, two = (both[0] + both[4]) + (both[2] + both[6]), (both[1] + both[5]) + (both[3] + both[7])
        power[k] += 0.5 * (one + two)

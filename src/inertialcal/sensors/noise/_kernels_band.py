"""Compiled search of a low pass: arrays in, preallocated arrays out, no checks.

Columns lie in rows, shape (p, long): p whole fours, long whole eights, what is beyond filled with zeros.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...core.estimate import Array
from ...signals._kernels_lanes import LANES, eight, load, store, times
from ...statistics._kernels import compiled
from ._kernels import CONVERGED, MOST_PIVOTS, MOST_STEPS, NO_SLOPE, SHORTEST_STEP, SINGULAR

FAR = 4.0  # times twice the gain of a step: more than all further ones gain
LEAST, MOST = 1e-300, 1e300  # numbers whose logarithm is that of their bits
MANTISSA, ONE = 2**52 - 1, 0x3FF << 52  # bits of a double
FROM = 0x3FE6A09E << 32  # the root of one half: mantissas go from there to twice that
LN_2 = 6.93147180369123816490e-01, 1.90821492927058770002e-10  # high and low part
SERIES = (
    6.666666666666735130e-01, 3.999999999940941908e-01, 2.857142874366239149e-01, 2.222219843214978396e-01,
    1.818357216161805012e-01, 1.531383769920937332e-01, 1.479819860511658591e-01,
)  # fmt: skip


@compiled
def banded_each(
    bands: Array, cycles: Array, density: Array, marked: NDArray[np.bool_], edf: float, neighbours: Array, out: Array,
    counts: NDArray[np.int64],
) -> None:  # fmt: skip
    """Fill frequency, mean density and half the degrees of freedom of bands of each spectrum, shape (n, 3, k).

    ``bands`` is that of each frequency, rising; ``counts`` (n,) is how many each spectrum has. What is ``marked`` is
    left out, and bands without density; ``neighbours`` are squared correlations of densities that lie so far apart.
    """
    for j in range(len(out)):
        found, size, last, at, total = 0, 0, -1.0, 0.0, 0.0
        for i in range(len(cycles) + 1):
            if i < len(cycles) and marked[j, i]:
                continue
            band = bands[i] if i < len(cycles) else np.inf
            if band != last:
                if size > 0 and total > 0.0:
                    pairs = float(size)
                    for lag in range(1, min(size, len(neighbours))):
                        pairs += 2.0 * (size - lag) * neighbours[lag]
                    out[j, 0, found], out[j, 1, found] = at / size, total / size
                    out[j, 2, found] = 0.5 * edf * size * size / pairs
                    found += 1
                size, last, at, total = 0, band, 0.0, 0.0
            if i < len(cycles):
                size, at, total = size + 1, at + cycles[i], total + density[j, i]
        counts[j] = found


@compiled
def fill_logarithms(x: Array, bits: NDArray[np.int64], out: Array) -> None:
    """Fill the natural logarithms of positive numbers, to an ulp [1]_; ``bits`` is work space, shape as x.

    References
    ----------
    .. [1] FDLIBM, e_log.c (Sun Microsystems, 1993).
    """
    lowest, highest = np.inf, -np.inf
    for t in range(len(x)):
        lowest, highest = min(lowest, x[t]), max(highest, x[t])
    if not (lowest > LEAST and highest < MOST):
        for t in range(len(x)):
            out[t] = np.log(x[t])
        return
    own = x.view(np.int64)
    for t in range(len(x)):
        shifted = own[t] + (ONE - FROM)
        out[t] = float((shifted >> 52) - 1023)
        bits[t] = (shifted & MANTISSA) + FROM
    mantissa = bits.view(np.float64)
    for t in range(len(x)):
        f = mantissa[t] - 1.0
        s = f / (2.0 + f)
        z = s * s
        w = z * z
        even = w * (SERIES[1] + w * (SERIES[3] + w * SERIES[5]))
        odd = z * (SERIES[0] + w * (SERIES[2] + w * (SERIES[4] + w * SERIES[6])))
        half = 0.5 * f * f
        out[t] = s * (half + (even + odd)) + out[t] * LN_2[1] - half + f + out[t] * LN_2[0]


@compiled
def _fill_sums(rows: Array, x: Array, out: Array) -> None:
    """Fill the sums of products of each row with x."""
    p, long = rows.shape
    flat, four = rows.ravel(), np.empty(4 * LANES)
    for i in range(0, p, 4):  # a sum waits for the one before it: four go side by side
        a, b, c, d = eight(0.0), eight(0.0), eight(0.0), eight(0.0)
        for t in range(0, long, LANES):
            own, at = load(x, t), i * long + t
            a = a + times(load(flat, at), own)
            b = b + times(load(flat, at + long), own)
            c = c + times(load(flat, at + 2 * long), own)
            d = d + times(load(flat, at + 3 * long), own)
        store(four, 0, a)
        store(four, LANES, b)
        store(four, 2 * LANES, c)
        store(four, 3 * LANES, d)
        for j in range(4):
            total = 0.0
            for t in range(LANES):
                total += four[j * LANES + t]
            out[i + j] = total


@compiled
def _fill_nonnegative(
    rows: Array, weights: Array, b: Array, A: Array, known: NDArray[np.bool_], inverse: Array, x: Array, work: Array
) -> None:  # fmt: skip
    """Fill x >= 0 with the minimum of x' A x / 2 - b' x, as ``_kernels.nonnegative`` does with all of A.

    A is filled for the unknowns alone, which are few: ``inverse`` is that of their part of it, in the order in which
    they came.
    """
    p, count = len(b), 0
    at, place, u = np.empty(p, np.int64), np.full(p, -1), np.empty(p)
    x[:] = 0.0
    known[:] = False
    for _ in range(MOST_PIVOTS):
        change = -1
        for i in range(p):
            if place[i] >= 0:
                if x[i] < 0.0:
                    change = i
                    break
                continue
            slope = b[i]
            for j in range(count):
                slope -= A[at[j], i] * x[at[j]]
            if slope > NO_SLOPE * abs(b[i]):
                if not known[i]:
                    for t in range(rows.shape[1]):
                        work[t] = rows[i, t] * weights[t]
                    _fill_sums(rows, work, A[i])
                    known[i] = True
                left = A[i, i]
                for j in range(count):
                    u[j] = 0.0
                    for k in range(count):
                        u[j] += inverse[j, k] * A[i, at[k]]
                    left -= u[j] * A[i, at[j]]
                if left > SINGULAR * A[i, i]:
                    change = i
                    for j in range(count):
                        for k in range(count):
                            inverse[j, k] += u[j] * u[k] / left
                        inverse[j, count] = inverse[count, j] = -u[j] / left
                    inverse[count, count] = 1.0 / left
                    break
        if change < 0:
            break
        if place[change] < 0:
            place[change], at[count] = count, change
            count += 1
        else:
            gone, last = place[change], count - 1
            for j in range(count):  # to the end
                inverse[gone, j], inverse[last, j] = inverse[last, j], inverse[gone, j]
            for j in range(count):
                inverse[j, gone], inverse[j, last] = inverse[j, last], inverse[j, gone]
            at[gone] = at[last]
            place[at[gone]], place[change], x[change] = gone, -1, 0.0
            for j in range(last):
                for k in range(last):
                    inverse[j, k] -= inverse[j, last] * inverse[last, k] / inverse[last, last]
            count = last
        for j in range(count):
            x[at[j]] = 0.0
            for k in range(count):
                x[at[j]] += inverse[j, k] * b[at[k]]


@compiled
def _fill_mean(rows: Array, v: Array, new: Array, step: float, mu: Array, count: int) -> bool:
    """Fill the mean a step from v to new, 1 from a count on, and return whether it is positive throughout."""
    mu[:] = 0.0
    for i in range(len(v)):
        size = v[i] + step * (new[i] - v[i])
        if size != 0.0:
            for t in range(len(mu)):
                mu[t] += size * rows[i, t]
    mu[count:] = 1.0
    positive = True
    for t in range(count):
        positive &= mu[t] > 0.0
    return positive


@compiled
def few_scored(rows: Array, s: Array, w: Array, v: Array, most: float) -> float:
    """Fill v >= 0 of least cost for mu = v rows, few of which are needed, and return the cost: ``_kernels.scored``.

    Its equations are filled for those few alone. It starts from v where that gives a mean, else from the data. ``s``
    and ``w`` have the length of a row. Where it will not come down to ``most``, it stops on its way.
    """
    p, long = rows.shape
    A, inverse, known, b, new = np.empty((p, p)), np.empty((p, p)), np.empty(p, np.bool_), np.empty(p), np.empty(p)
    weights, rest, work, mu, before = np.empty(long), np.empty(long), np.empty(long), s.copy(), np.empty(long)
    bits, short, cost = np.empty(long, np.int64), long, np.inf
    while short > 0 and w[short - 1] == 0.0:
        short -= 1
    mu[short:] = 1.0
    if _fill_mean(rows, v, v, 0.0, before, short):
        mu[:] = before
    for _ in range(MOST_STEPS):
        for t in range(long):
            weights[t] = w[t] / (mu[t] * mu[t])
            rest[t] = weights[t] * s[t]
        _fill_sums(rows, rest, b)
        _fill_nonnegative(rows, weights, b, A, known, inverse, new, work)
        step, trial, change = 2.0, np.inf, np.inf
        before[:] = mu
        while not trial < cost and step > SHORTEST_STEP and change > CONVERGED:
            step *= 0.5
            positive, trial = _fill_mean(rows, v, new, step, mu, short), np.inf
            if step == 1.0:  # twice the gain to be had
                for t in range(long):
                    rest[t] = weights[t] * (mu[t] - before[t]) ** 2
                change = 0.0
                for t in range(long):
                    change += rest[t]
            if positive:
                fill_logarithms(mu, bits, work)
                trial = 0.0
                for t in range(long):
                    rest[t] = w[t] * (work[t] + s[t] / mu[t])
                for t in range(long):
                    trial += rest[t]
        if not trial < cost:
            break
        for i in range(p):
            v[i] += step * (new[i] - v[i])
        gained, cost = cost - trial, trial
        if gained <= CONVERGED or cost - FAR * change > most:
            break
    return float(cost)


@compiled
def largest_near(mildly: Array, s: Array, w: Array, stride: int, near: float) -> int:
    """Return the largest size that fits nearly as well as the best: costs fall to the least, and rise beyond.

    They are tried a stride apart, then all about the best, and halfway to where they are too large.
    """
    costs, v, best, at, last = np.full(len(mildly), np.inf), np.zeros(mildly.shape[1]), 0, 0, len(mildly) - 1
    while True:
        costs[at] = few_scored(mildly[at], s, w, v, costs[best] + near)  # much like the one before
        if costs[at] < costs[best]:
            best = at
        if at == last or costs[at] > costs[best] + near:
            break
        at = min(at + stride, last)
    inside, outside = best, at if costs[at] > costs[best] + near else last + 1
    middle = best
    for i in range(max(middle - stride + 1, 0), min(middle + stride, outside)):
        if costs[i] == np.inf:
            costs[i] = few_scored(mildly[i], s, w, v, costs[best] + near)
        if costs[i] < costs[best]:
            best = i
    for i in range(len(costs)):
        if costs[i] < costs[best] + near:
            inside = i
        elif i > best and costs[i] < np.inf:
            outside = i
            break
    while outside - inside > 1:
        at = (inside + outside) // 2
        if few_scored(mildly[at], s, w, v, costs[best] + near) < costs[best] + near:
            inside = at
        else:
            outside = at
    return inside


@compiled
def lowest_each(
    plainly: Array, behind: Array, mildly: Array, data: Array, rules: tuple[int, int, int, float, float, int, float],
    found: Array,
) -> None:  # fmt: skip
    """Fill the size of least cost, that cost, the cost without a low pass, and the size of a mild one, shape (n, 4).

    Of densities and weights ``data`` (n, 2, long). Every ``coarse`` size is tried; those about the best, each from the
    data, where twice the gain over no low pass is ``doubtful``; and all where it then is ``likely``. The first sizes
    are as good as ``none``. The columns alone have one more than those behind a low pass, the one that is ``rounded``.
    """
    none, rounded, coarse, doubtful, likely, stride, near = rules
    first, v, count = np.empty(len(plainly)), np.empty(behind.shape[1]), len(behind)
    for j in range(len(data)):
        s, w = data[j, 0], data[j, 1]
        first[:] = 0.0
        plain, best, least = few_scored(plainly, s, w, first, np.inf), 0, np.inf
        v[:] = 0.0
        for i in range(min(len(first) - 1, len(v))):
            v[i] = first[i + int(i >= rounded)]
        without = plain
        for i in range(0, count, coarse):  # each is much like the one before
            cost = few_scored(behind[i], s, w, v, np.inf if i < none else least)
            if i < none:
                without = min(without, cost)
            if cost < least:
                best, least = i, cost
        if 2.0 * (without - least) >= doubtful:
            for i in range(max(best - coarse + 1, none), min(best + coarse, count)):
                v[:] = 0.0
                cost = few_scored(behind[i], s, w, v, least)
                if cost < least:
                    best, least = i, cost
        if 2.0 * (without - least) >= likely:
            best, least = 0, np.inf
            for i in range(count):
                v[:] = 0.0
                cost = few_scored(behind[i], s, w, v, np.inf if i < none else least)
                if i < none:  # where the solver stops short
                    plain = min(plain, cost)
                if cost < least:
                    best, least = i, cost
            without = plain
        found[j, 0], found[j, 1], found[j, 2] = best, least, without
        found[j, 3] = largest_near(mildly, s, w, stride, near)

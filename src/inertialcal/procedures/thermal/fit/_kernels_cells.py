"""Sums of the samples of a ramp in bins of temperature: compiled loops.

Rows of ``columns`` are temperature, time, all readings, and the rate where there is one, shape (2 + k, n).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ....core.estimate import Array
from ....statistics._kernels import compiled, reordered

NONE = -1  # in place of a bin
LOST = 1e-10  # of the square of a column: where all but one group have no more, they tell nothing of it


@reordered
def add_cells(
    columns: Array, readings: int, path: NDArray[np.int8], bounds: NDArray[np.int64], ends: Array, cut: float,
    count: Array, means: Array, squares: Array, left: NDArray[np.int64],
) -> None:  # fmt: skip
    """Add samples to those of each ramp and bin: their number, the means of all rows, squares about these means.

    Parameters
    ----------
    columns : ndarray, shape (2 + k, n)
        Rows as above, the readings first among those from the third on.
    readings : int
        How many there are.
    path : ndarray, shape (n,)
        Way of each sample; 0 on none.
    bounds : ndarray, shape (r, 2)
        The first sample of each ramp, and the one behind its last.
    ends : ndarray, shape (2,)
        Where the first bin begins, and how wide a bin is [degC].
    cut : float
        Time before which nothing counts [s].
    count, means : ndarray, shapes (r, b), (r, 2 + k, b)
        In and out.
    squares : ndarray, shape (r, 3 + 2 readings, b)
        In and out: of temperature, time, temperature with time, each reading, and temperature with each reading.
    left : ndarray, shape (3,)
        In and out: samples in no bin. No reading or temperature, before the time, on no path.
    """
    rows, n = columns.shape
    bins, mean, warm, time = np.empty(n, dtype=np.int64), np.empty(rows), columns[0], columns[1]
    lost, late, off, last = 0, 0, 0, count.shape[1] - 1
    for i in range(n):
        bins[i] = 0 if np.isfinite(warm[i]) else NONE
    for j in range(2, 2 + readings):
        row = columns[j]
        for i in range(n):
            bins[i] = bins[i] if np.isfinite(row[i]) else NONE
    for i in range(n):
        lost += bins[i] < 0
        early = bins[i] == 0 and time[i] < cut
        late += early
        none = bins[i] == 0 and not early and path[i] == 0
        off += none
        bins[i] = NONE if bins[i] < 0 or early or none else min(int((warm[i] - ends[0]) / ends[1]), last)
    left[0] += lost
    left[1] += late
    left[2] += off
    for ramp in range(len(bounds)):
        stop = bounds[ramp, 0]
        while stop < bounds[ramp, 1]:  # a stretch of samples in one bin
            start, at = stop, bins[stop]
            while stop < bounds[ramp, 1] and bins[stop] == at:
                stop += 1
            if at < 0:
                continue
            size, before = float(stop - start), count[ramp, at]
            share = size / (before + size)
            for j in range(rows):
                total, row = 0.0, columns[j, start:stop]
                for i in range(len(row)):
                    total += row[i]
                mean[j] = total / size
            own_warm, middle, apart = columns[0, start:stop], mean[0], mean[0] - means[ramp, 0, at]
            for j in range(2 + readings):
                own, along, row, level = 0.0, 0.0, columns[j, start:stop], mean[j]
                for i in range(len(row)):
                    away = row[i] - level
                    own += away * away
                    along += away * (own_warm[i] - middle)
                far = level - means[ramp, j, at]
                to = j if j < 2 else 1 + j
                squares[ramp, to, at] += own + before * share * far * far
                if j > 0:
                    to = 2 if j == 1 else 1 + readings + j
                    squares[ramp, to, at] += along + before * share * far * apart
            for j in range(rows):
                means[ramp, j, at] += share * (mean[j] - means[ramp, j, at])
            count[ramp, at] = before + size


@reordered
def fill_cubic(columns: Array, ends: Array, middle: Array, cubic: Array, powers: Array, along: Array) -> None:
    """Fill sums of Chebyshev polynomials of the temperature, and of these times what cubics leave of the readings.

    Parameters
    ----------
    columns : ndarray, shape (2 + k, n)
        Rows as above, finite but for the time.
    ends : ndarray, shape (2,)
        Of the temperature, between which the polynomials go from -1 to 1 [degC].
    middle, cubic : ndarray, shapes (k,), (k, 4)
        Taken off the readings: a level, and coefficients of the first four polynomials.
    powers : ndarray, shape (7,)
        Out: sums of the polynomials.
    along : ndarray, shape (k, 5)
        Out: sums of the first four times what is left, and of its squares.
    """
    n = columns.shape[1]
    x, second, third, warm = np.empty(n), np.empty(n), np.empty(n), columns[0]
    one, two, three, four, five, six = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for i in range(n):
        x[i] = (2.0 * warm[i] - ends[0] - ends[1]) / (ends[1] - ends[0])
        second[i] = 2.0 * x[i] * x[i] - 1.0
        third[i] = 2.0 * x[i] * second[i] - x[i]
        one += x[i]
        two += second[i]
        three += third[i]
        four += 2.0 * second[i] * second[i] - 1.0
        five += 2.0 * second[i] * third[i] - x[i]
        six += 2.0 * third[i] * third[i] - 1.0
    powers[0], powers[1], powers[2], powers[3], powers[4], powers[5], powers[6] = n, one, two, three, four, five, six
    for j in range(len(along)):
        row, level = columns[2 + j], middle[j] + cubic[j, 0]
        slope, bend, twist = cubic[j, 1], cubic[j, 2], cubic[j, 3]
        zero, one, two, three, square = 0.0, 0.0, 0.0, 0.0, 0.0
        for i in range(n):
            left = row[i] - level - slope * x[i] - bend * second[i] - twist * third[i]
            zero += left
            one += left * x[i]
            two += left * second[i]
            three += left * third[i]
            square += left * left
        along[j, 0], along[j, 1], along[j, 2], along[j, 3], along[j, 4] = zero, one, two, three, square


@compiled
def count_still(time: Array, temperature: Array, away: float, noise: float, known: NDArray[np.int64]) -> int:
    """Return how many samples pass before the temperature leaves that of the start for good; -1 where time goes back.

    Of both, shape (n,), what is known alone counts; which ones these are is filled in. What lies further away from the
    first thousandth than so much has left; so has what is no longer within so many standard deviations of the first
    half of the rest.
    """
    count, last = 0, -np.inf
    for i in range(len(time)):
        if np.isfinite(time[i]) and np.isfinite(temperature[i]):
            if time[i] < last:
                return -1
            last = time[i]
            known[count] = i
            count += 1
    few = max(count // 1000, 1)
    level = 0.0
    for j in range(min(few, count)):
        level += temperature[known[j]] / few
    still = 0
    while still < count and abs(temperature[known[still]] - level) <= away:
        still += 1
    half = max(still // 2, 1)
    mean, square = 0.0, 0.0
    for j in range(min(half, still)):
        mean += temperature[known[j]] / half
    for j in range(min(half, still)):
        square += (temperature[known[j]] - mean) ** 2 / half
    found = 0
    for j in range(still):
        if abs(temperature[known[j]] - mean) <= noise * np.sqrt(square):
            found = j + 1
    return found


@compiled
def fill_roots(squares: Array, roots: Array) -> None:
    """Fill in the inverses of the Cholesky factors of matrices, shape (m, p, p); infinite where one has none."""
    p = squares.shape[1]
    for m in range(len(squares)):
        factor, root = squares[m].copy(), roots[m]
        root[:] = 0.0
        for j in range(p):
            pivot = factor[j, j]
            for k in range(j):
                pivot -= factor[j, k] * factor[j, k]
            if not pivot > 0.0:
                root[:] = np.inf
                break
            factor[j, j] = np.sqrt(pivot)
            for i in range(j + 1, p):
                for k in range(j):
                    factor[i, j] -= factor[i, k] * factor[j, k]
                factor[i, j] /= factor[j, j]
            root[j, j] = 1.0 / factor[j, j]
            for i in range(j):  # the row of the inverse
                total = 0.0
                for k in range(i, j):
                    total += factor[j, k] * root[k, i]
                root[j, i] = -total / factor[j, j]


@compiled
def fill_errors(
    columns: Array, weight: Array, number: NDArray[np.int64], held: NDArray[np.int64], moments: Array, errors: Array,
    told: Array,
) -> None:  # fmt: skip
    """Fill how far fits to all groups of cells but one miss that one: sums of squares, for one column after the other.

    Parameters
    ----------
    columns : ndarray, shape (u, c, p + k)
        Of the design, then readings.
    weight, number : ndarray, shape (u, c)
        Of each cell; the group that it is in.
    held : ndarray, shape (h,)
        Groups that are held out, each in turn.
    moments : ndarray, shape (u, g, p + k, p + k)
        In zeros, out: sums of products of columns in each group.
    errors : ndarray, shape (u, h, q, k)
        Out: of fits of all but the last ``q - 1`` columns, of one more, up to all p.
    told : ndarray, shape (u, h)
        Out: how little the columns look alike, as the squares of the inverse of the Cholesky factor of their products,
        each of unit length; infinite where there is none, and the errors are not filled.
    """
    k, orders, width = errors.shape[3], errors.shape[2], columns.shape[2]
    p = width - k
    square, root = np.empty((1, p, p)), np.empty((1, p, p))
    size = np.empty(p)
    for u in range(len(columns)):
        total = np.zeros((width, width))
        for i in range(columns.shape[1]):
            row, own = columns[u, i], moments[u, number[u, i]]
            for a in range(width):
                share = weight[u, i] * row[a]
                for b in range(width):
                    own[a, b] += share * row[b]
                    total[a, b] += share * row[b]
        for h in range(len(held)):
            own, unlike = moments[u, held[h]], 0.0
            for a in range(p):
                left = total[a, a] - own[a, a]
                size[a] = np.sqrt(left) if left > LOST * total[a, a] else np.inf
            for a in range(p):
                for b in range(p):
                    square[0, a, b] = (total[a, b] - own[a, b]) / (size[a] * size[b])
            fill_roots(square, root)
            for a in range(p):
                for b in range(a + 1):
                    unlike += root[0, a, b] * root[0, a, b]
            told[u, h] = unlike
            if not unlike < np.inf:
                continue
            fit = np.zeros((k, p))
            for last in range(p):
                for j in range(k):
                    along = 0.0
                    for b in range(last + 1):
                        along += root[0, last, b] * (total[b, p + j] - own[b, p + j]) / size[b]
                    for a in range(last + 1):
                        fit[j, a] += root[0, last, a] * along / size[a]
                    order = last + orders - p
                    if order >= 0:
                        error = own[p + j, p + j]
                        for a in range(last + 1):
                            inner, part = -2.0 * own[a, p + j], own[a]
                            for b in range(last + 1):
                                inner += part[b] * fit[j, b]
                            error += fit[j, a] * inner
                        errors[u, h, order, j] = error


@compiled
def fill_designs(at: Array, spread: Array, path: Array, root: Array, order: int, path_order: int, out: Array) -> None:
    """Fill what cells see of P and D: Chebyshev polynomials, mean over the spread of each cell to second order.

    Parameters
    ----------
    at, spread : ndarray, shape (u, n)
        Temperature from -1 to 1 over the range, and its variance in a cell on that scale.
    path, root : ndarray, shape (u, n)
        1 warming, -1 cooling; what each row is multiplied by.
    order, path_order : int
        Of P, and of D; -1 where there is none.
    out : ndarray, shape (u, n, order + 1 + path_order + 1)
        Out.
    """
    highest = max(order, path_order)
    value, slope, bend = np.zeros(highest + 2), np.zeros(highest + 2), np.zeros(highest + 2)
    for u in range(len(at)):
        for i in range(at.shape[1]):
            x, half, size, way = at[u, i], 0.5 * spread[u, i], root[u, i], 0.5 * path[u, i]
            value[0], value[1], slope[1] = 1.0, x, 1.0
            for k in range(2, highest + 1):
                value[k] = 2.0 * x * value[k - 1] - value[k - 2]
                slope[k] = 2.0 * value[k - 1] + 2.0 * x * slope[k - 1] - slope[k - 2]
                bend[k] = 4.0 * slope[k - 1] + 2.0 * x * bend[k - 1] - bend[k - 2]
            for k in range(order + 1):
                out[u, i, k] = size * (value[k] + half * bend[k])
            for k in range(path_order + 1):
                out[u, i, order + 1 + k] = size * (way * (value[k] + half * bend[k]))


@reordered
def fill_bases(basis: Array, transform: Array, length: Array) -> float:
    """Turn columns of matrices, shape (m, n, p), into orthonormal ones, each less its part along those before, twice.

    ``columns @ transform``, (m, p, p), gives them; ``length``, (m, p), is filled in with the lengths of the columns.
    Returns the least share of a column that those before it leave; 0, the rest unfilled, where one is of no length.
    """
    n, p = basis.shape[1:]
    columns, total, least = np.empty((p, n)), np.empty(p), 1.0
    for m in range(len(basis)):
        own, turned = basis[m], transform[m]
        for j in range(p):
            column, square = columns[j], 0.0
            for k in range(n):
                column[k] = own[k, j]
                square += column[k] * column[k]
            length[m, j] = np.sqrt(square)
            for i in range(j):
                total[i] = 0.0
            for _ in range(2):
                for i in range(j):
                    before, along = columns[i], 0.0
                    for k in range(n):
                        along += before[k] * column[k]
                    for k in range(n):
                        column[k] -= along * before[k]
                    total[i] += along
            square = 0.0
            for k in range(n):
                square += column[k] * column[k]
            size = np.sqrt(square)
            if not size > 0.0:
                return 0.0
            least = min(least, size / length[m, j])
            for k in range(n):
                column[k] /= size
            for i in range(p):
                turned[i, j] = 0.0
            turned[j, j] = 1.0 / size
            for i in range(j):
                part = 0.0
                for q in range(i, j):
                    part += turned[i, q] * total[q]
                turned[i, j] = -part / size
        for k in range(n):
            for j in range(p):
                own[k, j] = columns[j, k]
    return least


@compiled
def fill_behind(newer: float, older: float, left: float, of: Array, behind: Array) -> None:
    """Fill in what an element behind its thermometer shows: weights of a sample, the one before, what it showed."""
    shown = 0.0
    for i in range(len(of)):
        behind[i] = shown + newer * of[i]
        shown = older * of[i] + left * behind[i]

"""Kernels: fits of few readings with a scatter between them (``two_levels``), and medians; roots of small matrices.

References
----------
.. [1] D. E. Knuth, The Art of Computer Programming, vol. 3, 2nd ed., 1998, 5.2.2, algorithm M: merge exchange.
.. [2] G. H. Golub and C. F. Van Loan, Matrix Computations, 4th ed., 2013, 8.3.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..core.estimate import Array
from ._kernels import compiled, reordered

ITERATIONS = 50
SWEEPS = 60  # of rotations to an eigenvalue, at most
EPS = 2.220446049250313e-16
SETTLED = 1e-6  # relative change of tau^2
NARROW = 200  # halvings of an interval, at most
LANES = 64  # matrices whose roots are found, or lines, side by side
STEPS, CONVERGED = 16, 1e-9  # of an iteration that doubles its digits; what the last step may be


@reordered
def root_of(V: Array, root: Array) -> float:
    """Fill the lower root; return the logarithm of the determinant of V, NaN where it is not positive."""
    log = 0.0
    for i in range(len(V)):
        for j in range(i + 1):
            total = V[i, j]
            for k in range(j):
                total -= root[i, k] * root[j, k]
            if i == j:
                if not total > 0.0:
                    return np.nan
                root[i, i] = np.sqrt(total)
                log += 2.0 * np.log(root[i, i])
            else:
                root[i, j] = total / root[j, j]
    return float(log)


@reordered
def inverse_of(V: Array, root: Array, inverse: Array) -> float:
    """Fill the inverse of a symmetric matrix, and its root; return as `root_of`."""
    log = root_of(V, root)
    if np.isnan(log):
        return np.nan
    n = len(V)
    back = np.zeros((n, n))  # inverse of the root, a row a column of it
    for c in range(n):
        for i in range(c, n):
            total = 1.0 if i == c else 0.0
            for k in range(c, i):
                total -= root[i, k] * back[c, k]
            back[c, i] = total / root[i, i]
    for i in range(n):
        for j in range(i + 1):
            total = 0.0
            for k in range(i, n):
                total += back[i, k] * back[j, k]
            inverse[i, j] = inverse[j, i] = total
    return log


@reordered
def settled_square(known: Array, pull: Array, start: float, least: float) -> float:
    """Return the variance between readings of greatest restricted likelihood, zero where there is none.

    Parameters
    ----------
    known, pull : ndarray, shape (q,)
        Of contrasts apart: their known variances, and their squares.
    start : float
        To begin with.
    least : float
        In which changes are told.
    """
    square, floor = start, 1e-12 * least
    for _ in range(ITERATIONS):
        drawn, total, squares = 0.0, 0.0, 0.0
        for i in range(len(known)):
            weight = 1.0 / (max(known[i], 0.0) + square)
            drawn += weight * weight * pull[i]
            total += weight
            squares += weight * weight
        new = max(square + (drawn - total) / squares, floor)
        done = abs(new - square) <= SETTLED * least
        square = new
        if done:
            break
    return square if square > 2.0 * floor else 0.0


@reordered
def _reflector(column: Array) -> float:
    """Turn a column into the reflector that leaves its first entry alone; return 2 over its square, 0 of nothing."""
    square, first = 0.0, column[0]
    for i in range(len(column)):
        square += column[i] * column[i]
    if not square > 0.0:
        return 0.0
    size = np.sqrt(square) + abs(first)
    column[0] = size if first > 0.0 else -size
    return float(2.0 / (square - first * first + size * size))


@reordered
def _reflect(mirror: Array, share: float, x: Array) -> None:
    """Reflect a column."""
    along = 0.0
    for i in range(len(x)):
        along += mirror[i] * x[i]
    along *= share
    for i in range(len(x)):
        x[i] -= along * mirror[i]


@reordered
def _reflect_both(mirror: Array, share: float, V: Array, room: Array) -> None:
    """Reflect the last rows and columns of a symmetric matrix, as many as the reflector has entries."""
    n, along = len(mirror), 0.0
    first = len(V) - n
    for i in range(n):
        total, row = 0.0, V[first + i, first:]
        for k in range(n):
            total += row[k] * mirror[k]
        room[i] = share * total
        along += mirror[i] * room[i]
    along *= 0.5 * share
    for i in range(n):
        room[i] -= along * mirror[i]
    for i in range(n):
        row, own, other = V[first + i, first:], mirror[i], room[i]
        for k in range(n):
            row[k] -= own * room[k] + other * mirror[k]


@reordered
def _set_apart(size: Array, beside: Array, away: Array) -> bool:
    """Turn a tridiagonal matrix to its eigenvalues, and a vector along: implicit QL [2]_; return whether it ended."""
    m = len(size)
    for first in range(m):
        for sweep in range(SWEEPS + 1):
            last = first
            while last < m - 1 and abs(beside[last]) > EPS * (abs(size[last]) + abs(size[last + 1])):
                last += 1
            if last == first:
                break
            if sweep == SWEEPS:
                return False
            g = (size[first + 1] - size[first]) / (2.0 * beside[first])
            r = np.sqrt(g * g + 1.0)
            g = size[last] - size[first] + beside[first] / (g + (r if g >= 0.0 else -r))
            s, c, moved, i = 1.0, 1.0, 0.0, last - 1
            while i >= first:
                f, b = s * beside[i], c * beside[i]
                r = np.sqrt(f * f + g * g)
                beside[i + 1] = r
                if r == 0.0:
                    size[i + 1] -= moved
                    beside[last] = 0.0
                    break
                s, c = f / r, g / r
                g = size[i + 1] - moved
                r = (size[i] - g) * s + 2.0 * c * b
                moved = s * r
                size[i + 1] = g + moved
                g = c * r - b
                away[i], away[i + 1] = c * away[i] - s * away[i + 1], s * away[i] + c * away[i + 1]
                i -= 1
            if i < first:
                size[first] -= moved
                beside[first], beside[last] = g, 0.0
    return True


@reordered
def fill_contrasts(
    design: Array, y: Array, fixed: Array, known: Array, pull: Array, largest: Array, squares: Array
) -> None:
    """Fill the variances between readings by restricted maximum likelihood, and what they follow from; NaN for none.

    Parameters
    ----------
    design, y, fixed : ndarray, shapes (sets, n, p), (sets, n), (sets, n, n)
        Readings, and the sum of their known covariances.
    known, pull : ndarray, shape (sets, n - p)
        Out: known variances of contrasts apart, ascending, and their squares.
    largest, squares : ndarray, shape (sets,)
        Out: largest variance; that between readings, never below zero.
    """
    sets, n, p = design.shape
    m = n - p
    columns, away, V, room = np.empty((p, n)), np.empty(n), np.empty((n, n)), np.empty(n)
    beside = np.zeros(m + 1)
    for s in range(sets):
        noise = 0.0
        for i in range(n):
            away[i] = y[s, i]
            noise += fixed[s, i, i] / n
            for j in range(p):
                columns[j, i] = design[s, i, j]
            for k in range(n):
                V[i, k] = fixed[s, i, k]
        for j in range(p):
            mirror = columns[j, j:]
            share = _reflector(mirror)
            for k in range(j + 1, p):
                _reflect(mirror, share, columns[k, j:])
            _reflect(mirror, share, away[j:])
            _reflect_both(mirror, share, V, room)
        total = 0.0
        for i in range(p, n):
            total += away[i] * away[i] / m
        for j in range(p, n - 2):
            mirror, one = V[j, j + 1 :], V[j, j + 1]
            share = _reflector(mirror)
            beside[j - p] = one - mirror[0]  # what is left of the row
            _reflect(mirror, share, away[j + 1 :])
            _reflect_both(mirror, share, V, room)
        if m > 1:
            beside[m - 2] = V[n - 2, n - 1]
        for j in range(m):
            known[s, j], pull[s, j] = V[p + j, p + j], away[p + j]
        largest[s] = max(total, noise)
        if not _set_apart(known[s], beside, pull[s]):
            squares[s] = np.nan
            continue
        for i in range(m):
            own, along, at = known[s, i], pull[s, i] ** 2, i
            while at > 0 and known[s, at - 1] > own:
                known[s, at], pull[s, at] = known[s, at - 1], pull[s, at - 1]
                at -= 1
            known[s, at], pull[s, at] = own, along
        least = max(total, known[s, 0])  # a prior may be wider than all that the readings show
        squares[s] = settled_square(known[s], pull[s], max(total - noise, 1e-3 * largest[s]), least)
        for i in range(m):
            known[s, i] = max(known[s, i], 0.0)


@reordered
def _beyond(known: Array, pull: Array, nothing: float, square: float, quantile: float) -> tuple[float, float]:
    """Return the weighted sum of squares less a quantile, and its slope."""
    total, slope = -quantile, 0.0
    for i in range(len(known)):
        whole = known[i] + square
        if whole > nothing:
            total += pull[i] / whole
            slope -= pull[i] / (whole * whole)
        else:
            total += pull[i] / nothing
    return total, slope


@reordered
def square_at(known: Array, pull: Array, largest: float, quantile: float) -> float:
    """Return the variance at which the weighted sum of squares is a quantile; zero where it is less without any."""
    most, whole = 0.0, 0.0
    for i in range(len(pull)):
        most = max(most, pull[i])
        whole += pull[i]
    nothing = 1e-300 * max(1.0, most)
    if _beyond(known, pull, nothing, 0.0, quantile)[0] <= 0.0:
        return 0.0
    low, high = 0.0, largest + whole / quantile  # there the sum is below the quantile
    square = 0.5 * (low + high)
    for _ in range(NARROW):  # Newton: the sum falls, ever slower
        value, slope = _beyond(known, pull, nothing, square, quantile)
        if value > 0.0:
            low = square
        else:
            high = square
        new = square - value / slope if slope < 0.0 else low
        if not low < new < high:
            new = 0.5 * (low + high)
        if abs(new - square) <= 1e-15 * high or high - low <= 1e-15 * high:
            return new
        square = new
    return square


@reordered
def solve_levels(
    design: Array, y: Array, sources: Array, is_diagonal: bool, square: float, coefficients: Array, bare: Array,
    gain: Array, projector: Array, residuals: Array, parts: Array, between: Array, deletion: Array,
) -> tuple[float, float]:  # fmt: skip
    """Fill the fit of readings with known errors and a scatter between them.

    Parameters
    ----------
    design, y : ndarray, shapes (n, p), (n,)
        As `fit_two_levels` takes them.
    sources : ndarray, shape (s, n, n)
        The known covariances.
    is_diagonal : bool
        Whether all of them are.
    square : float
        Variance between readings.
    coefficients, bare, gain, projector, residuals : ndarray, shapes (p,), (p, p), (p, n), (n, n), (n,)
        Out: as ``TwoLevels`` has them.
    parts, between : ndarray, shapes (s, p, p), (p, p)
        Out: covariance of the coefficients by each source, and by the scatter.
    deletion : ndarray, shape (2, n)
        Out: residual of each reading from the fit without it, and its u; NaN of one that alone decides.

    Returns
    -------
    float, float
        Chi-square; twice Fisher's information of the scatter, negative where a covariance is none.
    """
    n, p = design.shape
    V, inverse, root = np.zeros((n, n)), np.zeros((n, n)), np.empty((n, n))
    for s in range(len(sources)):
        for i in range(n):
            for j in range(n):
                V[i, j] += sources[s, i, j]
    for i in range(n):
        V[i, i] += square
    if is_diagonal:
        for i in range(n):
            inverse[i, i] = 1.0 / V[i, i]
    elif np.isnan(inverse_of(V, root, inverse)):
        return np.nan, -1.0
    weighted, normal = np.zeros((n, p)), np.zeros((p, p))
    for i in range(n):
        for k in range(n):
            share = inverse[i, k]
            if share != 0.0:
                for j in range(p):
                    weighted[i, j] += share * design[k, j]
    for k in range(n):
        for i in range(p):
            for j in range(i + 1):
                normal[i, j] += design[k, i] * weighted[k, j]
    small = np.empty((p, p))
    if np.isnan(inverse_of(normal, small, bare)):
        return np.nan, -1.0
    gain[:] = 0.0
    for a in range(p):
        for b in range(p):
            for i in range(n):
                gain[a, i] += bare[a, b] * weighted[i, b]
    information = 0.0
    for i in range(n):
        for j in range(i + 1):
            total = 0.5 * (inverse[i, j] + inverse[j, i])
            for a in range(p):
                total -= weighted[i, a] * gain[a, j]
            projector[i, j] = projector[j, i] = total
            information += total * total if i == j else 2.0 * total * total
    for a in range(p):
        total = 0.0
        for i in range(n):
            total += gain[a, i] * y[i]
        coefficients[a] = total
    for i in range(n):
        total = y[i]
        for a in range(p):
            total -= design[i, a] * coefficients[a]
        residuals[i] = total
    chi_square = 0.0
    for i in range(n):
        total, pull = 0.0, 0.0
        for j in range(n):
            total += inverse[i, j] * residuals[j]
            pull += projector[i, j] * residuals[j]
        chi_square += residuals[i] * total
        own = projector[i, i]
        if own <= n * 2.220446049250313e-16 * inverse[i, i]:
            own = np.nan
        deletion[0, i], deletion[1, i] = pull / own, 1.0 / np.sqrt(own)
    moved = np.empty((p, n))
    for s in range(len(sources)):
        if is_diagonal:
            for a in range(p):
                for i in range(n):
                    moved[a, i] = gain[a, i] * sources[s, i, i]
        else:
            moved[:] = 0.0
            for a in range(p):
                for i in range(n):
                    for j in range(n):
                        moved[a, j] += gain[a, i] * sources[s, i, j]
        _joined(moved, gain, parts[s])
    for a in range(p):
        for i in range(n):
            moved[a, i] = square * gain[a, i]
    _joined(moved, gain, between)
    return chi_square, information


@reordered
def solve_many_levels(
    design: Array, y: Array, sources: Array, is_diagonal: bool, square: Array, coefficients: Array, bare: Array,
    gain: Array, projector: Array, residuals: Array, parts: Array, between: Array, deletion: Array, judged: Array,
) -> None:  # fmt: skip
    """Fill what `solve_levels` fills, set by set along the first axis; ``judged``, shape (sets, 2): what it returns."""
    for k in range(len(design)):
        judged[k, 0], judged[k, 1] = solve_levels(
            design[k], y[k], sources[k], is_diagonal, square[k], coefficients[k], bare[k], gain[k], projector[k],
            residuals[k], parts[k], between[k], deletion[k],
        )  # fmt: skip


@reordered
def weighted_squares(design: Array, y: Array, V: Array) -> float:
    """Return the sum of squared residuals of the fit that the covariance V weighs best; NaN where there is none."""
    n, p = design.shape
    inverse, root = np.zeros((n, n)), np.empty((n, n))
    apart = True  # no two readings share an error
    for i in range(n):
        for k in range(i):
            apart = apart and V[i, k] == 0.0
    if apart:
        for i in range(n):
            if not V[i, i] > 0.0:
                return np.nan
            inverse[i, i] = 1.0 / V[i, i]
    elif np.isnan(inverse_of(V, root, inverse)):
        return np.nan
    normal, target, small, bare = np.zeros((p, p)), np.zeros(p), np.empty((p, p)), np.empty((p, p))
    for i in range(n):
        for k in range(n):
            share = inverse[i, k]
            if share != 0.0:
                for a in range(p):
                    target[a] += design[i, a] * share * y[k]
                    for b in range(a + 1):
                        normal[a, b] += design[i, a] * share * design[k, b]
    if np.isnan(inverse_of(normal, small, bare)):
        return np.nan
    residuals = y.copy()
    for a in range(p):
        coefficient = 0.0
        for b in range(p):
            coefficient += bare[a, b] * target[b]
        for i in range(n):
            residuals[i] -= design[i, a] * coefficient
    total = 0.0
    for i in range(n):
        for k in range(n):
            total += residuals[i] * inverse[i, k] * residuals[k]
    return total


@reordered
def fill_scatters(
    design: Array, y: Array, fixed: Array, known: Array, pull: Array, largest: Array, low: float, high: float,
    found: Array,
) -> None:  # fmt: skip
    """Fill what `weighted_squares` returns of each set, and between which scatters the weighted squares are quantiles.

    Parameters
    ----------
    design, y, fixed, known, pull, largest : ndarray
        As `fill_contrasts` has them.
    low, high : float
        Quantiles that the squares at the least and at the largest scatter are.
    found : ndarray, shape (sets, 3)
        Out: weighted squares, NaN where nothing is left over or a known variance is 0; both scatters.
    """
    n, p = design.shape[1:]
    for s in range(len(design)):
        is_known = n > p
        for i in range(n):
            is_known = is_known and fixed[s, i, i] > 0.0
        found[s, 0] = weighted_squares(design[s], y[s], fixed[s]) if is_known else np.nan
        found[s, 1] = np.sqrt(square_at(known[s], pull[s], largest[s], low))
        found[s, 2] = np.sqrt(square_at(known[s], pull[s], largest[s], high))


@reordered
def _joined(moved: Array, gain: Array, part: Array) -> None:
    """Fill the symmetric product of both."""
    for a in range(len(gain)):
        for b in range(a + 1):
            total = 0.0
            for i in range(gain.shape[1]):
                total += moved[a, i] * gain[b, i] + moved[b, i] * gain[a, i]
            part[a, b] = part[b, a] = 0.5 * total


@compiled
def _product(a: Array, b: Array, out: Array) -> None:
    """Fill the product of symmetric matrices whose product is one, shape (p, p, m): m of them side by side."""
    p, m = len(a), a.shape[2]
    for i in range(p):
        for j in range(i + 1):
            total, x, y = out[i, j], a[i, 0], b[0, j]
            for k in range(m):
                total[k] = x[k] * y[k]
            for q in range(1, p):
                x, y = a[i, q], b[q, j]
                for k in range(m):
                    total[k] += x[k] * y[k]
            other = out[j, i]
            for k in range(m):
                other[k] = total[k]


@compiled
def fill_inverse_roots(squares: Array, roots: Array) -> None:
    """Fill the inverse square roots of symmetric matrices with eigenvalues from 0 to 1, shape (m, p, p).

    By Newton's and Schulz's iteration, many side by side; NaN where one is near singular.
    """
    count, p = squares.shape[:2]
    for first in range(0, count, LANES):
        m = min(LANES, count - first)
        square, root, step, other = np.empty((p, p, m)), np.empty((p, p, m)), np.empty((p, p, m)), np.empty((p, p, m))
        away, moves = np.empty(m), np.ones(m)
        for i in range(p):
            for j in range(p):
                for k in range(m):
                    square[i, j, k], root[i, j, k] = squares[first + k, i, j], 1.0 if i == j else 0.0
        for _ in range(STEPS):
            _product(root, square, step)
            for k in range(m):
                away[k] = 0.0
            for i in range(p):
                for j in range(p):
                    own, part = 1.0 if i == j else 0.0, step[i, j]
                    for k in range(m):
                        far = 0.5 * (own - part[k])
                        away[k] = max(away[k], abs(far))
                        part[k] = own + moves[k] * far
            _product(root, step, other)
            root, other = other, root
            going = 0.0
            for k in range(m):  # one that is there stays, however long others take
                if away[k] < CONVERGED:
                    moves[k] = 0.0
                going += moves[k]
            if going == 0.0:
                break
            _product(square, step, other)
            square, other = other, square
        for k in range(m):
            for i in range(p):
                for j in range(p):
                    roots[first + k, i, j] = root[i, j, k] if moves[k] == 0.0 else np.nan


@compiled
def fill_sums(
    basis: Array, order: NDArray[np.intp], starts: NDArray[np.intp], left: Array, own: NDArray[np.intp], gram: Array,
    sums: Array,
) -> None:  # fmt: skip
    """Fill what clusters have of fits: sums of basis times residuals, (s, R, p), and the squares of some of the bases.

    Parameters
    ----------
    basis, left : ndarray, shapes (s, n, p), (s, n)
        Orthonormal columns; what is left of the readings, whitened.
    order, starts : ndarray, shapes (s, n), (s, R)
        Readings by their cluster, and where each cluster begins.
    own : ndarray, shape (u,)
        Fits whose squares are wanted.
    gram, sums : ndarray, shapes (u, R, p, p), (s, R, p)
        In zeros, out.
    """
    n, p = basis.shape[1:]
    for s in range(len(basis)):
        for cluster in range(starts.shape[1]):
            stop, total = starts[s, cluster + 1] if cluster + 1 < starts.shape[1] else n, sums[s, cluster]
            for i in range(starts[s, cluster], stop):
                row, size = basis[s, order[s, i]], left[s, order[s, i]]
                for j in range(p):
                    total[j] += row[j] * size
    for u in range(len(own)):
        s = own[u]
        for cluster in range(starts.shape[1]):
            stop, square = starts[s, cluster + 1] if cluster + 1 < starts.shape[1] else n, gram[u, cluster]
            for i in range(starts[s, cluster], stop):
                row = basis[s, order[s, i]]
                for a in range(p):
                    for b in range(p):
                        square[a, b] += row[a] * row[b]


@compiled
def _multiply(matrix: Array, columns: Array, out: Array) -> None:
    for a in range(len(out)):
        row = out[a]
        for k in range(len(row)):
            row[k] = 0.0
        for b in range(len(columns)):
            entry, other = matrix[a, b], columns[b]
            for k in range(len(row)):
                row[k] += entry * other[k]


@compiled
def fill_dof(gram: Array, adjust: Array, along: Array, dof: Array) -> None:
    """Fill trace squared over that of the square of ``B``, and its trace: `clustered._satterthwaite`.

    Parameters
    ----------
    gram, adjust : ndarray, shape (s, R, p, p)
        As ``Clustered`` has them.
    along : ndarray, shape (s, p, m)
        Combinations of the basis.
    dof : ndarray, shape (s, 2, m)
        In zeros, out.
    """
    count, p, m = along.shape
    moved, seen = np.empty((p, m)), np.empty((p, m))
    own, size = np.empty(m), np.empty(m)
    for s in range(count):
        trace, square, whole = dof[s, 1], dof[s, 0], np.zeros((p, p, m))
        for cluster in range(gram.shape[1]):
            _multiply(adjust[s, cluster], along[s], moved)
            _multiply(gram[s, cluster], moved, seen)
            for k in range(m):
                own[k], size[k] = 0.0, 0.0
            for a in range(p):
                for k in range(m):
                    own[k] += moved[a, k] * seen[a, k]
                    size[k] += seen[a, k] * seen[a, k]
                for b in range(a + 1):
                    row, one, other = whole[a, b], seen[a], seen[b]
                    for k in range(m):
                        row[k] += one[k] * other[k]
            for k in range(m):
                trace[k] += own[k] - size[k]
                square[k] += own[k] * (own[k] - 2.0 * size[k])
        for a in range(p):
            for b in range(a + 1):
                twice = 1.0 if a == b else 2.0
                for k in range(m):
                    square[k] += twice * whole[a, b, k] * whole[a, b, k]
        for k in range(m):
            square[k] = trace[k] * trace[k] / square[k]


@compiled
def fill_fits(
    basis: Array, transform: Array, of: NDArray[np.intp], readings: Array, coefficients: Array, residuals: Array
) -> None:
    """Fill fits to readings, shape (s, n), each by one of several bases.

    Parameters
    ----------
    basis, transform : ndarray, shapes (u, n, p), (u, p, p)
        As ``Decomposed`` has them.
    of : ndarray, shape (s,)
        Number of the basis of each.
    readings : ndarray, shape (s, n)
        Whitened.
    coefficients, residuals : ndarray, shapes (s, p), (s, n)
        Out.
    """
    p = basis.shape[2]
    along = np.empty(p)
    for s in range(len(of)):
        own, turned, y, left = basis[of[s]], transform[of[s]], readings[s], residuals[s]
        _along(own, y, along)
        _less(own, y, along, left)
        for a in range(p):
            total = 0.0
            for b in range(p):
                total += turned[a, b] * along[b]
            coefficients[s, a] = total


@compiled
def _along(basis: Array, x: Array, along: Array) -> None:
    """Fill the parts of readings along the columns of a basis, shape (n, p)."""
    for j in range(len(along)):
        along[j] = 0.0
    for i in range(len(x)):
        row, value = basis[i], x[i]
        for j in range(len(along)):
            along[j] += row[j] * value


@compiled
def _less(basis: Array, x: Array, along: Array, left: Array) -> None:
    """Fill readings less parts along the columns of a basis, shape (n, p)."""
    for i in range(len(x)):
        row, value = basis[i], x[i]
        for j in range(len(along)):
            value -= row[j] * along[j]
        left[i] = value


@compiled
def fill_wider(
    basis: Array, transform: Array, of: NDArray[np.intp], columns: Array, wide: Array, turned: Array
) -> float:
    """Fill bases with a column more: its part that those of one of several bases leave, taken off twice.

    Parameters
    ----------
    basis, transform, of : ndarray, shapes (u, n, p), (u, p, p), (s,)
        As `fill_fits` takes them.
    columns : ndarray, shape (s, n)
        One more of each.
    wide, turned : ndarray, shapes (s, n, p + 1), (s, p + 1, p + 1)
        Out.

    Returns
    -------
    float
        The least share of a column that is left; where it is nought, the rest is not filled.
    """
    n, p = basis.shape[1:]
    along, again, left, least = np.empty(p), np.empty(p), np.empty(n), 1.0
    for s in range(len(of)):
        own, old, column = basis[of[s]], transform[of[s]], columns[s]
        _along(own, column, along)
        _less(own, column, along, left)
        _along(own, left, again)
        _less(own, left, again, left)
        square, whole = 0.0, 0.0
        for i in range(n):
            square += left[i] * left[i]
            whole += column[i] * column[i]
        size = np.sqrt(square)
        if not size > 0.0:
            return 0.0
        least = min(least, size / np.sqrt(whole))
        for i in range(n):
            for j in range(p):
                wide[s, i, j] = own[i, j]
            wide[s, i, p] = left[i] / size
        for a in range(p):
            total = 0.0
            for b in range(p):
                total += old[a, b] * (along[b] + again[b])
                turned[s, a, b] = old[a, b]
            turned[s, a, p], turned[s, p, a] = -total / size, 0.0
        turned[s, p, p] = 1.0 / size
    return least


# Repeated medians of lines side by side


@compiled
def _exchange(low: Array, high: Array) -> None:
    """Put the lesser of two numbers of each line first."""
    for k in range(len(low)):
        a, b = low[k], high[k]
        low[k], high[k] = (a if a < b else b), (b if a < b else a)


@compiled
def _put_in_order(rows: Array) -> None:
    """Put the numbers of each column in order, none of them NaN [1]_."""
    n, top = len(rows), 1
    while 2 * top < n:
        top *= 2
    p = top
    while p > 0:
        q, r, d = top, 0, p
        while True:
            for i in range(n - d):
                if i & p == r:
                    _exchange(rows[i], rows[i + d])
            if q == p:
                break
            d, q, r = q - p, q // 2, p
        p //= 2


@compiled
def _fill_medians(rows: Array, out: Array) -> None:
    """Fill the median of each column, whose numbers are put in order; inf is none, and of nothing NaN."""
    _put_in_order(rows)
    for k in range(rows.shape[1]):
        known = len(rows)
        while known > 0 and rows[known - 1, k] == np.inf:
            known -= 1
        out[k] = 0.5 * (rows[(known - 1) // 2, k] + rows[known // 2, k]) if known > 0 else np.nan


@compiled
def fill_lines(x: Array, y: Array, slope: Array, level: Array) -> None:
    """Fill slope and level of the repeated medians of lines through points that are all known: (n, lines) each.

    Two points at one place have no slope; NaN where all are there.
    """
    n, lines = x.shape
    room, middle = np.empty((n, LANES)), np.empty((n, LANES))
    for start in range(0, lines, LANES):
        many = min(LANES, lines - start)
        own = slice(start, start + many)
        for i in range(n):
            x_here, y_here, to = x[i, own], y[i, own], 0
            for j in range(n):
                if j == i:
                    continue
                x_there, y_there, out = x[j, own], y[j, own], room[to]
                for k in range(many):
                    apart = x_here[k] - x_there[k]
                    rise = (y_here[k] - y_there[k]) / (apart if apart != 0.0 else 1.0)
                    out[k] = rise if apart != 0.0 else np.inf
                to += 1
            _fill_medians(room[: n - 1, :many], middle[i, :many])
            for k in range(many):
                middle[i, k] = middle[i, k] if middle[i, k] == middle[i, k] else np.inf
        _fill_medians(middle[:, :many], slope[own])
        for i in range(n):
            for k in range(many):
                room[i, k] = y[i, start + k] - slope[start + k] * x[i, start + k]
        for k in range(many):
            if not np.isfinite(slope[start + k]):
                for i in range(n):
                    room[i, k] = np.inf
        _fill_medians(room[:, :many], level[own])

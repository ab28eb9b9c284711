"""Kernels: robust fits of few readings, of lengths of the specific force and linear ones."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ....core.estimate import Array
from ....statistics._kernels import reordered

STEPS = 60
SETTLED = 1e-9  # of gravity
COARSE = 0.02  # singular value over the largest, below which the first steps leave a combination alone
HALVINGS = 12  # of a step that are tried
ROBUST = 4  # rounds of weights
EPS = 2.220446049250313e-16
SQUARED = 1.0 / 300.0  # singular value over the largest, above which all may be squared
TUKEY = 4.685  # 95 % efficiency for normal errors
LINEAR_STEPS, LINEAR_SETTLED = 15, 1e-4  # of weights of a linear fit; change over the largest reading
MAD = 1.4826


@reordered
def _fill_triangle(design: Array, columns: Array, R: Array) -> bool:
    """Fill the triangle with ``R' R`` the squares of a design, and its columns as rows; return whether there is one."""
    n, p = design.shape
    for i in range(n):
        for j in range(p):
            columns[j, i] = design[i, j]
    for j in range(p):
        one = columns[j]
        for k in range(j, p):
            total, other = 0.0, columns[k]
            for i in range(n):
                total += one[i] * other[i]
            R[j, k] = total
    for j in range(p):
        for i in range(j):
            share = R[i, j]
            for k in range(j, p):
                R[j, k] -= share * R[i, k]
        if not R[j, j] > 0.0:
            return False
        size = 1.0 / np.sqrt(R[j, j])
        for k in range(j, p):
            R[j, k] *= size
    return True


@reordered
def _by_squares(design: Array, readings: Array, cut: float, found: Array) -> bool:
    """Fill the least-squares solution by its normal equations; return whether they are conditioned well enough."""
    n, p = design.shape
    columns, R, along = np.empty((p, n)), np.zeros((p, p)), np.empty(p)
    if not (_fill_triangle(design, columns, R) and _is_whole(R, max(cut, SQUARED))):
        return False
    for j in range(p):
        total, one = 0.0, columns[j]
        for i in range(n):
            total += one[i] * readings[i]
        for k in range(j):
            total -= R[k, j] * along[k]
        along[j] = total / R[j, j]
    for i in range(p - 1, -1, -1):
        total = along[i]
        for k in range(i + 1, p):
            total -= R[i, k] * found[k]
        found[i] = total / R[i, i]
    return True


@reordered
def fill_sizes(design: Array, sizes: Array) -> None:
    """Fill bounds of the least and of the largest singular value of each of many designs, (sets, 2).

    Nought is known of those of which the squares tell too little.
    """
    n, p = design.shape[1:]
    columns, R = np.empty((p, n)), np.zeros((p, p))
    for k in range(len(design)):
        sizes[k, 0], sizes[k, 1] = 0.0, np.inf
        if n >= p and _fill_triangle(design[k], columns, R):
            size, inverse = _squares(R)
            if SQUARED * np.sqrt(size * inverse) < 1.0:
                sizes[k, 0], sizes[k, 1] = 1.0 / np.sqrt(inverse), np.sqrt(size)


@reordered
def shortest(design: Array, readings: Array, cut: float, found: Array) -> None:
    """Fill the shortest of the least-squares solutions; ``cut``: of the largest singular value, below which one is 0.

    By the normal equations where these are conditioned well, else by an orthogonal triangle; where bounds of its
    condition leave open that one is 0, by its singular values (one-sided rotations of Jacobi). NaN where the design
    has one.
    """
    n, p = design.shape
    if n >= p and _by_squares(design, readings, cut, found):
        return
    rows = max(n, p)
    A, b = np.zeros((p, rows)), np.zeros(rows)  # columns as rows
    for i in range(n):
        b[i] = readings[i]
        for j in range(p):
            A[j, i] = design[i, j]
    R = np.zeros((p, p))
    for j in range(p):
        size = 0.0
        for i in range(j, rows):
            size += A[j, i] ** 2
        size = np.sqrt(size)
        if size > 0.0:
            size = -size if A[j, j] > 0.0 else size
            A[j, j] -= size
            square = 0.0
            for i in range(j, rows):
                square += A[j, i] ** 2
            for k in range(j + 1, p):
                along = 0.0
                for i in range(j, rows):
                    along += A[j, i] * A[k, i]
                along *= 2.0 / square
                for i in range(j, rows):
                    A[k, i] -= along * A[j, i]
            along = 0.0
            for i in range(j, rows):
                along += A[j, i] * b[i]
            along *= 2.0 / square
            for i in range(j, rows):
                b[i] -= along * A[j, i]
        R[j, j] = size
        for k in range(j + 1, p):
            R[j, k] = A[k, j]
    if _is_whole(R, cut):
        for i in range(p - 1, -1, -1):
            total = b[i]
            for k in range(i + 1, p):
                total -= R[i, k] * found[k]
            found[i] = total / R[i, i]
        return
    U, V = R.T.copy(), np.zeros((p, p))  # columns as rows
    for j in range(p):
        V[j, j] = 1.0
    for _ in range(60):
        turned = False
        for i in range(p - 1):
            for j in range(i + 1, p):
                one, other, both = 0.0, 0.0, 0.0
                for k in range(p):
                    one += U[i, k] ** 2
                    other += U[j, k] ** 2
                    both += U[i, k] * U[j, k]
                if abs(both) > EPS * np.sqrt(one * other) and both != 0.0:
                    turned = True
                    ratio = (other - one) / (2.0 * both)
                    t = (1.0 if ratio >= 0.0 else -1.0) / (abs(ratio) + np.sqrt(1.0 + ratio**2))
                    c = 1.0 / np.sqrt(1.0 + t**2)
                    s = c * t
                    for k in range(p):
                        U[i, k], U[j, k] = c * U[i, k] - s * U[j, k], s * U[i, k] + c * U[j, k]
                        V[i, k], V[j, k] = c * V[i, k] - s * V[j, k], s * V[i, k] + c * V[j, k]
        if not turned:
            break
    sizes, largest = np.zeros(p), 0.0
    for j in range(p):
        for k in range(p):
            sizes[j] += U[j, k] ** 2
        if np.isnan(sizes[j]):
            found[:] = np.nan
            return
        largest = max(largest, sizes[j])
    found[:] = 0.0
    for j in range(p):
        if sizes[j] > cut**2 * largest and sizes[j] > 0.0:
            along = 0.0
            for k in range(p):
                along += U[j, k] * b[k]
            for k in range(p):
                found[k] += V[j, k] * along / sizes[j]


@reordered
def _squares(R: Array) -> tuple[float, float]:
    """Return the sum of squares of a triangle, and of its inverse, infinite where there is none."""
    p, size, inverse = len(R), 0.0, 0.0
    back = np.zeros(p)
    for i in range(p):
        if not abs(R[i, i]) > 0.0:
            return np.nan, np.inf
        for k in range(i, p):
            size += R[i, k] ** 2
    for c in range(p):
        for i in range(c, -1, -1):
            total = 1.0 if i == c else 0.0
            for k in range(i + 1, c + 1):
                total -= R[i, k] * back[k]
            back[i] = total / R[i, i]
            inverse += back[i] ** 2
    return size, inverse


@reordered
def _is_whole(R: Array, cut: float) -> bool:
    """Return whether bounds of the singular values of a triangle show that none is below the cut."""
    size, inverse = _squares(R)
    return bool(cut * np.sqrt(size * inverse) < 1.0)


@reordered
def robust_scale(residuals: Array, free: int) -> float:
    """Return the scatter of residuals by their median size, those that a fit uses up set aside."""
    n = len(residuals)
    sizes = np.sort(np.abs(residuals))
    begin = max(n - max(free, 1), 0)
    many = n - begin
    return float(MAD * 0.5 * (sizes[begin + (many - 1) // 2] + sizes[begin + many // 2]))


@reordered
def fill_roots(residuals: Array, free: int, root: Array) -> None:
    """Fill the roots of Tukey's weights."""
    scale = robust_scale(residuals, free)
    for i in range(len(residuals)):
        root[i] = 1.0
        if scale != 0.0:
            root[i] = max(1.0 - (residuals[i] / (TUKEY * scale)) ** 2, 0.0)


@reordered
def fill_tukey(design: Array, readings: Array, found: Array, residuals: Array) -> None:
    """Fill coefficients of a linear fit with Tukey's weights, and its residuals."""
    n, p = design.shape
    cut = EPS * max(n, p)
    root, weighed, target, new = np.ones(n), np.empty((n, p)), np.empty(n), np.empty(p)
    largest = 1e-300
    for i in range(n):
        largest = max(largest, abs(readings[i]))
    shortest(design, readings, cut, found)
    for step in range(LINEAR_STEPS + 1):
        moved = 0.0
        for i in range(n):
            total = readings[i]
            for j in range(p):
                total -= design[i, j] * found[j]
            if step:
                moved = max(moved, abs(total - residuals[i]))
            residuals[i] = total
        if step == LINEAR_STEPS or (step and moved <= LINEAR_SETTLED * largest):
            break
        fill_roots(residuals, n - p, root)
        for i in range(n):
            target[i] = root[i] * readings[i]
            for j in range(p):
                weighed[i, j] = root[i] * design[i, j]
        shortest(weighed, target, cut, new)
        found[:] = new


@reordered
def fill_lengths(theta: Array, r: Array, g: float, e: Array, jacobian: Array, u: Array) -> None:
    """Fill errors of length (m,), their derivatives by the scaled parameters (m, 9), and unit vectors (m, 3)."""
    t00, t10, t11, t20, t21, t22 = theta[0] / g, theta[1] / g, theta[2] / g, theta[3] / g, theta[4] / g, theta[5] / g
    for k in range(len(r)):
        d0, d1, d2 = r[k, 0] - theta[6], r[k, 1] - theta[7], r[k, 2] - theta[8]
        x0, x1, x2 = t00 * d0, t10 * d0 + t11 * d1, t20 * d0 + t21 * d1 + t22 * d2
        length = np.sqrt(x0 * x0 + x2 * x2 + x1 * x1)
        u0, u1, u2 = x0 / length, x1 / length, x2 / length  # a reading of no length has no direction: no solution
        u[k, 0], u[k, 1], u[k, 2] = u0, u1, u2
        jacobian[k, 0] = u0 * d0 / g
        jacobian[k, 1], jacobian[k, 2] = u1 * d0 / g, u1 * d1 / g
        jacobian[k, 3], jacobian[k, 4], jacobian[k, 5] = u2 * d0 / g, u2 * d1 / g, u2 * d2 / g
        jacobian[k, 6] = -(t00 * u0 + t10 * u1 + t20 * u2)
        jacobian[k, 7] = -(t11 * u1 + t21 * u2)
        jacobian[k, 8] = -(t22 * u2)
        e[k] = length - g


@reordered
def _cost(theta: Array, r: Array, g: float, root: Array) -> float:
    t00, t10, t11, t20, t21, t22 = theta[0] / g, theta[1] / g, theta[2] / g, theta[3] / g, theta[4] / g, theta[5] / g
    total = 0.0
    for k in range(len(r)):
        d0, d1, d2 = r[k, 0] - theta[6], r[k, 1] - theta[7], r[k, 2] - theta[8]
        x0, x1, x2 = t00 * d0, t10 * d0 + t11 * d1, t20 * d0 + t21 * d1 + t22 * d2
        e = root[k] * (np.sqrt(x0 * x0 + x2 * x2 + x1 * x1) - g)
        total += e * e
    return float(total)


@reordered
def prior_rows(theta: Array, g: float, stated: Array, rows: Array, q: Array) -> None:
    """Fill derivatives (9, 9) and values (9,) that a prior expects: three scale factors, three angles, three biases.

    ``stated``: the prior u of each kind, NaN for none. Those of a kind without a prior are 0.
    """
    t00, t10, t11, t20, t21, t22 = theta[0] / g, theta[1] / g, theta[2] / g, theta[3] / g, theta[4] / g, theta[5] / g
    A, T = np.zeros((3, 3)), ((0, 0), (1, 0), (1, 1), (2, 0), (2, 1), (2, 2))
    A[0, 0], A[1, 1], A[2, 2] = 1.0 / t00, 1.0 / t11, 1.0 / t22
    A[1, 0] = -t10 * A[0, 0] * A[1, 1]
    A[2, 1] = -t21 * A[1, 1] * A[2, 2]
    A[2, 0] = -(t20 * A[0, 0] + t21 * A[1, 0]) * A[2, 2]
    rows[:] = 0.0
    q[:] = 0.0
    for at in range(9):
        kind = at // 3
        if np.isnan(stated[kind]):
            continue
        if kind == 2:
            q[at] = theta[at] / stated[2]
            rows[at, at] = 1.0 / stated[2]
            continue
        i, j = (at, at) if kind == 0 else ((1, 0), (2, 0), (2, 1))[at - 3]
        value = A[i, i] - 1.0 if kind == 0 else A[i, j] / A[i, i]
        q[at] = value / stated[kind]
        for column in range(6):
            k, h = T[column]
            own = -A[i, k] * A[h, i] / g
            if kind == 1:
                own = (-A[i, k] * A[h, j] / g - value * own) / A[i, i]
            rows[at, column] = own / stated[kind]


@reordered
def converge(r: Array, g: float, root: Array, theta: Array, cut: float, stated: Array) -> bool:
    """Move theta where damped Gauss-Newton with weights root^2 ends; what is not determined stays as it starts.

    Return whether there was a step to try: there is none of readings without a length.

    Parameters
    ----------
    r : ndarray, shape (m, 3)
        Readings in units of the input.
    g : float
        Gravity.
    root : ndarray, shape (m,)
        Roots of the weights.
    theta : ndarray, shape (9,)
        Scaled parameters, in and out.
    cut : float
        As `shortest` takes it.
    stated : ndarray, shape (0,) or (3,)
        As `prior_rows` takes it; empty without a prior.
    """
    m, more = len(r), 9 if len(stated) else 0
    e, jacobian, u = np.empty(m + more), np.empty((m + more, 9)), np.empty((m, 3))
    step, new = np.empty(9), np.empty(9)
    cost = np.inf
    for number in range(STEPS + 1):
        fill_lengths(theta, r, g, e, jacobian, u)
        for k in range(m):
            e[k] *= root[k]
            for j in range(9):
                jacobian[k, j] *= root[k]
        if more:
            prior_rows(theta, g, stated, jacobian[m:], e[m:])
        if number == 0:
            cost = 0.0
            for k in range(m + more):
                cost += e[k] * e[k]
        if number == STEPS:
            break
        shortest(jacobian, -e, cut, step)
        if np.isnan(step[0]):
            return False
        lower, share = False, 1.0
        for _ in range(HALVINGS):
            for j in range(9):
                new[j] = theta[j] + share * step[j]
            there = _cost(new, r, g, root)
            if more:
                prior_rows(new, g, stated, jacobian[m:], e[m:])
                for k in range(m, m + more):
                    there += e[k] * e[k]
            if there <= cost:  # at the minimum, where rounding decides, no step of all is taken
                lower = True
                break
            share *= 0.5
        if not lower:
            break
        moved = 0.0
        for j in range(9):
            theta[j] += share * step[j]
            moved = max(moved, abs(share * step[j]))
        cost = there
        if moved <= SETTLED * g:
            break
    return True


@reordered
def fit_sphere(r: Array, inside: Array, g: float, lost: float, smallest: float, theta: Array) -> tuple[float, float]:
    """Move theta where a robust fit ends; return the scatter of a length, and the singular value that is cut off.

    Both NaN of readings without a length.

    Parameters
    ----------
    r, inside : ndarray, shape (m, 3)
        Readings in units of the input, and their variances by the noise inside.
    g : float
        Gravity.
    lost : float
        Standard uncertainty of a combination of size one above which it is not determined.
    smallest : float
        Singular value over the largest one.
    theta : ndarray, shape (9,)
        Scaled parameters, in and out.
    """
    m = len(r)
    root, none = np.ones(m), np.empty(0)
    e, jacobian, u = np.empty(m), np.empty((m, 9)), np.empty((m, 3))
    if not converge(r, g, root, theta, COARSE, none):
        return np.nan, np.nan
    fill_lengths(theta, r, g, e, jacobian, u)
    cut = max(_scatter(e, inside) / (g * lost), smallest)
    converge(r, g, root, theta, cut, none)
    for _ in range(ROBUST):
        fill_lengths(theta, r, g, e, jacobian, u)
        fill_roots(e, max(m - 9, 1), root)
        converge(r, g, root, theta, cut, none)
    fill_lengths(theta, r, g, e, jacobian, u)
    return _scatter(e, inside), cut


@reordered
def _scatter(e: Array, inside: Array) -> float:
    """Scatter of a length: that of the residuals, where any are left over, never below the noise inside."""
    left = robust_scale(e, len(e) - 9) if len(e) > 9 else 0.0
    total = 0.0
    for k in range(len(inside)):
        for i in range(3):
            total += inside[k, i]
    return float(max(left, np.sqrt(total / (3.0 * len(inside)))))


@reordered
def fit_spheres(r: Array, inside: Array, g: float, lost: float, smallest: float, theta: Array, judged: Array) -> None:
    """Fit each of many sets as `fit_sphere` does, along the first axis; ``judged``, (sets, 2): what it returns."""
    for k in range(len(r)):
        judged[k, 0], judged[k, 1] = fit_sphere(r[k], inside[k], g, lost, smallest, theta[k])


@reordered
def converge_all(r: Array, g: float, theta: Array, cut: Array, settled: NDArray[np.bool_]) -> None:
    """Move each of many theta as `converge` does without weights and prior; fill what it returns."""
    root, none = np.ones(r.shape[1]), np.empty(0)
    for k in range(len(r)):
        settled[k] = converge(r[k], g, root, theta[k], cut[k], none)


@reordered
def fill_many_lengths(theta: Array, r: Array, g: float, e: Array, jacobian: Array, u: Array) -> None:
    """Fill what `fill_lengths` fills, set by set along the first axis."""
    for k in range(len(r)):
        fill_lengths(theta[k], r[k], g, e[k], jacobian[k], u[k])


@reordered
def fill_suspects(design: Array, readings: Array, limit: float, scales: Array, suspect: NDArray[np.bool_]) -> None:
    """Fill the scatter about a robust fit of each of many sets, and the readings beyond so many times that."""
    _, n, p = design.shape
    found, residuals = np.empty(p), np.empty(n)
    for k in range(len(readings)):
        fill_tukey(design[k], readings[k], found, residuals)
        scales[k] = robust_scale(residuals, n - p)
        for i in range(n):
            suspect[k, i] = abs(residuals[i]) > limit * scales[k]

"""The loops of ``_kernels`` in numpy, equal to the last bit: a first record is done before a compiler has started.

``loops`` has the functions that take less time: these for the first calls of a process, then the kernels.
"""

from __future__ import annotations

import itertools
import math
import sys
from types import ModuleType

import numpy as np

from ...core.estimate import Array

MOST_STEPS, MOST_PIVOTS = 60, 100  # of Fisher scoring, of its equations
SHORTEST_STEP = 1e-3  # of Fisher scoring, below which it ends
CONVERGED = 1e-6  # gain of the cost below which it ends
NO_SLOPE, SINGULAR = 1e-12, 1e-13  # relative, what is taken for zero
NEAR, GROWTH = 2, 8  # distances from a knot that are summed one by one, lengths of neighbouring panels beyond
FEW = 12_000  # calls: three channels take half as many; after so many the kernels pay
_calls = itertools.count()


def loops() -> ModuleType:
    """Return the module whose loops take less time: this one, or the kernels."""
    if next(_calls) < FEW:
        return sys.modules[__name__]
    from . import _kernels  # noqa: PLC0415 - starts slowly

    return _kernels


def fill_covariance(
    m: Array, n: Array, raised: Array, reach: float, sizes: Array, ramp: float, exponentials: Array, out: Array
) -> None:
    """Fill the covariance of Allan variances at m samples, ascending, of n terms each."""
    one, other = np.triu_indices(len(m))
    panels: list[tuple[float, float, float, float, float]] = []
    counts = []
    for i, j in zip(one.tolist(), other.tolist(), strict=True):
        before = len(panels)
        _add_panels(panels, float(m[i]), float(m[j]), float(n[i]), float(n[j]), reach)
        counts.append(len(panels) - before)
    of = np.repeat(np.arange(len(one)), counts)
    left, right, middle, ends, rest = np.array(panels).T
    linear = sizes[1] * np.sqrt(raised[one] * raised[other])
    m1, m2, n1, n2 = m[one][of], m[other][of], n[one][of], n[other][of]

    def at(t: Array, used: Array) -> Array:
        found = np.zeros(len(t))
        k, by = np.flatnonzero(used), of[used]
        s = _second_differences(t[k], m1[k], m2[k], linear[by], sizes, exponentials)
        pairs = np.maximum(np.minimum(np.minimum(n1[k], n2[k]), (n1[k] + n2[k]) / 2.0 - t[k]), 0.0)
        found[k] = pairs * (0.5 * s * s + ramp * ramp * m1[k] * m2[k] * s)
        return found

    value = ends * (at(left, ends != 0.0) + at(right, ends != 0.0)) + rest * at(middle, rest != 0.0)
    total = np.bincount(of, weights=value, minlength=len(one))  # in the order of the panels
    out[one, other] = 2.0 * total / (n[one] * n[other])
    out[other, one] = out[one, other]


def _add_panels(
    panels: list[tuple[float, float, float, float, float]], m1: float, m2: float, n1: float, n2: float, reach: float
) -> None:
    """Add the panels of a pair: two distances and one between, the weight of the two and that of the one."""
    last = float(math.floor(max(min((n1 + n2) / 2.0 - 1.0, reach + m1 + m2), 0.0)))
    knots = (0.0, min(m1, m2 - m1), max(m1, m2 - m1), m2, m2 + m1, last)
    panels.append((0.0, 0.0, 0.0, 0.0, 0.5))
    for i in range(1, len(knots)):
        start, end = min(knots[i - 1], last), min(knots[i], last)
        if end <= start:
            continue
        panels.append((end, end, end, 0.0, 1.0))
        lo, hi = start + 1.0, end - 1.0
        both = i < len(knots) - 1
        done = 0
        while lo <= hi:
            size = 1.0 if done < NEAR else float(NEAR) * GROWTH ** (done - NEAR)
            size = min(size, max(float(math.ceil((hi - lo + 1.0) / 2.0)), 1.0) if both else hi - lo + 1.0)
            panels.append(_panel(lo, size))
            lo += size
            if both and lo <= hi:
                size = min(size, hi - lo + 1.0)
                panels.append(_panel(hi - size + 1.0, size))
                hi -= size
            done += 1


def _panel(lo: float, size: float) -> tuple[float, float, float, float, float]:
    middle = lo + 0.5 * (size - 1.0)
    if size == 1.0:
        return middle, middle, middle, 0.0, 1.0
    if size == 2.0:
        return lo, lo + 1.0, lo, 1.0, 0.0
    square = size * size
    outer = (3.0 * square - 7.0) / 20.0
    weight = size * (square - 1.0) / (24.0 * outer)
    by = math.sqrt(outer)
    return middle - by, middle + by, middle, weight, size - 2.0 * weight


def _second_differences(t: Array, m1: Array, m2: Array, raised: Array, sizes: Array, exponentials: Array) -> Array:
    """Return the covariance of differences of neighbouring means over m1 and m2 samples, their middles t apart."""
    point, linear, cubic, flicker = sizes[0], 0.5 * raised, sizes[2] / 12.0, 0.5 * sizes[3]
    total = np.zeros(len(t))
    for a in range(-1, 2):
        for b in range(-1, 2):
            j = np.abs(t + b * m2 - a * m1)
            found = j * (cubic * j * j - linear)
            if flicker != 0.0:
                found += flicker * j * j * _each(math.log, np.where(j == 0.0, 1.0, j))
            for size, u, gain, excess in exponentials.tolist():
                x = u * j
                few = -x * x * x * (1.0 - x * 0.25 * (1.0 - x * 0.2 * (1.0 - x / 6.0 * (1.0 - x / 7.0)))) / 6.0
                rest = np.where(x < 0.05, few, _each(math.exp, -x) - 1.0 + x - 0.5 * x * x)
                found -= size * (gain * rest + excess * j)
            total += (2.0 - 3.0 * abs(a)) * (2.0 - 3.0 * abs(b)) * np.where(j == 0.0, point, found)
    return np.asarray(total / (m1 * m2))


def _each(function: object, x: Array) -> Array:
    """Return a function of each number as the kernels round it, which numpy does not."""
    return np.array([function(one) for one in x.tolist()])  # type: ignore[operator]


def _nonnegative(A: Array, b: Array, held: int) -> list[float]:
    """Return x >= 0 with the minimum of x' A x / 2 - b' x, x[held] zero."""
    p = len(b)
    T, slopes = [[*row, right] for row, right in zip(A.tolist(), b.tolist(), strict=True)], b.tolist()
    x, diagonal = [0.0] * p, [A[i, i] for i in range(p)]
    for _ in range(MOST_PIVOTS):
        for at in range(p):
            row = T[at]
            slope = x[at] == 0.0 and row[p] > NO_SLOPE * abs(slopes[at]) and row[at] > SINGULAR * diagonal[at]
            if at != held and (slope or (x[at] != 0.0 and row[p] < 0.0)):
                break
        else:
            break
        x[at] = 1.0 - x[at]
        pivot = 1.0 / T[at][at]
        scaled = [value * pivot for value in T[at]]
        for i in range(p):
            if i != at:
                factor = T[i][at]
                T[i] = [value - factor * other for value, other in zip(T[i], scaled, strict=True)]
                T[i][at] = -factor * pivot
        scaled[at] = pivot
        T[at] = scaled
    return [x[i] * T[i][p] for i in range(p)]


def _cost_at(D: Array, v: Array, new: Array, step: float, s: Array, w: Array, mu: Array) -> float:
    """Fill mu with D at a step on the way from v to new; return the sum of w (ln mu + s / mu), infinite if mu <= 0."""
    mu[:] = 0.0
    for i, value in enumerate((v + step * (new - v)).tolist()):
        mu += D[:, i] * value
    if not (mu > 0.0).all():
        return math.inf
    return float(np.cumsum(w * (_each(math.log, mu) + s / mu))[-1])


def scored(D: Array, s: Array, w: Array, held: int, value: float, v: Array, warm: bool) -> float:
    """Fill v >= 0 of least cost for mu = D v, v[held] at its value (held -1 for none); return the cost."""
    mu, cost = np.empty(len(s)), math.inf
    if held >= 0:
        v[held] = value
    if not (warm and _cost_at(D, v, v, 0.0, s, w, mu) < math.inf):
        mu[:] = s
    for _ in range(MOST_STEPS):
        weighted = (w / (mu * mu))[:, None] * D
        rest = s - value * D[:, held] if held >= 0 else s
        b = np.cumsum(weighted * rest[:, None], axis=0)[-1]
        A = np.cumsum(weighted[:, :, None] * D[:, None, :], axis=0)[-1]
        new = np.array(_nonnegative(A, b, held))
        if held >= 0:
            new[held] = value
        step, trial = 2.0, math.inf
        while not trial < cost and step > SHORTEST_STEP:
            step *= 0.5
            trial = _cost_at(D, v, new, step, s, w, mu)
        if not trial < cost:
            break
        v += step * (new - v)
        gained, cost = cost - trial, trial
        if gained <= CONVERGED:
            break
    return float(cost)

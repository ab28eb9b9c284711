"""Compiled loops over a spectrum: arrays in, preallocated arrays out, no checks."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...core.estimate import Array
from ...statistics._kernels import compiled, reordered

Whole = NDArray[np.int64]
NONE = 1e-20  # correlation that is rounding
PART = 2048  # frequencies whose products lie in the nearest cache


@compiled
def sums_of_windows(
    level: Array, fourth: Array, order: Whole, m: Whole, neighbours: Array, sums: Array, spread: Array
) -> None:
    """Fill the sum of level times sin^4(pi order m / n) / m^2 for each m, and the variance of such a sum, unscaled.

    ``fourth`` (n): of sin^4(pi k / n); ``neighbours``: correlation of values so many places apart, 1 first.
    """
    n, lags = len(fourth), min(len(neighbours), len(level))
    while lags > 1 and abs(neighbours[lags - 1]) < NONE:
        lags -= 1
    parts = np.empty(PART + lags)
    for i in range(len(m)):
        total, squares = 0.0, 0.0
        held = 0  # products of the frequencies before, that those of the next still meet
        share = 1.0 / (1.0 * m[i] * m[i])
        for first in range(0, len(level), PART):
            stop = min(first + PART, len(level))
            _fill_products(level[first:stop], fourth, order[first:stop], m[i] % n, share, parts[held:])
            own = parts[held : held + stop - first]
            total += _sum(own)
            squares += _product(own, own)
            for lag in range(1, lags):
                begin = max(held, lag)
                end = held + stop - first
                squares += 2.0 * neighbours[lag] * _product(parts[begin:end], parts[begin - lag : end - lag])
            kept = min(lags, held + stop - first)
            for j in range(kept):
                parts[j] = parts[held + stop - first - kept + j]
            held = kept
        sums[i], spread[i] = total, squares


@compiled
def _fill_products(level: Array, fourth: Array, order: Whole, step: int, share: float, out: Array) -> None:
    """Fill level times fourth at order times a step, modulo its length, times a share.

    Where orders follow each other, four places go ahead at a time: none waits for the one before it.
    """
    n, many = len(fourth), len(level)
    if many == 0 or order[many - 1] - order[0] != many - 1:
        for k in range(many):
            out[k] = level[k] * fourth[order[k] % n * step % n] * share
        return
    a = order[0] % n * step % n
    b, by = (a + step) % n, 4 * step % n
    c, d = (b + step) % n, (b + 2 * step) % n
    for i in range(many // 4):
        k = 4 * i  # the nearer half of the table is read alone: sines are alike from both ends
        out[k] = level[k] * fourth[min(a, n - a)] * share
        out[k + 1] = level[k + 1] * fourth[min(b, n - b)] * share
        out[k + 2] = level[k + 2] * fourth[min(c, n - c)] * share
        out[k + 3] = level[k + 3] * fourth[min(d, n - d)] * share
        a, b, c, d = a + by, b + by, c + by, d + by
        a -= n * (a >= n)
        b -= n * (b >= n)
        c -= n * (c >= n)
        d -= n * (d >= n)
    for k in range(many // 4 * 4, many):
        out[k] = level[k] * fourth[a] * share
        a = (a + step) % n


@reordered
def _sum(a: Array) -> float:
    total = 0.0
    for i in range(len(a)):
        total += a[i]
    return total


@reordered
def _product(a: Array, b: Array) -> float:
    total = 0.0
    for i in range(len(a)):
        total += a[i] * b[i]
    return total


@compiled
def fill_tapered(x: Array, starts: Whole, taper: Array, out: Array) -> None:
    """Fill segments (k, n), each less its mean, and weighted."""
    n = len(taper)
    for k in range(len(starts)):
        part, row, level = x[starts[k] : starts[k] + n], out[k], _sum(x[starts[k] : starts[k] + n]) / n
        for i in range(n):
            row[i] = (part[i] - level) * taper[i]


@compiled
def add_power(turned: Array, power: Array) -> None:
    """Add the squared magnitudes of transforms (k, 2 m), real and imaginary part in turn."""
    for row in turned:
        for i in range(len(power)):
            power[i] += row[2 * i] * row[2 * i] + row[2 * i + 1] * row[2 * i + 1]


@compiled
def fill_sums(weights: Array, level: Array, neighbours: Array, sums: Array, spread: Array) -> None:
    """Fill the sum of weights (k, n) times the level (n,), and the variance of such a sum, unscaled.

    ``neighbours``: correlation of values so many places apart, 1 first.
    """
    parts = np.empty(len(level))
    for k in range(len(weights)):
        own = weights[k]
        for i in range(len(level)):
            parts[i] = own[i] * level[i]
        sums[k], spread[k] = _sum(parts), _product(parts, parts)
        for lag in range(1, min(len(neighbours), len(level))):
            spread[k] += 2.0 * neighbours[lag] * _product(parts[lag:], parts[: len(parts) - lag])


@compiled
def continued(frequency: Array, density: Array, spacing: float, lowest: float, highest: float) -> float:
    """Return the Allan variance from below the lowest frequency, for an averaging time of 1 s.

    The density goes on there with the slope of its values, no steeper than a lowest and a highest one.
    """
    n = len(frequency)
    if n == 0 or not density.min() > 0.0:
        return 0.0
    place, logs = np.log(frequency), np.log(density)
    middle, level = place.mean(), logs.mean()
    place -= middle
    squares = _product(place, place)
    slope = min(max(_product(place, logs) / squares, lowest), highest) if squares > 0.0 else 0.0
    edge = frequency[0] - 0.5 * spacing
    there = np.exp(level + slope * (np.log(edge) - middle))
    return float(2.0 * np.pi * np.pi * there * edge * edge * edge / (3.0 + slope))


@compiled
def may_stand_out(
    density: Array, place: Array, edges: Whole, known: NDArray[np.bool_], count: Array, mean_place: Array,
    slope_of: Array, bias: float, ratio: float,
) -> bool:  # fmt: skip
    """Return whether any density may exceed the level of the noise around it by a ratio; True also where one is none.

    ``edges`` (4, n): first and stop of the neighbours, and of the peak among them; ``count``, ``mean_place``: of the
    others; ``slope_of``: how far each lies from the mean place, over the scatter of the places, 0 where they have none;
    ``bias``: of the mean logarithm.
    """
    n = len(density)
    logs, sums, products, more = np.empty(n), np.zeros(n + 1), np.zeros(n + 1), np.log(ratio) - bias
    for i in range(n):
        if not density[i] > 0.0:
            return True
        logs[i] = np.log(density[i])
        sums[i + 1], products[i + 1] = sums[i] + logs[i], products[i] + place[i] * logs[i]
    for i in range(n):
        if known[i]:
            a, b, c, d = edges[0, i], edges[1, i], edges[2, i], edges[3, i]
            mean = (sums[b] - sums[a] - (sums[d] - sums[c])) / count[i]
            slope = (products[b] - products[a] - (products[d] - products[c])) / count[i] - mean_place[i] * mean
            if not logs[i] < mean + slope * slope_of[i] + more:
                return True
    return False

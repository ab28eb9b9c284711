"""Inverse of a sensor's curve as a polynomial, with a remainder that is proved.

The error of a polynomial p as the inverse of g, at the reading r = g(u), is ``p(g(u)) - u``: a polynomial in u with
rational coefficients, without a root to find. Written in the basis of Bernstein over an interval, its values lie
between the smallest and the largest of its coefficients [1]_; the interval is halved until both are close.

References
----------
.. [1] Farouki, The Bernstein polynomial basis: a centennial retrospective, Computer Aided Geometric Design 29, 2012,
   section 4 (convex hull), section 5 (subdivision).
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from functools import lru_cache
from itertools import pairwise
from math import comb, cos, lcm, pi

from ....core.errors import DataError
from .exact import Bend

HIGHEST_DEGREE = 21
CLOSE = Fraction(21, 20)  # how far a proved remainder may lie above the largest value at an end
MOST_HALVINGS = 12


def times(one: Sequence[Fraction], other: Sequence[Fraction]) -> list[Fraction]:
    """Return the product of two polynomials, powers from the lowest."""
    product = [Fraction(0)] * (len(one) + len(other) - 1)
    for i, a in enumerate(one):
        for j, b in enumerate(other):
            product[i + j] += a * b
    return product


def remainder(bend: Bend, powers: Sequence[Fraction], negative: bool) -> Fraction:
    """Return a proved bound on ``|r + sum_m powers[m - 1] r^m - u|`` over u on one side of zero.

    Parameters
    ----------
    powers : sequence of Fraction
        Of r, r^2, ...: what is added to the reading.
    """
    end = bend.lowest if negative else bend.highest
    if end == 0:
        return Fraction(0)
    g = [Fraction(0), *bend.powers(negative)]
    total, power = [Fraction(0), Fraction(-1)], [Fraction(1)]
    for m, factor in enumerate(powers, 1):
        power = times(power, g)
        own = factor + (1 if m == 1 else 0)
        total += [Fraction(0)] * (len(power) - len(total))
        for i, x in enumerate(power):
            total[i] += own * x
    while len(total) > 1 and total[-1] == 0:
        total.pop()
    # u = end * z, z in 0..1; whole numbers over one denominator from here on
    over = [x * end**i for i, x in enumerate(total)]
    n = len(over) - 1
    bernstein = [
        sum((Fraction(comb(i, m), comb(n, m)) * over[m] for m in range(i + 1)), Fraction(0)) for i in range(n + 1)
    ]
    common = lcm(*(x.denominator for x in bernstein))
    return Fraction(_largest([x.numerator * (common // x.denominator) for x in bernstein], MOST_HALVINGS), common)


def _largest(coefficients: list[int], halvings: int) -> Fraction:
    """Bound on the absolute values of a polynomial by its Bernstein coefficients."""
    n = len(coefficients) - 1
    todo, done, reached = [(coefficients, 0, 0)], Fraction(0), Fraction(0)
    while todo:
        row, depth, shift = todo.pop()  # row holds 2^shift times the coefficients
        bound = Fraction(max(map(abs, row)), 2**shift)
        reached = max(reached, Fraction(max(abs(row[0]), abs(row[-1])), 2**shift))
        if depth == halvings or bound <= max(CLOSE * reached, done):
            done = max(done, bound)
            continue
        left, right, current = [row[0] << n], [row[-1] << n], row
        for level in range(1, n + 1):
            current = [a + b for a, b in pairwise(current)]
            left.append(current[0] << (n - level))
            right.append(current[-1] << (n - level))
        todo += [(left, depth + 1, shift + n), (right[::-1], depth + 1, shift + n)]
    return done


def interpolated(bend: Bend, negative: bool, degree: int) -> list[Fraction]:
    """Return powers r, r^2, ... of what is added to a reading: exact at zero and at Chebyshev's points of u.

    There an interpolating polynomial lies within a small factor of the best one.
    """
    end = bend.lowest if negative else bend.highest
    if end == 0:
        return [Fraction(0)] * degree
    points = [end * Fraction(0.5 - 0.5 * cos(pi * (k + 0.5) / degree)) for k in range(degree)]
    readings = [bend.reading(u) for u in points]
    # Newton's form of ((u - r) / r) over r
    table = [_short(u / r - 1) for u, r in zip(points, readings, strict=True)]
    for width in range(1, degree):
        for k in range(degree - 1, width - 1, -1):
            table[k] = _short((table[k] - table[k - 1]) / (readings[k] - readings[k - width]))
    powers = [table[-1]]
    for k in range(degree - 2, -1, -1):
        powers = [a - readings[k] * b for a, b in zip([Fraction(0), *powers], [*powers, Fraction(0)], strict=True)]
        powers[0] += table[k]
    return [_short(one) for one in powers]


def _short(value: Fraction) -> Fraction:
    """Return a value to 60 digits, so that exact arithmetic on it stays quick."""
    if value == 0:
        return value
    unit = Fraction(2) ** (value.numerator.bit_length() - value.denominator.bit_length() - 200)
    return round(value / unit) * unit


@lru_cache(maxsize=8)
def inverse_powers(bends: tuple[Bend, ...], target: Fraction) -> list[list[list[Fraction]]]:
    """Return powers of r for each sensor and side (positive, negative), of the lowest degree that meets a target.

    Raises
    ------
    DataError
        ``cannot_hold`` if no degree does.
    """
    best = Fraction(10**9)
    for degree in range(2, HIGHEST_DEGREE + 1):
        powers = [[interpolated(bend, negative, degree) for negative in (False, True)] for bend in bends]
        left = max(remainder(bend, powers[j][side], bool(side)) for j, bend in enumerate(bends) for side in (0, 1))
        best = min(best, left)
        if left <= target:
            return powers
    raise DataError(
        f"flight-c cannot hold: curves so strong; a polynomial of degree {HIGHEST_DEGREE} leaves {float(best):.2g}, "
        f"need {float(target):.2g}",
        why="the inverse has to be a polynomial, with no loop on data",
        do="Narrow input_range, take an arithmetic with fewer digits, or export to c",
        code="cannot_hold",
    )

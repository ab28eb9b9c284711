"""Sum over the vertices of a lattice in blocks, so that the compiler fills vector registers; no checks.

The closed form of a vertex takes three logarithms and three angles. Those of the C library come one at a time; here
they are polynomials without branches, to two units of the last place, over blocks that stay in the nearest cache.

References
----------
.. [1] FreeBSD msun, e_log.c: the logarithm, reduced to (1 + f) 2^k with f about 0, and its polynomial.
.. [2] Moshier, Cephes Mathematical Library, atan.c: reduction to below tan(pi / 8), and its rational approximation.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ...core.estimate import Array
from ...statistics._kernels import compiled, reordered

Whole = NDArray[np.int64]
BLOCK = 256  # vertices: all buffers of one take 50 kB
TINY = 1e-300  # squares of offsets below it may have lost their digits, and what they weigh is below 1e-147
LN2_HIGH, LN2_LOW = 6.93147180369123816490e-01, 1.90821492927058770002e-10
MANTISSA, ONE, BIAS, BITS = 0x000FFFFFFFFFFFFF, 0x3FF0000000000000, 1023, 52
ROOT_2 = math.sqrt(2.0)
TAN_67, TAN_22 = 1.0 + ROOT_2, ROOT_2 - 1.0  # of three eighths and one eighth of pi
HALF_PI_REST = 6.123233995736766e-17  # of pi / 2, beyond its double


@compiled
def _offsets(
    places: Array, at: Array, start: int, n: int, ratio: Array, over: Array, under: Array, away: Array
) -> None:
    """Fill offsets, squared arguments of the logarithms, and both sides of the tangents, each (3, BLOCK) as one."""
    for i in range(n):
        x, y, z = places[0, start + i] - at[0], places[1, start + i] - at[1], places[2, start + i] - at[2]
        xx, yy, zz = x * x, y * y, z * z
        r = math.sqrt(xx + yy + zz)
        a, b, c = abs(x), abs(y), abs(z)
        ratio[i] = (a + r) * (a + r) / (yy + zz) if yy + zz > TINY else 1.0
        ratio[BLOCK + i] = (b + r) * (b + r) / (xx + zz) if xx + zz > TINY else 1.0
        ratio[2 * BLOCK + i] = (c + r) * (c + r) / (xx + yy) if xx + yy > TINY else 1.0
        over[i], over[BLOCK + i], over[2 * BLOCK + i] = b * c, c * a, a * b
        under[i], under[BLOCK + i], under[2 * BLOCK + i] = a * r, b * r, c * r
        away[i], away[BLOCK + i], away[2 * BLOCK + i] = x, y, z


@compiled
def _split(bits: Whole, mantissa: Whole, exponent: Whole) -> None:
    """Take numbers of one or more apart, as bits."""
    for i in range(len(bits)):
        b = bits[i]
        exponent[i] = (b >> BITS) - BIAS
        mantissa[i] = (b & MANTISSA) | ONE


@compiled
def _logarithms(mantissa: Array, exponent: Whole, out: Array) -> None:
    """Fill the logarithms of numbers that were taken apart."""
    for i in range(len(out)):
        m = mantissa[i]
        upper = m > ROOT_2
        f = (m * 0.5 if upper else m) - 1.0
        k = np.float64(exponent[i]) + (1.0 if upper else 0.0)
        s = f / (2.0 + f)
        z = s * s
        p = 1.818357216161805012e-01 + z * (1.531383769920937332e-01 + z * 1.479819860511658591e-01)
        p = 2.857142874366239149e-01 + z * (2.222219843214978396e-01 + z * p)
        p = z * (6.666666666666735130e-01 + z * (3.999999999940941908e-01 + z * p))
        h = 0.5 * f * f
        out[i] = k * LN2_HIGH - ((h - (s * (h + p) + k * LN2_LOW)) - f)


@compiled
def _angles(over: Array, under: Array, out: Array) -> None:
    """Fill the angles whose tangents are quotients of numbers not below zero; zero where both are."""
    for i in range(len(out)):
        a, b = over[i], under[i]
        steep, middle = a > b * TAN_67, a > b * TAN_22
        top = -b if steep else (a - b if middle else a)
        bottom = a if steep else (a + b if middle else b)
        base = math.pi / 2.0 if steep else (math.pi / 4.0 if middle else 0.0)
        rest = HALF_PI_REST if steep else (HALF_PI_REST / 2.0 if middle else 0.0)
        u = top / (bottom if bottom > 0.0 else 1.0)
        z = u * u
        p = (-8.750608600031904122785e-1 * z - 1.615753718733365076637e1) * z - 7.500855792314704667340e1
        p = (p * z - 1.228866684490136173410e2) * z - 6.485021904942025371773e1
        q = ((z + 2.485846490142306297962e1) * z + 1.650270098316988542046e2) * z + 4.328810604912902668951e2
        q = (q * z + 4.853903996359136964868e2) * z + 1.945506571482613964425e2
        out[i] = base + ((u * (z * p / q) + u) + rest)


@reordered
def _summed(log: Array, angle: Array, away: Array, weight: Array, start: int, n: int) -> tuple[float, float, float]:
    """Weighted sum of the closed forms of a block."""
    gx = gy = gz = 0.0
    for i in range(n):
        x, y, z = away[i], away[BLOCK + i], away[2 * BLOCK + i]
        sx, sy, sz = math.copysign(1.0, x), math.copysign(1.0, y), math.copysign(1.0, z)
        lx, ly, lz = 0.5 * sx * log[i], 0.5 * sy * log[BLOCK + i], 0.5 * sz * log[2 * BLOCK + i]
        w = weight[start + i]
        gx += w * (abs(x) * (sy * sz) * angle[i] - y * lz - z * ly)
        gy += w * (abs(y) * (sz * sx) * angle[BLOCK + i] - z * lx - x * lz)
        gz += w * (abs(z) * (sx * sy) * angle[2 * BLOCK + i] - x * ly - y * lx)
    return gx, gy, gz


@compiled
def vertices(points: Array, places: Array, weight: Array, ends: Array, reach: float, field: Array) -> int:
    """Fill ``field`` (p, 3) with the sum over vertices at ``places`` (3, n), each with its mixed third difference.

    Points from which the farthest corner of the body is not within reach get no number; ``ends`` (2, 3) are its
    smallest and largest coordinates. Return how many such points there are.
    """
    far = 0
    for i in range(len(points)):
        away = 0.0
        for k in range(3):
            away += max(abs(ends[0, k] - points[i, k]), abs(ends[1, k] - points[i, k])) ** 2
        if away <= reach * reach:
            _at(points[i], places, weight, field[i])
        else:
            field[i] = np.nan
            far += 1
    return far


@compiled
def buffers() -> tuple[Array, Array, Array, Array, Array, Array, Whole, Whole]:
    """Return room for one block: ratio, over, under, away, logarithms, angles, mantissas and exponents."""
    size = 3 * BLOCK
    ratio, over, under, away = np.ones(size), np.ones(size), np.ones(size), np.ones(size)
    return ratio, over, under, away, np.empty(size), np.empty(size), np.empty(size, np.int64), np.empty(size, np.int64)


@compiled
def parts(
    places: Array,
    at: Array,
    start: int,
    n: int,
    room: tuple[Array, Array, Array, Array, Array, Array, Whole, Whole],
) -> None:
    """Fill the buffers with what the closed forms of a block of n vertices are made of."""
    ratio, over, under, away, log, angle, mantissa, exponent = room
    _offsets(places, at, start, n, ratio, over, under, away)
    _split(ratio.view(np.int64), mantissa, exponent)
    _logarithms(mantissa.view(np.float64), exponent, log)
    _angles(over, under, angle)


@compiled
def _at(at: Array, places: Array, weight: Array, field: Array) -> None:
    """Fill ``field`` (3,) at one point."""
    room = buffers()
    field[:] = 0.0
    for start in range(0, len(weight), BLOCK):
        n = min(BLOCK, len(weight) - start)
        parts(places, at, start, n, room)
        gx, gy, gz = _summed(room[4], room[5], room[3], weight, start, n)
        field[0] += gx
        field[1] += gy
        field[2] += gz

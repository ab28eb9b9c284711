"""Attraction of cuboids and of bodies on a lattice, without checks.

Points and pieces are in one frame [m]; what comes out is for a gravitational constant of one [kg/m^2], and for the
gradient [kg/m^3], in the order xx, yy, zz, yz, xz, xy. All offsets are taken from the point first: far from the origin
of a frame the closed forms would lose their digits.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...statistics._kernels import compiled

TINY = 1e-300  # squares of offsets below it may have lost their digits, and what they weigh is below 1e-147
NEAR = 8.0  # longest edges from the centre within which the closed form is taken
CLOSE, MIDDLE, FAR = 20.0, 50.0, 600.0  # from where four, three and two points an edge are enough; six before
WORN = 1000.0  # cube of the farthest offset over the volume up to which the closed form keeps 13 digits
DEEP = 256  # pieces that can wait while a cuboid is cut: two a cut, along the longest edge


def _rule(n: int) -> NDArray[np.float64]:
    """Nodes and weights of Gauss and Legendre for an edge from -1/2 to 1/2, shape (2, n)."""
    nodes, weights = np.polynomial.legendre.leggauss(n)
    return np.stack([nodes / 2.0, weights / 2.0])


RULE_2, RULE_3, RULE_4, RULE_6 = _rule(2), _rule(3), _rule(4), _rule(6)


@compiled
def _log(along: float, across_2: float, r: float) -> float:
    """Inverse hyperbolic sine of along over across, the logarithm of the closed forms; zero on the edge itself."""
    if across_2 < TINY:
        return 0.0
    return math.copysign(math.log((abs(along) + r) / math.sqrt(across_2)), along)


@compiled
def _angle(x: float, y: float, z: float, r: float) -> float:
    """Solid angle that a vertex adds; zero in the plane of a face, where it jumps."""
    if x == 0.0:
        return 0.0
    return math.atan(y * z / (x * r))


@compiled
def corner(x: float, y: float, z: float) -> tuple[float, float, float]:
    """Field antiderivative at one vertex, offset from the point: minus the integrals of 1/r over the other two."""
    xx, yy, zz = x * x, y * y, z * z
    r = math.sqrt(xx + yy + zz)
    if r == 0.0:
        return 0.0, 0.0, 0.0
    lx, ly, lz = _log(x, yy + zz, r), _log(y, xx + zz, r), _log(z, xx + yy, r)
    return (
        x * _angle(x, y, z, r) - y * lz - z * ly,
        y * _angle(y, z, x, r) - z * lx - x * lz,
        z * _angle(z, x, y, r) - x * ly - y * lx,
    )


@compiled
def corner_gradient(x: float, y: float, z: float) -> tuple[float, float, float, float, float, float]:
    """Gradient antiderivative at one vertex, offset from the point."""
    xx, yy, zz = x * x, y * y, z * z
    r = math.sqrt(xx + yy + zz)
    if r == 0.0:
        return 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    lx, ly, lz = _log(x, yy + zz, r), _log(y, xx + zz, r), _log(z, xx + yy, r)
    return -_angle(x, y, z, r), -_angle(y, z, x, r), -_angle(z, x, y, r), lx, ly, lz


@compiled
def _closed(c: Any, h: Any, density: float, field: NDArray[np.float64], slope: NDArray[np.float64]) -> None:
    """Add a cuboid by its eight vertices."""
    for i in range(8):
        sx, sy, sz = 2 * (i & 1) - 1, (i & 2) - 1, (i & 4) // 2 - 1
        x, y, z = c[0] + sx * h[0] / 2.0, c[1] + sy * h[1] / 2.0, c[2] + sz * h[2] / 2.0
        w = density * sx * sy * sz
        fx, fy, fz = corner(x, y, z)
        field[0] += w * fx
        field[1] += w * fy
        field[2] += w * fz
        if len(slope) > 0:
            k = corner_gradient(x, y, z)
            for j in range(6):
                slope[j] += w * k[j]


@compiled
def _summed(c: Any, h: Any, density: float, rule: Any, field: NDArray[np.float64], slope: NDArray[np.float64]) -> None:
    """Add a cuboid as points of Gauss and Legendre."""
    n = rule.shape[1]
    mass = density * h[0] * h[1] * h[2]
    for i in range(n):
        x = c[0] + rule[0, i] * h[0]
        for j in range(n):
            y = c[1] + rule[0, j] * h[1]
            w_ij = mass * rule[1, i] * rule[1, j]
            for k in range(n):
                point(x, y, c[2] + rule[0, k] * h[2], w_ij * rule[1, k], field, slope)


@compiled
def point(x: float, y: float, z: float, mass: float, field: NDArray[np.float64], slope: NDArray[np.float64]) -> None:
    """Add a point."""
    rr = x * x + y * y + z * z
    w = mass / (rr * math.sqrt(rr))
    field[0] += w * x
    field[1] += w * y
    field[2] += w * z
    if len(slope) > 0:
        v = 3.0 * w / rr
        slope[0] += v * x * x - w
        slope[1] += v * y * y - w
        slope[2] += v * z * z - w
        slope[3] += v * y * z
        slope[4] += v * x * z
        slope[5] += v * x * y


@compiled
def cuboid(
    c: Any, h: Any, density: float, stack: NDArray[np.float64], field: NDArray[np.float64], slope: NDArray[np.float64]
) -> None:
    """Add a cuboid with centre c, from the point, and edges h: closed near, summed far, cut where neither is right."""
    n = _push(stack, 0, c[0], c[1], c[2], h[0], h[1], h[2])
    while n > 0:
        n -= 1
        x, y, z, a, b, d = stack[n, 0], stack[n, 1], stack[n, 2], stack[n, 3], stack[n, 4], stack[n, 5]
        longest = max(a, b, d)
        away = math.sqrt(x * x + y * y + z * z)
        if away >= FAR * longest:
            _summed((x, y, z), (a, b, d), density, RULE_2, field, slope)
        elif away >= MIDDLE * longest:
            _summed((x, y, z), (a, b, d), density, RULE_3, field, slope)
        elif away >= CLOSE * longest:
            _summed((x, y, z), (a, b, d), density, RULE_4, field, slope)
        elif away >= NEAR * longest:
            _summed((x, y, z), (a, b, d), density, RULE_6, field, slope)
        elif (away + math.sqrt(a * a + b * b + d * d) / 2.0) ** 3 <= WORN * a * b * d or n + 2 > len(stack):
            _closed((x, y, z), (a, b, d), density, field, slope)
        elif a == longest:
            n = _push(stack, n, x - a / 4.0, y, z, a / 2.0, b, d)
            n = _push(stack, n, x + a / 4.0, y, z, a / 2.0, b, d)
        elif b == longest:
            n = _push(stack, n, x, y - b / 4.0, z, a, b / 2.0, d)
            n = _push(stack, n, x, y + b / 4.0, z, a, b / 2.0, d)
        else:
            n = _push(stack, n, x, y, z - d / 4.0, a, b, d / 2.0)
            n = _push(stack, n, x, y, z + d / 4.0, a, b, d / 2.0)


@compiled
def _push(stack: NDArray[np.float64], n: int, x: float, y: float, z: float, a: float, b: float, d: float) -> int:
    """Let a piece wait; return how many do."""
    stack[n, 0], stack[n, 1], stack[n, 2] = x, y, z
    stack[n, 3], stack[n, 4], stack[n, 5] = a, b, d
    return n + 1


@compiled
def cuboids(
    points: NDArray[np.float64],
    centres: NDArray[np.float64],
    edges: NDArray[np.float64],
    density: NDArray[np.float64],
    field: NDArray[np.float64],
    slope: NDArray[np.float64],
) -> None:
    """Fill ``field`` (n, 3), and ``slope`` (n, 6) unless it is (n, 0), with the sum over all pieces."""
    stack = np.empty((DEEP, 6))
    for i in range(len(points)):
        field[i] = 0.0
        slope[i] = 0.0
        x, y, z = points[i, 0], points[i, 1], points[i, 2]
        for j in range(len(centres)):
            c = (centres[j, 0] - x, centres[j, 1] - y, centres[j, 2] - z)
            cuboid(c, (edges[j, 0], edges[j, 1], edges[j, 2]), density[j], stack, field[i], slope[i])


@compiled
def each(
    at: NDArray[np.float64], centres: NDArray[np.float64], edges: NDArray[np.float64], field: NDArray[np.float64]
) -> None:
    """Fill ``field`` (pieces, 3) with what each piece of density one attracts a point with."""
    stack, none = np.empty((DEEP, 6)), np.empty(0)
    h = (edges[0], edges[1], edges[2])
    for j in range(len(centres)):
        field[j] = 0.0
        c = (centres[j, 0] - at[0], centres[j, 1] - at[1], centres[j, 2] - at[2])
        cuboid(c, h, 1.0, stack, field[j], none)


@compiled
def vertices_gradient(
    at: NDArray[np.float64], places: NDArray[np.float64], weight: NDArray[np.float64], slope: NDArray[np.float64]
) -> None:
    """Fill ``slope`` (6,) with the sum over the vertices of a lattice."""
    slope[:] = 0.0
    for i in range(len(weight)):
        k = corner_gradient(places[0, i] - at[0], places[1, i] - at[1], places[2, i] - at[2])
        for j in range(6):
            slope[j] += weight[i] * k[j]

"""Field of cuboids at many points: the vertices of all that are near go through blocks of `_kernels_vertices`.

A block takes vertices of several cuboids and points, so that one cuboid fills it too. What each vertex gives is added
to its point in the order of the cuboids, wherever a block ends: the field at a point does not depend on the others.
"""

from __future__ import annotations

import math

import numpy as np

from ...core.estimate import Array
from ...statistics._kernels import compiled
from ._kernels import DEEP, NEAR, WORN, cuboid
from ._kernels_vertices import BLOCK, Whole, buffers, parts

VERTICES = 8


@compiled
def prisms(points: Array, centres: Array, edges: Array, density: Array, field: Array) -> None:
    """Fill ``field`` (n, 3) at ``points`` (n, 3) with the sum over cuboids."""
    stack, none, origin, room = np.empty((DEEP, 6)), np.empty(0), np.zeros(3), buffers()
    places, weight, owner = np.zeros((3, BLOCK)), np.empty(BLOCK), np.empty(BLOCK, np.int64)
    far = np.zeros_like(field)
    field[:] = 0.0
    n = 0
    for i in range(len(points)):
        for j in range(len(centres)):
            x, y, z = centres[j, 0] - points[i, 0], centres[j, 1] - points[i, 1], centres[j, 2] - points[i, 2]
            a, b, d = edges[j, 0], edges[j, 1], edges[j, 2]
            away, half = math.sqrt(x * x + y * y + z * z), math.sqrt(a * a + b * b + d * d) / 2.0
            if away < NEAR * max(a, b, d) and (away + half) ** 3 <= WORN * a * b * d:
                if n == BLOCK:
                    _added(places, origin, n, weight, owner, room, field)
                    n = 0
                _vertices(x, y, z, a / 2.0, b / 2.0, d / 2.0, density[j], places, weight, n)
                owner[n : n + VERTICES] = i
                n += VERTICES
            else:
                cuboid((x, y, z), (a, b, d), density[j], stack, far[i], none)
    _added(places, origin, n, weight, owner, room, field)
    field += far


@compiled
def _vertices(
    x: float, y: float, z: float, a: float, b: float, d: float, density: float, places: Array, weight: Array, n: int
) -> None:
    """Enter a cuboid of half edges a, b and d: places of its vertices from the point, and their weights."""
    for k in range(VERTICES):
        sx, sy, sz = 2 * (k & 1) - 1, (k & 2) - 1, (k & 4) // 2 - 1
        places[0, n + k], places[1, n + k], places[2, n + k] = x + sx * a, y + sy * b, z + sz * d
        weight[n + k] = density * sx * sy * sz


@compiled
def _added(
    places: Array,
    origin: Array,
    n: int,
    weight: Array,
    owner: Whole,
    room: tuple[Array, Array, Array, Array, Array, Array, Whole, Whole],
    field: Array,
) -> None:
    """Add a block of n vertices to the points that own them."""
    parts(places, origin, 0, n, room)
    angle, log, away = room[5], room[4], room[3]
    for i in range(n):
        x, y, z = away[i], away[BLOCK + i], away[2 * BLOCK + i]
        sx, sy, sz = math.copysign(1.0, x), math.copysign(1.0, y), math.copysign(1.0, z)
        lx, ly, lz = 0.5 * sx * log[i], 0.5 * sy * log[BLOCK + i], 0.5 * sz * log[2 * BLOCK + i]
        w, k = weight[i], owner[i]
        field[k, 0] += w * (abs(x) * (sy * sz) * angle[i] - y * lz - z * ly)
        field[k, 1] += w * (abs(y) * (sz * sx) * angle[BLOCK + i] - z * lx - x * lz)
        field[k, 2] += w * (abs(z) * (sx * sy) * angle[2 * BLOCK + i] - x * ly - y * lx)

"""Attraction of lead: spheres, the best body of cubes, the best body of all, and an extended proof mass.

Point masses attract with ``gamma m x / r^3`` along the input axis x [1]_; a body of a given mass behind the plane
x = d attracts most if it fills ``x / r^3 >= c``. Units are those of the document: cm, g, s; accelerations in ng.

References
----------
.. [1] Reinel, NASA TM X-53857, 1969, source mass.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from inertialcal.core.constants import REINEL_GRAVITATIONAL_CONSTANT, REINEL_GRAVITY

DENSITY = 11.34  # of lead, g/cm^3, as printed
GAMMA, GRAVITY = REINEL_GRAVITATIONAL_CONSTANT.value, REINEL_GRAVITY.value
IN_NG = 1e9 / GRAVITY
INCH = 2.54
CELLS, GRID = 900, (10, 20, 20)
Array = NDArray[np.float64]


def sphere_radius(acceleration: float, gap: float, density: float = DENSITY) -> float:
    """Return the radius of the sphere whose surface is a gap away and that attracts so much [cm]; acceleration in g."""

    def miss(radius: float) -> float:
        mass = 4.0 / 3.0 * math.pi * density * radius**3
        return GAMMA * mass / (radius + gap) ** 2 / GRAVITY - acceleration

    return float(brentq(miss, 1e-6, 1e12, xtol=1e-12, rtol=1e-14))


def sphere_mass(radius: float, density: float = DENSITY) -> float:
    """Return the mass of a sphere [kg]."""
    return float(4.0 / 3.0 * math.pi * density * radius**3 / 1e3)


def point_attraction(mass: float, distance: float) -> float:
    """Return the attraction of a sphere from its centre [g]; mass in kg, distance in cm."""
    return float(GAMMA * 1e3 * mass / distance**2 / GRAVITY)


def best_cells(face: float, cube: float) -> Array:
    """Return the centres of the cells that attract most, first face at a distance, shape (900, 3) [cm]."""
    x, y, z = ((np.arange(n) + 0.5) * cube for n in GRID)
    centres = np.stack(np.meshgrid(x + face, y - y.mean(), z - z.mean(), indexing="ij"), axis=-1).reshape(-1, 3)
    order = np.argsort(-_pull(centres), kind="stable")
    return np.asarray(centres[order[:CELLS]])


def _pull(centres: Array) -> Array:
    return np.asarray(centres[:, 0] / np.sum(centres**2, axis=1) ** 1.5)


def cells_attraction(centres: Array, cube: float, shift: tuple[float, float] = (0.0, 0.0)) -> float:
    """Return the attraction of cells moved along the axis and vertically [ng]."""
    moved = centres + np.array([shift[0], 0.0, shift[1]])
    return float(GAMMA * DENSITY * cube**3 * np.sum(_pull(moved)) * IN_NG)


def largest_attraction(mass: float, face: float) -> float:
    """Return the largest attraction that lead of a mass can have behind a plane [ng]; mass in kg, distance in cm.

    With ``u = (c d^2)^(1/3)`` the body ``x / r^3 >= c`` behind ``x = d`` has, integrated over discs,
    ``V = 2 pi d^3 / 3 [0.4 (u^-4.5 - u^-2) - 0.5 (u^-2 - 1)]`` and ``a = 2 pi gamma rho d [0.4 u^-1.5 + 0.6 u - 1]``.
    """

    def volume(u: float) -> float:
        return float(2.0 * math.pi * face**3 / 3.0 * (0.4 * (u**-4.5 - u**-2.0) - 0.5 * (u**-2.0 - 1.0)))

    needed = 1e3 * mass / DENSITY
    u = float(brentq(lambda s: volume(s) - needed, 1e-4, 1.0 - 1e-12, xtol=1e-15))
    return float(2.0 * math.pi * GAMMA * DENSITY * face * (0.4 * u**-1.5 + 0.6 * u - 1.0) * IN_NG)


def cube_error(ratio: float) -> float:
    """Return by how much less a cube attracts than a point, on its face axis; distance over side of the cube."""
    nodes, weights = np.polynomial.legendre.leggauss(16)
    t, w = 0.5 * nodes, 0.5 * weights
    x, y, z = np.meshgrid(ratio + t, t, t, indexing="ij")
    pull = np.einsum("i,j,k,ijk->", w, w, w, x / (x**2 + y**2 + z**2) ** 1.5)
    return float(1.0 - pull * ratio**2)


def shell_error(distance: float, length: float, diameter: float) -> float:
    """Return by how much more a point attracts a thin-walled cylinder than its centre, on its axis."""
    nodes, weights = np.polynomial.legendre.leggauss(32)
    x = distance + 0.5 * length * nodes
    pull = np.sum(0.5 * weights * x / (x**2 + 0.25 * diameter**2) ** 1.5)
    return float(pull * distance**2 - 1.0)

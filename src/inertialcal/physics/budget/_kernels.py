"""Difference of the attraction of many displaced pieces between two places, draw by draw, without checks."""

from __future__ import annotations

import math

import numba
import numpy as np
from numpy.typing import NDArray

compiled = numba.njit(cache=True, nogil=True, error_model="numpy")


@compiled
def _toward(x: float, y: float, z: float, n: NDArray[np.float64]) -> float:
    """Field of a unit mass at an offset, along n."""
    rr = x * x + y * y + z * z
    along: float = x * n[0] + y * n[1] + z * n[2]
    return along / (rr * math.sqrt(rr))


@compiled
def amplitudes(
    centres: NDArray[np.float64],
    mass: NDArray[np.float64],
    shape: NDArray[np.float64],
    places: NDArray[np.float64],
    turns: NDArray[np.float64],
    axis: NDArray[np.float64],
    density: NDArray[np.float64],
    moved: NDArray[np.float64],
    found: NDArray[np.float64],
) -> None:
    """Fill ``found`` (draws,) with half the difference of the fields along the axis at both stops.

    Shapes: centres (pieces, 3); mass (pieces,); shape (pieces, 2), the field of a piece over that of a point at each
    stop; places (draws, 2, 3), shifts of the body; turns (draws, 3, 3); density (draws, pieces), relative; moved
    (draws, pieces, 3).
    """
    for k in range(len(found)):
        total = 0.0
        T = turns[k]
        for i in range(len(mass)):
            x, y, z = centres[i, 0] + moved[k, i, 0], centres[i, 1] + moved[k, i, 1], centres[i, 2] + moved[k, i, 2]
            u = T[0, 0] * x + T[0, 1] * y + T[0, 2] * z
            v = T[1, 0] * x + T[1, 1] * y + T[1, 2] * z
            w = T[2, 0] * x + T[2, 1] * y + T[2, 2] * z
            near = _toward(u + places[k, 0, 0], v + places[k, 0, 1], w + places[k, 0, 2], axis)
            far = _toward(u + places[k, 1, 0], v + places[k, 1, 1], w + places[k, 1, 2], axis)
            total += mass[i] * density[k, i] * (shape[i, 0] * near - shape[i, 1] * far)
        found[k] = total / 2.0

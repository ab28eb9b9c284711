"""Difference of the attraction of many pieces between two places: its slopes to each, and draws; without checks."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ...statistics._kernels import reordered


@reordered
def amplitudes(
    centres: NDArray[np.float64],
    mass: NDArray[np.float64],
    shape: NDArray[np.float64],
    places: NDArray[np.float64],
    turns: NDArray[np.float64],
    axis: NDArray[np.float64],
    moved: NDArray[np.float64],
    found: NDArray[np.float64],
) -> None:
    """Fill ``found`` (draws, 2): half the difference of the fields at both stops, and what pieces add to it as a root.

    That is the root of the sum of the squares of what each adds.

    Shapes: centres (3, pieces); mass (pieces,); shape (2, pieces), the field of a piece over that of a point at each
    stop; places (draws, 2, 3), shifts of the body; turns (draws, 3, 3); moved (draws, 3, pieces).
    """
    a, b, c = axis[0], axis[1], axis[2]
    for k in range(len(found)):
        T, x, y, z = turns[k], moved[k, 0], moved[k, 1], moved[k, 2]
        x_0, y_0, z_0 = places[k, 0, 0], places[k, 0, 1], places[k, 0, 2]
        x_1, y_1, z_1 = places[k, 1, 0], places[k, 1, 1], places[k, 1, 2]
        total = squares = 0.0
        for i in range(len(mass)):
            p, q, r = centres[0, i] + x[i], centres[1, i] + y[i], centres[2, i] + z[i]
            u = T[0, 0] * p + T[0, 1] * q + T[0, 2] * r
            v = T[1, 0] * p + T[1, 1] * q + T[1, 2] * r
            w = T[2, 0] * p + T[2, 1] * q + T[2, 2] * r
            d, e, f = u + x_0, v + y_0, w + z_0
            g, h, j = u + x_1, v + y_1, w + z_1
            near, far = d * d + e * e + f * f, g * g + h * h + j * j
            one = shape[0, i] * (a * d + b * e + c * f) / (near * math.sqrt(near))
            other = shape[1, i] * (a * g + b * h + c * j) / (far * math.sqrt(far))
            part = 0.5 * mass[i] * (one - other)
            total += part
            squares += part * part
        found[k, 0] = total
        found[k, 1] = math.sqrt(squares)


@reordered
def squares(
    centres: NDArray[np.float64],
    mass: NDArray[np.float64],
    shifts: NDArray[np.float64],
    axis: NDArray[np.float64],
) -> tuple[float, float]:
    """Return sums over pieces, of the square of what each adds to the amplitude, and of its slopes to its place.

    Shapes: centres (pieces, 3); mass (pieces,), with the gravitational constant; shifts (2, 3), of the body.
    """
    a, b, c = axis[0], axis[1], axis[2]
    amounts = slopes = 0.0
    for i in range(len(mass)):
        amount = u = v = w = 0.0
        for k in range(2):
            x, y, z = centres[i, 0] + shifts[k, 0], centres[i, 1] + shifts[k, 1], centres[i, 2] + shifts[k, 2]
            r_2 = x * x + y * y + z * z
            along = a * x + b * y + c * z
            one = (0.5 - k) * mass[i] / (r_2 * math.sqrt(r_2))
            turned = 3.0 * along / r_2
            amount += one * along
            u += one * (a - turned * x)
            v += one * (b - turned * y)
            w += one * (c - turned * z)
        amounts += amount * amount
        slopes += u * u + v * v + w * w
    return amounts, slopes

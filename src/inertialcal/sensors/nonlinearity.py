"""One sensor's curve ``g(u) = u + K1'/2 |u| + K2 u^2 + K3 u^3`` and its inverse.

``u`` is what the sensor feels along its input axis, g the reading that it gives without bias, both in the input
unit; the coefficients are arrays over the k sensors. g has a kink at zero, where the scale factor of one sense
passes into that of the other. The inverse lives on the branch around zero where g rises: beyond its ends, where
the slope comes down to zero, two inputs give one reading.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..core.estimate import Array

LOWEST_SLOPE = 1e-3  # below this the inverse loses more than three digits, and is called not unique
STEPS = 100  # bisection alone reaches the last digit in 60
DIGITS = 4.0 * np.finfo(float).eps  # relative width at which an inverse is final


@dataclass(frozen=True, eq=False)
class Curve:
    """K1' [1], K2 [1/unit], K3 [1/unit^2] of k sensors, each of shape (k,)."""

    asymmetry: Array
    second: Array
    third: Array

    def reading(self, u: Array) -> Array:
        """g(u), shape (n, k)."""
        bent: Array = u * (1.0 + u * (self.second + u * self.third)) + 0.5 * self.asymmetry * np.abs(u)
        return bent

    def slope(self, u: Array) -> Array:
        """dg/du, shape (n, k); at zero the mean of both sides."""
        slope: Array = 1.0 + 0.5 * self.asymmetry * np.sign(u) + u * (2.0 * self.second + 3.0 * self.third * u)
        return slope


def smallest_slope(curve: Curve, ends: Array) -> Array:
    """Smallest slope of each curve between two ends around zero.

    Parameters
    ----------
    ends : ndarray, shape (k, 2)
        Lower end (0 or less) and upper end (0 or more) [unit]; infinite where the curve rises without end.

    Returns
    -------
    ndarray, shape (k,)
        Closed form: the slope is a parabola on each side of zero, smallest at an end, at zero or at its vertex.
    """
    smallest = np.full(len(ends), np.inf)
    with np.errstate(divide="ignore", invalid="ignore"):
        vertex = -curve.second / (3.0 * curve.third)
    for side, end in ((-1.0, ends[:, 0]), (1.0, ends[:, 1])):
        inside = np.isfinite(vertex) & (side * vertex > 0.0) & (side * vertex < side * end)
        for at in (np.zeros_like(end), np.where(np.isfinite(end), end, 0.0), np.where(inside, vertex, 0.0)):
            slope = 1.0 + 0.5 * side * curve.asymmetry + at * (2.0 * curve.second + 3.0 * curve.third * at)
            smallest = np.minimum(smallest, slope)
    return smallest


def rising_branch(curve: Curve) -> Array:
    """Return the ends of the branch around zero where g rises, (k, 2) [unit]; infinite where it never turns."""
    ends = np.empty((len(curve.second), 2))
    for i in range(len(ends)):
        for column, side in ((0, -1.0), (1, 1.0)):
            # side * u = d > 0: slope = c0 + c1 d + c2 d^2
            c0 = 1.0 + 0.5 * side * curve.asymmetry[i]
            ends[i, column] = side * _first_zero(c0, 2.0 * side * curve.second[i], 3.0 * curve.third[i])
    return ends


def _first_zero(c0: float, c1: float, c2: float) -> float:
    """Smallest d >= 0 where c0 + c1 d + c2 d^2 comes down to zero; infinite where it does not.

    The root nearest to zero is 2 c0 / (-c1 + sqrt(c1^2 - 4 c0 c2)): this form keeps its digits and holds for
    c2 = 0 too.
    """
    discriminant = c1 * c1 - 4.0 * c0 * c2
    if c0 <= 0.0:
        return 0.0
    if discriminant < 0.0:
        return np.inf
    denominator = -c1 + np.sqrt(discriminant)
    return 2.0 * c0 / denominator if denominator > 0.0 else np.inf


def inverse(curve: Curve, readings: Array) -> Array:
    """Return u with g(u) = reading on the rising branch around zero, shape (n, k).

    In closed form where K2 and K3 are zero. Else by Newton's method, kept inside a bracket that shrinks at each
    step (bisection where Newton leaves it). Readings beyond the ends of the branch have no inverse there: NaN.

    Parameters
    ----------
    readings : ndarray, shape (n, k)
        Without bias [unit].
    """
    side = np.where(readings < 0.0, -1.0, 1.0)
    rate = 1.0 + 0.5 * side * curve.asymmetry
    u: Array = readings / np.where(rate > 0.0, rate, np.nan)
    bent = np.flatnonzero((curve.second != 0.0) | (curve.third != 0.0))
    if bent.size:
        picked = Curve(curve.asymmetry[bent], curve.second[bent], curve.third[bent])
        u[:, bent] = _by_newton(picked, readings[:, bent], side[:, bent])
    return u


def _by_newton(curve: Curve, readings: Array, side: Array) -> Array:
    branch = rising_branch(curve)
    end = np.where(side < 0.0, branch[:, 0], branch[:, 1])
    near, far = np.zeros_like(readings), np.where(np.isfinite(end), end, 2.0 * readings / endless_slope(curve, branch))
    with np.errstate(invalid="ignore"):
        possible = side * (curve.reading(far) - readings) >= 0.0
    first = side * np.minimum(side * readings / (1.0 + 0.5 * side * curve.asymmetry), side * far)
    u = np.where(possible, first, np.nan)
    moving = possible
    for _ in range(STEPS):
        excess = side * (curve.reading(u) - readings)
        far = np.where(excess >= 0.0, u, far)
        near = np.where(excess <= 0.0, u, near)
        slope = curve.slope(u)
        step = side * excess / np.where(slope > 0.0, slope, np.nan)
        new = u - step
        outside = ~((side * new >= side * near) & (side * new <= side * far))
        new = np.where(outside, 0.5 * (near + far), new)
        still = np.abs(new - u) <= DIGITS * np.abs(new)
        u = np.where(moving, new, u)
        moving = moving & ~still
        if not np.any(moving):
            break
    return u


def endless_slope(curve: Curve, branch: Array) -> Array:
    """Smallest slope of each curve on the sides where it rises without end, shape (k,).

    Twice a reading over it bounds u away from zero there.
    """
    return smallest_slope(curve, np.where(np.isfinite(branch), 0.0, branch))

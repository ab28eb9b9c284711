"""One sensor's curve ``g(u) = u + K1'/2 |u| + K2 u^2 + K3 u^3`` and its inverse.

``u`` is what the sensor feels along its input axis, g the reading that it gives without bias, both in the input
unit; the coefficients are arrays over the k sensors. g has a kink at zero, where the scale factor of one sense
passes into that of the other. The inverse lives on the branch around zero where g rises: beyond its ends, where
the slope comes down to zero, two inputs give one reading.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...core.estimate import Array

LOWEST_SLOPE = 1e-3  # below this the inverse loses more than three digits, and is called not unique
STEPS = 100  # bisection alone reaches the last digit in 60
DIGITS = 4.0 * np.finfo(float).eps  # relative width at which an inverse is final
UNDONE = 1e-9  # of the reading: what the inverse may miss where rounding keeps the steps from coming to rest
HALLEY_STEPS = 2
ROUNDING = 1e-17  # relative error of the last step that rounding hides
STEEP = 0.1  # slope from which on the estimate of that error holds


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
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
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
            # its root nearest to zero is 2 c0 / (-c1 + sqrt(c1^2 - 4 c0 c2)): keeps its digits, and holds for c2 = 0
            c0, c1, c2 = 1.0 + 0.5 * side * curve.asymmetry[i], 2.0 * side * curve.second[i], 3.0 * curve.third[i]
            discriminant = c1 * c1 - 4.0 * c0 * c2
            denominator = -c1 + np.sqrt(discriminant) if discriminant >= 0.0 else 0.0
            root = 2.0 * c0 / denominator if denominator > 0.0 else np.inf
            ends[i, column] = side * (0.0 if c0 <= 0.0 else root)
    return ends


def inverse(curve: Curve, readings: Array) -> Array:
    """Return u with g(u) = reading on the rising branch around zero, shape (n, k).

    In closed form where K2 and K3 are zero. Else as `approached`, and what that leaves open as `bracketed`.
    Readings beyond the ends of the branch have no inverse there: NaN.

    Parameters
    ----------
    readings : ndarray, shape (n, k)
        Without bias [unit].
    """
    side = np.where(readings < 0.0, -1.0, 1.0)
    rate = 1.0 + 0.5 * side * curve.asymmetry
    with np.errstate(over="ignore"):
        u: Array = readings / np.where(rate > 0.0, rate, np.nan)
    bent = np.flatnonzero((curve.second != 0.0) | (curve.third != 0.0))
    if bent.size:
        picked, own = Curve(curve.asymmetry[bent], curve.second[bent], curve.third[bent]), readings[:, bent]
        branch = rising_branch(picked)
        found = approached(picked, branch, own)
        row, sensor = np.nonzero(np.isnan(found))
        if row.size:
            alone = Curve(picked.asymmetry[sensor], picked.second[sensor], picked.third[sensor])
            lowest = endless_slope(picked, branch)[sensor]
            found[row, sensor] = bracketed(alone, branch[sensor], lowest, own[row, sensor])
        u[:, bent] = found
    return u


def approached(curve: Curve, branch: Array, readings: Array) -> Array:
    """Return the inverse by a fixed number of Halley's steps, shape (n, k); NaN where they do not settle.

    The start is the series of the inverse to third order. A result counts where it lies on the branch, on the side
    of its reading, where the slope is not small, and where the error that the last step leaves is lost in rounding:
    with curvature ``c = g''/2``, slope s and step d it is ``(c^2 - K3 s) d^3 / s^2`` [1]_. It settles wherever K2 u is
    within 0.1 and K3 u^2 within 0.02; NaN is no verdict on the reading.

    Parameters
    ----------
    branch : ndarray, shape (k, 2)
        See `rising_branch`.

    References
    ----------
    .. [1] Traub, Iterative Methods for the Solution of Equations, 1964 (Halley's method, asymptotic error constant).
    """
    negative = readings < 0.0
    low, high = np.where(negative, branch[:, 0], 0.0), np.where(negative, 0.0, branch[:, 1])
    with np.errstate(all="ignore"):
        rate = np.where(negative, 1.0 - 0.5 * curve.asymmetry, 1.0 + 0.5 * curve.asymmetry)
        bend = curve.second / rate
        turn = 2.0 * bend * bend - curve.third / rate
        u = readings / rate
        u = u * (1.0 - u * (bend - u * turn))
        for _ in range(HALLEY_STEPS):
            excess = u * (rate + u * (curve.second + u * curve.third)) - readings
            curvature = curve.second + 3.0 * curve.third * u
            slope = rate + u * (curve.second + curvature)
            step = excess * slope / (slope * slope - excess * curvature)
            u = u - step
        left = np.abs((curvature * curvature - curve.third * slope) * step * step * step)
        settled = left <= ROUNDING * np.abs(u * slope * slope)
    final: Array = np.where(settled & (slope >= STEEP) & (u >= low) & (u <= high), u, np.nan)
    return final


def bracketed(curve: Curve, branch: Array, lowest: Array, readings: Array) -> Array:
    """Return the inverse by Newton's method inside a bracket that shrinks at each step, shape (k,) or (n, k).

    Bisection where Newton leaves the bracket: up to the very turn of the curve. NaN beyond the branch, and for
    readings so far from all use (1e20 times where the curve bends) that the steps run out.

    Parameters
    ----------
    branch, lowest : ndarray, shapes (k, 2) and (k,)
        See `rising_branch` and `endless_slope`.
    """
    side = np.where(readings < 0.0, -1.0, 1.0)
    end = np.where(side < 0.0, branch[:, 0], branch[:, 1])
    near = np.zeros_like(readings)
    with np.errstate(all="ignore"):
        far = np.where(np.isfinite(end), end, 2.0 * readings / lowest)
        possible = side * (curve.reading(far) - readings) >= 0.0
        first = side * np.minimum(side * readings / (1.0 + 0.5 * side * curve.asymmetry), side * far)
    u = np.where(possible, first, np.nan)
    moving = possible
    for _ in range(STEPS):
        with np.errstate(all="ignore"):
            excess = side * (curve.reading(u) - readings)
            slope = curve.slope(u)
            step = side * excess / np.where(slope > 0.0, slope, np.nan)
        far = np.where(excess >= 0.0, u, far)
        near = np.where(excess <= 0.0, u, near)
        new = u - step
        outside = ~((side * new >= side * near) & (side * new <= side * far))
        new = np.where(outside, 0.5 * (near + far), new)
        still = np.abs(new - u) <= DIGITS * np.abs(new)
        u = np.where(moving, new, u)
        moving = moving & ~still
        if not np.any(moving):
            break
    with np.errstate(all="ignore"):
        found: Array = np.where(np.abs(curve.reading(u) - readings) <= UNDONE * np.abs(readings), u, np.nan)
    return np.where(moving, found, u)


def endless_slope(curve: Curve, branch: Array) -> Array:
    """Smallest slope of each curve on the sides where it rises without end, shape (k,).

    Twice a reading over it bounds u away from zero there.
    """
    return smallest_slope(curve, np.where(np.isfinite(branch), 0.0, branch))

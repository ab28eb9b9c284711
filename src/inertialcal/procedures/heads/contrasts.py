"""Weights by which heads with known places tell what another place feels, and means of series with slow noise.

The acceleration of a rigid body is linear in the place, ``a(r) = a0 + Gamma r``. With weights that add up to 1, heads
at ``r_i`` tell that at ``p = sum w_i r_i`` exactly, whatever the motion; ``p`` is the place nearest to the wanted one
on the line, plane or space through them, and of all weights for it those with the least sum of squares are taken. For
two heads they are ``1 - s`` and ``s``. What is left, ``Gamma (r - p)``, needs the angular motion.

The uncertainty of a mean in noise that is slow, too, comes from the lowest cosines of the series, which are as many
degrees of freedom [1]_. Of noise that remembers for a time m these have a little less power than frequency zero,
``1 / (1 + (pi j m / T)^2)`` of a record T: it is taken for m = T/20, so that in white noise u is 8 % too large, and at
T/20 right. Noise that remembers longer needs a longer record.

References
----------
.. [1] E. Lazarus, D. J. Lewis, J. H. Stock, M. W. Watson, J. Bus. Econ. Stat. 36 (2018) 541 (equal-weighted cosines).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...core.estimate import Array

THIN = 0.02  # of the largest extent of the heads, below which they do not span a direction
COSINES = 4  # lowest of a series, by which the scatter of its mean is told
MEMORY = 0.05  # of a record, for which noise that loses its memory exponentially may remember


class Weights(NamedTuple):
    """How known heads tell another place."""

    weights: Array  # shape (n,)
    off: Array  # shape (3,): from the place that they tell to the wanted one [m]
    growth: float  # root of the sum of squares of the weights


def weights_for(places: Array, wanted: Array, position_u: float = 0.0) -> Weights:
    """Return the weights of heads for a place.

    Parameters
    ----------
    places : ndarray, shape (n, 3)
        Of the heads [m].
    wanted : ndarray, shape (3,)
        Place [m].
    position_u : float
        Standard uncertainty of places [m]: they span no direction that is thinner than three of it.
    """
    middle = places.mean(axis=0)
    left, extent, right = np.linalg.svd(places - middle, full_matrices=False)
    spans = extent > max(THIN * extent[0], 3.0 * position_u, 1e-9)
    inverse = (left[:, spans] / extent[spans]) @ right[spans]
    weights = 1.0 / len(places) + inverse @ (wanted - middle)
    return Weights(weights, wanted - weights @ places, float(np.sqrt(np.sum(weights**2))))


def redundant(places: Array, position_u: float = 0.0) -> Array:
    """Return combinations of heads that read nothing whatever the motion, orthonormal, shape (k, n)."""
    middle = places.mean(axis=0)
    left, extent, _ = np.linalg.svd(places - middle, full_matrices=False)
    spans = extent > max(THIN * extent[0], 3.0 * position_u, 1e-9)
    seen = np.column_stack([np.ones(len(places)), left[:, spans]])
    return np.asarray(np.linalg.svd(seen, full_matrices=True)[0][:, seen.shape[1] :].T)


def long_run(series: Array) -> tuple[Array, int]:
    """Return the covariance of the means of series, shape (k, k), and its degrees of freedom.

    Parameters
    ----------
    series : ndarray, shape (n, k)
        At equal intervals.
    """
    n, order = len(series), np.arange(1, COSINES + 1)
    phase = np.pi * (np.arange(n) + 0.5) / n
    waves = np.sqrt(2.0 / n) * np.cos(np.outer(order, phase))
    amplitudes = waves @ series
    share = np.sum(1.0 / (1.0 + (np.pi * order * MEMORY) ** 2))
    return np.asarray(amplitudes.T @ amplitudes / share / n), COSINES


class Line(NamedTuple):
    """A fit of several columns on one design."""

    values: Array  # shape (p, k)
    influence: Array  # shape (n, p k): series whose means have the covariance of the values, row by row of these
    rest: Array  # shape (n, k): residuals


def fitted(design: Array, series: Array) -> Line:
    """Return least squares of series, shape (n, k), on a design, shape (n, p)."""
    values = np.linalg.lstsq(design, series, rcond=None)[0]
    rest = series - design @ values
    gain = design @ np.linalg.inv(design.T @ design / len(design))
    influence = gain[:, :, None] * rest[:, None, :]
    return Line(np.asarray(values), np.asarray(influence.reshape(len(design), -1)), np.asarray(rest))

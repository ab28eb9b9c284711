"""Noise of a rate sensor as a logger that averages sees it.

References
----------
.. [1] IEEE Std 952-1997, Annex C: rate white noise, rate random walk.
"""

from __future__ import annotations

import numpy as np

from ...core.estimate import Array


def white(std: float, n: int, k: int, rng: np.random.Generator) -> Array:
    """Return independent noise of n averages of k sensors, shape (n, k), with the standard deviation of one."""
    return rng.normal(0.0, std, (n, k))


def random_walk(
    coefficient: float, n: int, k: int, interval: float, averaging: float, rng: np.random.Generator
) -> Array:
    """Return averages of a random walk of the rate that starts at zero.

    Between two times the walk has the variance ``coefficient^2`` times what has passed. Its mean over a window is
    the mean of both ends and what the bridge between them adds, of variance ``coefficient^2 averaging / 12``.

    Parameters
    ----------
    coefficient : float
        K [unit/sqrt(s)].
    n, k : int
        Averages, and sensors.
    interval, averaging : float
        Time from average to average, and length of each [s].
    rng : numpy.random.Generator
        All draws come from it.

    Returns
    -------
    ndarray, shape (n, k)
    """
    inside = rng.normal(0.0, coefficient * np.sqrt(averaging), (n, k))
    between = rng.normal(0.0, coefficient * np.sqrt(max(interval - averaging, 0.0)), (n, k))
    start = np.cumsum(inside + between, axis=0) - inside - between
    bridge = rng.normal(0.0, coefficient * np.sqrt(averaging / 12.0), (n, k))
    return np.asarray(start + 0.5 * inside + bridge)

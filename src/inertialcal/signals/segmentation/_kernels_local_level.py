"""Compiled loops of the local level model: arrays in, preallocated arrays out, no checks."""

from __future__ import annotations

import numpy as np

from ...core.estimate import Array
from ...statistics._kernels import compiled

__all__ = ["fill_scores", "fill_whitened"]


@compiled
def fill_whitened(columns: Array, weight: Array, walk: float, white: Array, gain: Array, spread: Array) -> float:
    """Fill the innovations of each column over their scale, and return the sum of the logarithms of their variances.

    ``columns``, ``white`` (n, m); ``weight`` (n): variance of each sample over that of a usual one, 0 where it is
    missing; ``walk``: variance of a step of the level over the same; ``gain``, ``spread`` (n): of the filter, spread 0
    where there is no innovation. The first sample that is there sets the level.
    """
    n, m = columns.shape
    level = np.zeros(m)
    variance, logarithms = -1.0, 0.0
    for i in range(n):
        gain[i] = spread[i] = 0.0
        for j in range(m):
            white[i, j] = 0.0
        if variance >= 0.0:
            variance += walk
        if weight[i] <= 0.0:
            continue
        if variance < 0.0:
            variance = weight[i]
            for j in range(m):
                level[j] = columns[i, j]
            gain[i] = 1.0
            continue
        total = variance + weight[i]
        k = variance / total
        root = np.sqrt(total)
        for j in range(m):
            innovation = columns[i, j] - level[j]
            white[i, j] = innovation / root
            level[j] += k * innovation
        gain[i], spread[i] = k, root
        variance *= 1.0 - k
        logarithms += np.log(total)
    return logarithms


@compiled
def fill_scores(white: Array, gain: Array, spread: Array, score: Array, information: Array) -> None:
    """Fill, for a step of the level at each sample, its product with each whitened column (n, m), and with itself (n).

    The step begins with the sample; the backward pass of the smoother adds what later samples say of it.
    """
    n, m = white.shape
    own = np.zeros(m)
    square = 0.0
    for i in range(n - 1, -1, -1):
        if spread[i] > 0.0:
            rest = 1.0 - gain[i]
            for j in range(m):
                own[j] = white[i, j] / spread[i] + rest * own[j]
            square = 1.0 / spread[i] ** 2 + rest**2 * square
        elif gain[i] > 0.0:  # the first sample: the level takes all of the step
            for j in range(m):
                own[j] = 0.0
            square = 0.0
        for j in range(m):
            score[i, j] = own[j]
        information[i] = square

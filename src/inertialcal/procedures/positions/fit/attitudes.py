"""Attitude through rotations: where the gyros carry vectors of the body, and what errors of the rate do to it.

A small error dw(t) of the rate turns the attitude at the end by the integral of C(end, t) dw(t), with C(end, t) taking
vectors from the body at t to the body at the end. An error that is a matrix times some signal needs one such integral
for each axis of the rate and each component of the signal.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ....core.estimate import Array
from ..readings import Rotation
from ._kernels_transitions import through


@dataclass(frozen=True, eq=False)
class Packed:
    """Samples of all rotations in a row."""

    z: Array  # shape (n, 3): readings of the gyros less bias and g-sensitivity [rad/s]
    f: Array  # shape (n, 3): specific force [m/s^2]
    h: Array  # shape (n,): time to the next sample [s], 0 from the last of a rotation
    first: NDArray[np.int64]  # shape (k + 1,): where each begins, and the end

    @cached_property
    def squares(self) -> Array:
        """Sums of h^2, shape (k,) [s^2]: the variance of an integral over that of a sample."""
        return np.array([np.sum(self.h[a:b] ** 2) for a, b in pairwise(self.first)])

    @cached_property
    def sums(self) -> tuple[Array, Array, Array]:
        """Integrals of z (k, 3), f (k, 3) and one (k,) over each rotation, by trapezoids."""
        total, force, time = [], [], []
        for a, b in pairwise(self.first):
            h = self.h[a : b - 1]
            weight = 0.5 * (np.append(h, 0.0) + np.append(0.0, h))
            total.append(weight @ self.z[a:b])
            force.append(weight @ self.f[a:b])
            time.append(weight.sum())
        return np.array(total).reshape(-1, 3), np.array(force).reshape(-1, 3), np.array(time)


def packed(rotations: Sequence[Rotation], z: Sequence[Array], f: Sequence[Array]) -> Packed:
    """Return the samples of rotations in a row."""
    sizes = np.array([0, *(len(one.seconds) for one in rotations)])
    h = [np.append(np.diff(one.seconds), 0.0)[: len(one.seconds)] for one in rotations]
    empty = np.empty((0, 3))
    return Packed(
        np.concatenate([empty, *z]),
        np.concatenate([empty, *f]),
        np.concatenate([np.empty(0), *h]),
        np.cumsum(sizes).astype(np.int64),
    )


def carried(samples: Packed, W: Array, signal: Array | None = None) -> tuple[Array, Array]:
    """Return what rotations do to vectors, and the integrals of C(end, t) times a signal.

    Parameters
    ----------
    samples : Packed
        Rotations.
    W : ndarray, shape (3, 3)
        The rate is W z.
    signal : ndarray, shape (n, m), optional
        On the clock of the samples.

    Returns
    -------
    C : ndarray, shape (k, 3, 3)
        Takes vectors from the body at the start to the body at the end.
    integrals : ndarray, shape (k, 3, 3, m)
        [:, :, j, l] for component l of the signal along axis j.
    """
    n, k = len(samples.z), len(samples.first) - 1
    weighted, C = np.empty((n, 9)), np.empty((k, 3, 3))
    through(np.ascontiguousarray(samples.z @ W.T), samples.h, samples.first, weighted, C)
    if signal is None:
        return C, np.empty((k, 3, 3, 0))
    parts = [weighted[a:b].T @ signal[a:b] for a, b in pairwise(samples.first)]
    at_start = np.array(parts).reshape(k, 3, 3, signal.shape[1])  # [:, j, i, l]: i at the start
    return C, np.einsum("kpi,kjil->kpjl", C, at_start)

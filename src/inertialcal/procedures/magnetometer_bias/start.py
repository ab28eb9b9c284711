"""Where the search for the biases begins: magnitudes for the magnetometer, pairs of readings for the gyro.

The magnitude of the field does not depend on attitude: |B - m|^2 = |R|^2 is linear in m and m^2. Nor does the angle
between the field now and a lag later, both in the body as the gyro has turned it: with P the rotation between,

    (B' - m) . P(b) (B - m) = R' . R

A short lag holds for a large bias, a long one tells it better: lags grow, each from where the last one ended. Where
noise leads a short one astray, the search begins with a longer one: the start is the one that leaves least. These are
the residuals that the literature estimates the bias from; `arcs` makes better use of the same readings.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...core.estimate import Array
from .arcs import Arc, turned

LAGS = (15.0, 30.0, 60.0, 120.0, 300.0)  # [s]
ROUNDS = 8
BEGINNINGS = 3  # shortest lags that the search may begin with
SHARE = 0.3  # of the readings, that must have a later one in their arc: a few pairs tell three unknowns badly


def by_magnitude(field: Array, reference: Array) -> Array:
    """Return the bias of a magnetometer [T], shape (3,), from magnitudes alone."""
    squares = np.sum(field**2, axis=1) - np.sum(reference**2, axis=1)
    scale = float(np.sqrt(np.mean(field**2)))
    design = np.column_stack([2.0 * field / scale, -np.ones(len(field))])
    return np.asarray(np.linalg.lstsq(design, squares / scale, rcond=1e-12)[0][:3])


def by_pairs(arcs: Sequence[Arc], offset: Array, lags: Sequence[float] = LAGS) -> tuple[Array, float]:
    """Return the bias of a gyro [rad/s], shape (3,), from pairs of readings; and the rms of what they leave.

    The rms is over the mean square of the field (1).

    Parameters
    ----------
    arcs : sequence of Arc
        Pairs lie within one.
    offset : ndarray, shape (3,)
        Bias of the magnetometer [T].
    lags : sequence of float
        Between the two readings of a pair [s], one after the other.
    """
    bias, left = np.zeros(3), np.inf
    size = float(np.mean([np.mean(np.sum(one.reference**2, axis=1)) for one in arcs]))
    for lag in lags:
        for _ in range(ROUNDS):
            rows, values = [], []
            for one, turns in zip(arcs, turned(arcs, bias), strict=True):
                step = max(round(lag / max(float(np.median(np.diff(one.times))), 1e-9)), 1) if len(one.times) > 1 else 1
                if step >= len(one.times):
                    continue
                back = np.transpose(turns, (0, 2, 1))
                seen = np.einsum("kij,kj->ki", back, one.field - offset)
                swept = np.cumsum(back * np.diff(one.times, prepend=0.0)[:, None, None], axis=0)
                early, late = seen[:-step], seen[step:]
                values.append(
                    np.sum(one.reference[:-step] * one.reference[step:], axis=1) - np.sum(early * late, axis=1)
                )
                rows.append(np.einsum("ki,kij->kj", np.cross(early, late), swept[step:] - swept[:-step]))
            if sum(map(len, values)) < SHARE * sum(len(one.times) for one in arcs):
                break
            design, residual = np.concatenate(rows), np.concatenate(values)
            step_of = np.linalg.lstsq(design, residual, rcond=1e-9)[0]
            bias = bias + step_of
            left = float(np.sqrt(np.mean((residual - design @ step_of) ** 2))) / size
            if float(np.linalg.norm(step_of)) * lag < 1e-6:
                break
    return bias, left


def best_start(arcs: Sequence[Arc], offset: Array) -> Array:
    """Return the bias of a gyro [rad/s], shape (3,), by the beginning that leaves least at the longest lag."""
    tried = [by_pairs(arcs, offset, LAGS[first:]) for first in range(BEGINNINGS)]
    return min(tried, key=lambda one: one[1])[0]

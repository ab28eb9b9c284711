"""Bias of the next record: how far from the bias of these rests it may lie, by the slow noise of this record alone.

The bias of one record is the mean over its rests of a bias that wanders. What it was between the rests, before and
after nobody saw; that of the next record differs by the wander from one to the other. Residuals of the positions,
in the order of time, show its size and how it grows with the time between them::

    y = X c + known errors + slow          slow = s (share_p I + share_f K_f + share_w K_w)

with iid scatter of positions, 1/f noise and a random walk, averaged over each rest by their generalised covariances
(``statistics.slow_noise``), each of one mean variance on the contrasts that X does not see. The variance of
``bias of these rests - bias of the next record`` is that of a contrast of rests and of one window more, as long as this
record, which begins ten record lengths after it began (three for the random walk: what one record shows of it says next
to nothing of ten). It is found for every size s and every mixture of a grid, and
averaged with their restricted likelihoods (a few positions hold too few degrees of freedom for one best value) [1]_.

What is assumed: the noise goes on as it is, without power-down between. Before the readings, sizes have a density of
s^-0.3, from a twentieth of the known noise to 30 times the largest residual; two ninths of the mixtures are of
positions alone, two of positions and 1/f noise alike, four of 1/f noise, one of a random walk. What the uncertainty
means: the median standard deviation of the mixture, with the degrees of freedom (one at least) whose t gives its 95 %
interval: the wander from this record to the next and the noise of this record's means.

Three ways in which real data break it (figures in the manual): a random walk of the rate, or a bias that returns to
its mean within a few record lengths, goes on (held by the record that follows, not ten record lengths later); the bias
drifts on with temperature (not held beyond the record that follows); the sensor is switched off between (turn-on bias
is not seen at all).

References
----------
.. [1] G. E. P. Box and G. C. Tiao, Bayesian Inference in Statistical Analysis, 1973, ch. 5 (variance components).
.. [2] G. Matheron, Adv. Appl. Prob. 5 (1973) 439 (generalised covariance of intrinsic random functions).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ....core.estimate import Array
from ....core.key import Reason
from ....statistics.intervals import student_of_mixture
from ....statistics.slow_noise import FLICKER, WALK, window_covariance
from ..readings import Readings

# Record lengths from the beginning of this record to that of the next, of 1/f noise and of a walk
AHEAD = ((FLICKER, 10.0), (WALK, 3.0))
SHARES = np.array([[1.0, 0.0, 0.0], [0.5, 0.5, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])  # positions, flicker, walk
BEFORE = np.array([0.5, 0.5, 1.0, 0.25])  # how likely each is before the readings
POWER = 0.7  # of a size: its weight an equal step of its logarithm
STEP = 0.25  # of that logarithm
SMALLEST, LARGEST = 0.05, 30.0  # size, of the noise that is known and of the largest residual
FEWEST = 4  # contrasts that show a slow noise
EXACT = 1e-6  # of the residuals: least noise that is known

UNJUDGED = Reason("not_judged", "the scatter between positions is assumed or rests on a prior: no wander shows")
SECONDS = 1e-9  # of a nanosecond
NO_TIME = Reason("no_time", "the readings have no time stamps: nothing says how the bias wanders from rest to rest")
FEW = Reason("too_few_positions", f"fewer than {FEWEST} readings beyond the unknowns: they do not show how it wanders")


@dataclass(frozen=True, eq=False)
class Rests:
    """When the rests were, and how long a record is [s]."""

    start: Array  # shape (m,)
    stop: Array  # shape (m,)
    length: float

    def take(self, kept: NDArray[np.bool_]) -> Rests:
        """Return some of them."""
        return Rests(self.start[kept], self.stop[kept], self.length)

    @cached_property
    def kernels(self) -> Array:
        """Covariances of positions, 1/f noise and walk in the rests and the next record, shape (3, m + 1, m + 1)."""
        first = float(self.start.min())
        found = np.array([np.eye(len(self.start) + 1)] * 3)
        for k, (noise, ahead) in enumerate(AHEAD, 1):
            start = np.append(self.start, first + ahead * self.length)
            stop = np.append(self.stop, first + (ahead + 1.0) * self.length)
            found[k] = window_covariance(start, stop, noise)
        return found

    @property
    def weights(self) -> Array:
        """Part of each in the time at rest, shape (m,)."""
        return np.asarray((self.stop - self.start) / np.sum(self.stop - self.start))


def rests_of(readings: Readings) -> Rests | None:
    """Return the rests of readings; None where they have no time.

    Recordings that overlap have clocks that begin anew: one follows the other.
    """
    if readings.start_ns is None or readings.stop_ns is None:
        return None
    own = np.array(readings.recordings or (0,) * len(readings.start_ns))
    first = readings.start_ns.min()
    start, stop = ((one - first) * SECONDS for one in (readings.start_ns, readings.stop_ns))
    if not np.all(stop > start):
        return None
    lengths, end = [], -np.inf
    for k in sorted(set(own.tolist()), key=lambda k: (float(start[own == k].min()), k)):
        here = own == k
        lengths.append(float(stop[here].max() - start[here].min()))
        later = max(end - float(start[here].min()), 0.0)
        start[here] += later
        stop[here] += later
        end = float(stop[here].max())
    return Rests(start, stop, float(np.mean(lengths)))


@dataclass(frozen=True, eq=False)
class Wander:
    """What a bias of each axis in each rest does to n readings, and how a fit leaves them."""

    projector: Array  # shape (n, n): the residuals weighted by the inverse of their covariance, per reading
    residuals: Array  # shape (n,)
    free: int  # rank of the projector: readings less unknowns
    between: float  # variance of the scatter between positions in that covariance
    place: NDArray[np.int64]  # shape (n,): rest of each
    loading: Array  # shape (n, 3): of each by the bias of x, y, z


@dataclass(frozen=True, eq=False)
class Slow:
    """Slow noise of a record: mixtures and sizes, with how likely each is."""

    wander: Wander
    kernels: Array  # shape (3, m + 1, m + 1): positions, flicker, walk; of the rests and the next record
    probability: Array  # shape (mixtures, sizes)
    variances: Array  # shape (sizes,)

    @property
    def of_positions(self) -> float:
        """Part of the scatter that is one of positions, each anew."""
        return float(self.probability.sum(axis=1) @ SHARES[:, 0])

    def next_record(self, gain: Array, axis: int, noise: float) -> tuple[float, float]:
        """Return the uncertainty of the bias of an axis as that of the next record, and its degrees of freedom.

        Parameters
        ----------
        gain : ndarray, shape (n,)
            Bias of these rests per reading.
        axis : int
            Number of the axis.
        noise : float
            Variance of that bias by all but the scatter between positions.
        """
        place, loading = self.wander.place, self.wander.loading
        grown = [float(gain @ gain)]
        for kernel in self.kernels[1:]:
            between = (loading @ loading.T) * kernel[np.ix_(place, place)]
            onward = gain @ (loading[:, axis] * kernel[place, -1])
            grown.append(float(gain @ between @ gain - 2.0 * onward + kernel[-1, -1]))
        variance = noise + np.outer(np.maximum(SHARES @ grown, 0.0), self.variances)
        return student_of_mixture(np.sqrt(variance).ravel(), self.probability.ravel())


def slow_noise_of(wander: Wander, rests: Rests) -> Slow | None:
    """Return the slow noise that the residuals of a fit show; None where there are too few of them."""
    if wander.free < FEWEST:
        return None
    blind = np.linalg.eigh(wander.projector)[1][:, -wander.free :]  # contrasts that the design does not see
    kernels = rests.kernels
    y = blind.T @ wander.residuals
    known = np.linalg.inv(blind.T @ wander.projector @ blind) - wander.between * np.eye(len(y))
    exact = EXACT * float(np.mean(y**2))
    level, axes = np.linalg.eigh(0.5 * (known + known.T))
    level = np.maximum(level, exact)
    white = (axes / np.sqrt(level)).T
    largest, y = float(np.max(np.abs(y))), white @ y
    place, loading = wander.place, wander.loading
    between = (loading @ loading.T) * kernels[1:, place[:, None], place]
    seen = np.concatenate([(blind.T @ blind)[None], blind.T @ between @ blind])
    size = np.trace(seen, axis1=1, axis2=2) / len(y)
    usual = float(np.sqrt(np.median(level)))
    top = LARGEST * max(usual, largest)
    sizes = np.exp(np.arange(np.log(SMALLEST * usual), np.log(top) + STEP, STEP))
    mixed = np.tensordot(SHARES / size, seen, axes=1)
    values, vectors = np.linalg.eigh(white @ mixed @ white.T)  # of each mixture
    total = 1.0 + sizes[:, None] ** 2 * np.maximum(values, 0.0)[:, None]
    logs = -0.5 * np.sum(np.log(total) + (y @ vectors)[:, None] ** 2 / total, axis=2)
    weight = logs + POWER * np.log(sizes) + np.log(BEFORE)[:, None]
    probability = np.exp(weight - weight.max())
    return Slow(wander, kernels / size[:, None, None], probability / probability.sum(), sizes**2)


@dataclass(frozen=True, eq=False)
class NextRecord:
    """Standard uncertainty of the bias of x, y, z as that of the next record [input unit], and degrees of freedom."""

    u: Array  # shape (3,)
    dof: Array  # shape (3,)

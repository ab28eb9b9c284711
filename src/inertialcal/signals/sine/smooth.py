"""Weights that no smooth drift enters, for the line of a drive: one stretch of a record.

The readings are the drive, its quadrature, a cubic and a smooth drift, in white noise::

    x = X b + d + e        X = [drive, quadrature, Legendre 0 - 3]
    W = (X' V^-1 X)^-1 X' V^-1        V = I + 1e8 exp(-(t - t')^2 / 2 l^2)        l = 1.25 periods of the drive

V is fixed: it is a prior on drift [1]_ far above any that is met, not a fit of it, so W does not depend on the readings
and the estimate is linear in them. Of a drift of 1000 times the response over 100 dwells of a quarter of a period, W
lets pass 4e-5 of the response for an exponential of a tenth of the record, 1e-4 for one of a thirtieth, 1e-3 for a sine
of three periods of the drive and nothing of a cubic; a line and 20 cosines let 0.5, 1.4 and 0.8 pass. The price is at
the ends, where drift and drive are hardest to separate: the uncertainty is 1.05 times that of white noise whose drift
is known with 25 periods, 1.14 with 10, 1.01 with 100.

Where real data break it: a drift with a kink or a corner (W passes 20 % at 1000 times the response), a sine of less
than two periods of the drive, a drift that follows the drive. The first is found where runs repeat it, the second by
`weights` of another length, the third by nothing but runs of another phase.

Contrasts are sums of readings in which neither the drive nor any smooth drift has a part: they show the noise alone.

References
----------
.. [1] C. E. Rasmussen and C. K. I. Williams, Gaussian Processes for Machine Learning, MIT Press 2006, 2.2 and 2.7.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property, lru_cache

import numpy as np
from scipy import linalg

from ...core.errors import DataError
from ...core.estimate import Array
from ...statistics.slow_noise import walk_covariance
from ..blas import one_blas_thread

LENGTH = 1.25  # of the prior of drift [periods of the drive]
OTHERS = (1.0, 1.5)  # lengths, that must give the same
STRENGTH = 1e8  # variance of drift over that of white noise
DEGREE = 3  # of the polynomial
NARROW = 8.7  # standard deviations, from which a Gaussian is below rounding
BLIND = 1e-2  # variance of drift in a contrast, over that of white noise
DISTINCT = 1e-6  # part of the drive that drift must leave
BAND = 4.0  # of the frequency of the drive: highest of contrasts of a sine
SAMPLED = 8.0  # readings a period of a sine, from which that is below half of their frequency
COARSE = 0.4  # of a period: steps of readings, from which drift in contrasts has the length below
KEPT = 16  # stretches that are remembered, of 2 MB each
LONG = 2.0  # [periods]: else two readings a period would leave hardly a contrast


@dataclass(frozen=True, eq=False)
class Stretch:
    """Readings of a record that are fitted at once."""

    times: Array  # middles [periods of the drive], shape (n,)
    line: Array  # drive and, where there is one, its quadrature, shape (n, 1 or 2)
    step: float  # of the readings [periods]
    _weights: dict[float, Array] = field(init=False, default_factory=dict[float, Array], repr=False)

    @one_blas_thread()
    def weights(self, length: float = LENGTH, noise: Array | None = None) -> Array:
        """Return the weights of drive and quadrature, shape (1 or 2, n).

        Parameters
        ----------
        length : float
            Of the prior of drift [periods of the drive].
        noise : ndarray, shape (n, n), optional
            Covariance of the noise, white by default.

        Raises
        ------
        DataError
            ``rank_deficient`` if drive and drift cannot be separated at these readings.
        """
        columns = np.column_stack([self.line, self._trend])
        root = self._root if length == LENGTH and noise is None else self._rooted(length, noise)
        white = linalg.solve_triangular(root, columns, lower=True)
        size = np.linalg.norm(white, axis=0)
        basis, upper = np.linalg.qr(white / size)
        count = self.line.shape[1]
        apart = np.abs(np.diag(np.linalg.qr(np.column_stack([white[:, count:], white[:, :count]]) / np.concatenate(
            [size[count:], size[:count]]), mode="r")))  # fmt: skip
        if not (apart.min() > DISTINCT and np.linalg.norm(white[:, 0]) > DISTINCT * np.linalg.norm(self.line[:, 0])):
            what = "drive and drift cannot be separated at these samples"
            raise DataError(what, do="Record longer, or with a drive that changes more often", code="rank_deficient")
        found = linalg.solve_triangular(upper, basis.T)[:count] / size[:count, None]
        return np.asarray(linalg.solve_triangular(root, found.T, lower=True, trans="T").T)

    def weights_of_drift(self, length: float) -> Array:
        """Return the weights in white noise for a length of the prior of drift; taken once."""
        if length not in self._weights:
            self._weights[length] = self.weights(length)
        return self._weights[length]

    @cached_property
    @one_blas_thread()
    def drift_basis(self) -> Array:
        """Orthonormal columns that every smooth drift is a sum of, noise apart, shape (n, p)."""
        trend = np.linalg.qr(self._trend)[0]
        length = LENGTH if self.step < COARSE else LONG
        axes, sizes, _ = np.linalg.svd(self._kernel_root(length), full_matrices=False)
        slow = axes[:, sizes > np.sqrt(BLIND / STRENGTH)]
        left, spread, _ = np.linalg.svd(slow - trend @ (trend.T @ slow), full_matrices=False)
        return np.column_stack([trend, left[:, spread > DISTINCT]])

    @cached_property
    @one_blas_thread()
    def contrasts(self) -> Array:
        """Orthonormal weights of sums without drive and drift, shape (n, m)."""
        line = self.line - self.drift_basis @ (self.drift_basis.T @ self.line)
        seen = np.column_stack([self.drift_basis, line / np.linalg.norm(self.line, axis=0)])
        if self.line.shape[1] < 2 or SAMPLED * self.step > 1.0:
            left, spread, _ = np.linalg.svd(seen, full_matrices=True)
            return np.asarray(left[:, int(np.sum(spread > DISTINCT)) :])
        left, spread, _ = np.linalg.svd(seen, full_matrices=False)
        seen = left[:, spread > DISTINCT]
        lines = np.arange(1, int(BAND * np.ptp(self.times)) + 1) / np.ptp(self.times)
        angle = 2.0 * np.pi * np.outer(self.times, lines)
        waves = np.hstack([np.cos(angle), np.sin(angle)])
        waves -= seen @ (seen.T @ waves)
        powers, axes = np.linalg.eigh(waves.T @ waves)
        kept = powers > 0.3**2 * powers[-1]  # far above what squares lose
        return np.asarray(waves @ (axes[:, kept] / np.sqrt(powers[kept])))

    @cached_property
    @one_blas_thread()
    def uncorrelated(self) -> tuple[Array, Array]:
        """Contrasts that a walk does not correlate, shape (n, m), and the variance that it gives each, shape (m,)."""
        sums = self.contrasts
        walks, axes = np.linalg.eigh(sums.T @ self.walk @ sums)
        return sums @ axes, walks

    @cached_property
    def walk(self) -> Array:
        """Covariance of a random walk, of unit step from reading to reading, shape (n, n)."""
        return np.asarray(walk_covariance(self.times / self.step, 1.0))

    @one_blas_thread()
    def drift(self, rest: Array) -> Array:
        """Return the drift in readings less the drive, shape (n, k)."""
        root, basis = self._root, self._white_trend
        y = linalg.solve_triangular(root, rest, lower=True)
        left = linalg.solve_triangular(root, y - basis @ (basis.T @ y), lower=True, trans="T")
        return np.asarray(rest - left)  # V^-1 of the residual is what is neither trend nor drift

    @cached_property
    def _white_trend(self) -> Array:
        """Orthonormal columns of the trend in whitened readings, shape (n, p)."""
        white = linalg.solve_triangular(self._root, self._trend, lower=True)
        return np.linalg.qr(white / np.linalg.norm(white, axis=0))[0]

    @cached_property
    def _root(self) -> Array:
        return self._rooted(LENGTH, None)

    def _rooted(self, length: float, noise: Array | None) -> Array:
        """Return the lower triangle whose product with its transpose is V, shape (n, n)."""
        own = np.eye(len(self.times)) if noise is None else noise
        return np.asarray(linalg.cholesky(own + STRENGTH * self._kernel(length), lower=True))

    def _kernel(self, length: float) -> Array:
        return np.asarray(np.exp(-0.5 * (np.subtract.outer(self.times, self.times) / length) ** 2))

    def _kernel_root(self, length: float) -> Array:
        """Return a matrix whose product with its transpose is the kernel, shape (n, p).

        The kernel is the sum of its Fourier series over a period so long that it comes back as nothing: of the square
        root small axes keep their digits, which the kernel itself would lose to rounding.
        """
        period = np.ptp(self.times) + NARROW * length
        lines = 2.0 * np.pi / period * np.arange(int(np.ceil(NARROW * period / (2.0 * np.pi * length))) + 1)
        power = np.sqrt(2.0 * np.pi) * length / period * np.exp(-0.5 * (lines * length) ** 2)
        power[1:] *= 2.0
        angle = np.outer(self.times - self.times[0], lines)
        waves = np.hstack([np.cos(angle), np.sin(angle[:, 1:])])
        return np.asarray(waves * np.sqrt(np.concatenate([power, power[1:]])))

    @property
    def _trend(self) -> Array:
        place = 2.0 * (self.times - self.times[0]) / np.ptp(self.times) - 1.0
        return np.asarray(np.polynomial.legendre.legvander(place, DEGREE))


def stretch_of(times: Array, line: Array, step: float) -> Stretch:
    """Return a stretch, shapes as `Stretch` has them; the same for the same values, as what it works out is dear."""
    return _stretch(times.tobytes(), line.tobytes(), line.shape[1], step)


@lru_cache(KEPT)
def _stretch(times: bytes, line: bytes, columns: int, step: float) -> Stretch:
    return Stretch(np.frombuffer(times), np.frombuffer(line).reshape(-1, columns), step)

"""Noise slower than a mean: white and 1/f noise of a record, and what they do to differences of means.

The record is cut into blocks of equal length, and its block means are taken as::

    y = X a + white + flicker        S(f) = w + h / f  [unit^2/Hz], one-sided

X holds what is fitted beside: a level, and steps or drifts that the test itself makes. Noise of 1/f has no finite
variance, but every contrast (weights that X does not see, as a difference of means) has one, with the generalised
covariance ``-h ln|tau|``, averaged over both blocks. Its two parameters are found by restricted maximum likelihood:
only contrasts enter, so it does not matter what X takes away, and the lowest frequencies count without the leakage
that a periodogram of so few periods has.

The flicker part may come out a little negative where there is none: cut at zero it would make every uncertainty of a
white record too large. What is assumed: the noise is stationary over the record and normal; nothing in the record but X
and noise.

What the uncertainty means: the standard deviation of a contrast of this record's noise; its degrees of freedom say how
well the two parameters are known (Satterthwaite, from their information matrix).

References
----------
.. [1] D. A. Harville, J. Am. Stat. Assoc. 72 (1977) 320 (restricted maximum likelihood).
.. [2] G. Matheron, Adv. Appl. Prob. 5 (1973) 439 (generalised covariance of intrinsic random functions).
.. [3] F. E. Satterthwaite, Biometrics Bull. 2 (1946) 110.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import linalg

from ..core.errors import DataError
from ..core.estimate import Array

LEAST = 16  # contrasts that two parameters need before their scatter means something
NEGATIVE = 0.9  # of the most negative flicker that leaves every variance positive
ROUNDING = 1e-15  # of a contrast of equal means, relative to their size and number
SUM = 1e-9  # of the weights of a contrast, relative to their sizes
STARTS = np.linspace(-5.0, 14.0, 16)  # of the search, ln of the ratio's distance from the lower end


@dataclass(frozen=True, eq=False)
class Blocks:
    """Blocks of a record, and the contrasts that their design leaves: all that does not depend on the readings."""

    times: Array  # middles of the blocks, (n,) [s]
    length: float  # of a block [s]
    # orthonormal weights that the design does not see, along the axes of the flicker noise, (n - p, n)
    contrasts: Array
    sizes: Array  # variance of each for flicker noise of unit ``h``, (n - p,)
    flicker: Array  # generalised covariance of the block means for flicker noise of unit ``h``, (n, n)


def blocks_of(times: Array, length: float, design: Array) -> Blocks:
    """Return the contrasts of blocks of a record.

    Parameters
    ----------
    times : ndarray, shape (n,)
        Middles of the blocks [s]; gaps between them are allowed.
    length : float
        Length of a block [s].
    design : ndarray, shape (n, p)
        What is fitted beside the noise; its first column is a constant.

    Raises
    ------
    DataError
        ``too_few_blocks`` if less than 16 contrasts are left.
    """
    left = len(times) - int(np.linalg.matrix_rank(design))
    if left < LEAST:
        what = f"{len(times)} block means, of which {len(times) - left} are fitted: need {LEAST} more than that"
        why = "white and slow noise cannot be separated"
        raise DataError(what, why=why, do="Record longer", code="too_few_blocks")
    rest = np.linalg.qr(design, mode="complete")[0][:, len(times) - left :]
    flicker = flicker_covariance(times, length)
    sizes, axes = linalg.eigh(rest.T @ flicker @ rest)
    return Blocks(times, length, np.asarray((rest @ axes).T), np.maximum(sizes, 0.0), flicker)


@dataclass(frozen=True, eq=False)
class SlowNoise:
    """White and 1/f noise of a record, as its block means show them."""

    white: float  # one-sided spectral density of the white part [unit^2/Hz]
    flicker: float  # ``h`` of the 1/f part [unit^2]; may be a little negative where there is none
    covariance: Array  # of (white, flicker), (2, 2)
    blocks: Blocks  # of the record

    @property
    def corner(self) -> float:
        """Frequency at which both parts are equal [Hz]; 0 where no flicker was found."""
        return max(self.flicker, 0.0) / self.white if self.white > 0.0 else 0.0

    def variance(self, weights: Array) -> tuple[float, float]:
        """Variance of a contrast of the block means, and its degrees of freedom.

        Parameters
        ----------
        weights : ndarray, shape (n,)
            A weight a block; they add up to 0 (1/f noise has no variance otherwise).

        Raises
        ------
        DataError
            If the weights do not add up to 0.
        """
        if abs(float(np.sum(weights))) > SUM * float(np.sum(np.abs(weights))):
            raise DataError("weights do not add up to 0: the variance of a mean is not finite in 1/f noise")
        part = np.array([weights @ weights / (2.0 * self.blocks.length), weights @ self.blocks.flicker @ weights])
        found = float(part @ [self.white, self.flicker])
        spread = float(part @ self.covariance @ part)
        return max(found, 0.0), max(2.0 * found**2 / spread, 1.0) if spread > 0.0 else np.inf


def slow_noise(means: Array, blocks: Blocks, results: Array | None = None) -> SlowNoise:
    """Find the white and the 1/f noise of a record from its block means.

    Parameters
    ----------
    means : ndarray, shape (n,)
        Of the blocks.
    blocks : Blocks
        When they are, and what is fitted beside.
    results : ndarray, shape (q, n), optional
        Contrasts whose variance is asked for. The design may see them: then no contrast that shows the noise keeps
        their variance positive, and a flicker part below zero is bounded by them.

    Raises
    ------
    DataError
        ``no_scatter`` if the means do not differ beyond what the design explains.
    """
    squares = (blocks.contrasts @ means) ** 2
    if not np.sum(squares) > (ROUNDING * len(means)) ** 2 * np.sum(means**2):
        raise DataError("the block means do not differ", why="no noise can be found", code="no_scatter")
    largest = float(blocks.sizes.max())
    ratio = _ratio(squares, blocks.sizes, largest if results is None else max(largest, _largest(blocks, results)))
    shape = 1.0 + ratio * blocks.sizes
    level = float(np.mean(squares / shape))
    slopes = np.array([1.0 / shape, blocks.sizes / shape]) / level
    covariance = linalg.inv(0.5 * slopes @ slopes.T)
    scale = np.array([2.0 * blocks.length, 1.0])  # variance of a block mean of white noise is w / (2 length)
    white, flicker = np.array([level, ratio * level]) * scale
    return SlowNoise(float(white), float(flicker), covariance * np.outer(scale, scale), blocks)


def flicker_covariance(times: Array, length: float) -> Array:
    """Return the generalised covariance of means of 1/f noise of unit ``h`` over blocks, shape (n, n) [unit^2].

    Parameters
    ----------
    times : ndarray, shape (n,)
        Middles of the blocks [s].
    length : float
        Of a block [s].
    """
    lag = np.abs(np.subtract.outer(times, times))
    ends = _twice_integrated(lag + length) + _twice_integrated(lag - length)
    return (2.0 * _twice_integrated(lag) - ends) / length**2


def walk_covariance(times: Array, length: float) -> Array:
    """Return the generalised covariance of means of a random walk over blocks, ``-|t| / 2``, shape (n, n) [unit^2].

    Parameters
    ----------
    times : ndarray, shape (n,)
        Middles of the blocks [s].
    length : float
        Of a block [s].
    """
    lag = np.abs(np.subtract.outer(times, times))
    after, before = lag + length, np.abs(lag - length)
    ends = after * after * after + before * before * before  # a power takes ten times as long
    return np.asarray((2.0 * lag * lag * lag - ends) / (12.0 * length**2))


FLICKER, WALK = "flicker", "walk"


def window_covariance(start: Array, stop: Array, noise: str) -> Array:
    """Return the generalised covariance of means of slow noise of unit size over windows, shape (n, n) [unit^2].

    Parameters
    ----------
    start, stop : ndarray, shape (n,)
        Ends of the windows, of any lengths and order [s].
    noise : str
        ``FLICKER`` (spectrum 1 / f), or ``WALK`` (variance of the change over a second).
    """
    integral = _twice_integrated if noise == FLICKER else _cubed
    size = np.outer(stop - start, stop - start)
    same = integral(np.subtract.outer(stop, stop)) + integral(np.subtract.outer(start, start))
    mixed = integral(np.subtract.outer(stop, start))
    return np.asarray((same - mixed - mixed.T) / size)


def _cubed(lag: Array) -> Array:
    """Twice integrated |t| / 2."""
    return np.asarray(np.abs(lag) ** 3 / 12.0)


def _twice_integrated(lag: Array) -> Array:
    """Twice integrated ln|t|."""
    size = np.abs(lag)
    logs = np.log(np.where(size > 0.0, size, 1.0))
    return np.asarray(0.5 * size**2 * logs - 0.75 * size**2)


def _largest(blocks: Blocks, results: Array) -> float:
    """Greatest variance of a combination of contrasts, of unit length, for flicker noise of unit ``h``."""
    s, basis = np.linalg.svd(results, full_matrices=False)[1:]
    basis = basis[s > SUM * s.max(initial=0.0)]
    return float(np.linalg.eigvalsh(basis @ blocks.flicker @ basis.T).max(initial=0.0))


def _ratio(squares: Array, sizes: Array, largest: float) -> float:
    """Flicker over white variance of the block means, of greatest restricted likelihood."""
    from scipy import optimize  # noqa: PLC0415 - heavy import, which most commands need not wait for

    def ratio(q: Array | float) -> Array:
        return np.asarray((np.exp(q) - NEGATIVE) / largest)

    def cost(q: Array | float) -> Array:
        shape = 1.0 + ratio(q)[..., np.newaxis] * sizes
        return np.asarray(0.5 * (np.log(shape).sum(axis=-1) + len(squares) * np.log((squares / shape).mean(axis=-1))))

    best = int(np.argmin(cost(STARTS)))
    bounds = (STARTS[max(best - 1, 0)], STARTS[min(best + 1, len(STARTS) - 1)])
    return float(ratio(optimize.minimize_scalar(cost, bounds=bounds, method="bounded").x))

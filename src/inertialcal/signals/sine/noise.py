"""Noise at the line of a drive, from contrasts that see neither the drive nor its drift.

The noise of a record is white and a random walk, in shares 1 - p and p: a contrast to which a walk gives d times the
variance that it gives to the mean contrast has ``v (1 - p + p d)``. Given p, v follows by restricted maximum likelihood
from the contrasts of one record, or of several of one instrument [1]_. p is averaged over its likelihood, with white
noise alone as likely beforehand as all else: a short record hardly shows p, and the uncertainty depends on it by 20 %
at most. p may be a little negative, as in noise that rises with frequency: cut at zero, the uncertainty of every white
record would be too large.

Any weights that see no drift then have a variance for each p; its mean counts, and its degrees of freedom are those of
a chi-square with the same scatter [2]_, of v and of p.

Assumed: noise that is normal and the same throughout, of about this shape from 0.8 times the frequency of the drive to
four times it. Flicker lies between both. Student's interval holds the truth in 94 to 97 of 100 records of white noise,
flicker or a walk; in 90 where a walk ten times the white noise meets 10 periods of 12 readings.

References
----------
.. [1] D. A. Harville, J. Am. Stat. Assoc. 72 (1977) 320.
.. [2] F. E. Satterthwaite, Biometrics Bull. 2 (1946) 110.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import special

from ...core.estimate import Array

NEGATIVE = 0.3  # of the variance of a contrast, that a negative walk takes off at most
TRIED = 201  # shares of the walk
WHITE = 0.5  # chance of white noise alone, before the record is known
UNEQUAL = 1e-3  # chance of records whose noise differs so much


@dataclass(frozen=True, eq=False)
class Noise:
    """White noise and walk of k records."""

    share: Array  # of the walk, that are tried, shape (g,)
    unit: float  # variance of the mean contrast for a walk of unit steps
    level: Array  # variance of the mean contrast for each share, shape (g, k) [unit^2]
    chance: Array  # of each share, shape (g, k)
    dof: int  # contrasts

    def of(self, white: float, walk: float) -> tuple[Array, Array]:
        """Return the variance of weights, and its degrees of freedom, shape (k,) each.

        Parameters
        ----------
        white, walk : float
            Their variance for white noise of unit variance, and for a walk of unit steps.
        """
        each = self.level * ((1.0 - self.share) * white + self.share * walk / self.unit)[:, None]
        variance = np.sum(self.chance * each, axis=0)
        scatter = np.sum(self.chance * (2.0 / self.dof * each**2 + (each - variance) ** 2), axis=0)
        return variance, 2.0 * variance**2 / np.maximum(scatter, np.finfo(float).tiny)


def noise_of(contrasts: Sequence[Array], walks: Sequence[Array]) -> Noise:
    """Return the noise that contrasts show.

    Parameters
    ----------
    contrasts : sequence of ndarray, shape (m, k)
        Of stretches of k records, or of records of the same noise.
    walks : sequence of ndarray, shape (m,)
        Variance of each contrast for a walk of unit steps; contrasts are not correlated.
    """
    squares, walk = np.concatenate(contrasts) ** 2, np.concatenate(walks)
    m, unit = len(walk), float(np.mean(walk))
    share = np.linspace(-NEGATIVE / (walk.max() / unit - 1.0 + NEGATIVE), 1.0, TRIED)
    share -= share[np.argmin(np.abs(share))] * (1.0 - share)  # one of them is 0, the last stays 1
    shape = 1.0 - share[:, None] + share[:, None] * walk / unit
    level = (1.0 / shape) @ squares / m
    cost = 0.5 * (np.log(shape).sum(axis=1)[:, None] + m * np.log(np.maximum(level, np.finfo(float).tiny)))
    before = np.full(TRIED, (1.0 - WHITE) / TRIED)
    before[np.argmin(np.abs(share))] += WHITE
    chance = before[:, None] * np.exp(cost.min(axis=0) - cost)
    return Noise(share, unit, level, chance / chance.sum(axis=0), m)


def same_noise(contrasts: Sequence[Array], walks: Sequence[Array], noise: Noise) -> bool:
    """Return whether records, of one column each, may have the same noise (Bartlett's test)."""
    share = float(noise.share @ noise.chance[:, 0])
    levels = np.array(
        [np.mean(z**2 / (1.0 - share + share * d / noise.unit)) for z, d in zip(contrasts, walks, strict=True)]
    )
    dof = np.array([len(d) for d in walks])
    if not levels.min() > 0.0:
        return False
    statistic = dof.sum() * np.log(dof @ levels / dof.sum()) - dof @ np.log(levels)
    correction = 1.0 + (np.sum(1.0 / dof) - 1.0 / dof.sum()) / (3.0 * (len(dof) - 1.0))
    return bool(special.chdtrc(len(dof) - 1.0, statistic / correction) > UNEQUAL)

"""What positions cannot tell: combinations of parameters that no reading depends on.

The derivatives of the readings by the parameters, each scaled to the same size (1 stands for a scale factor, a bias
in gravities, a misalignment in radians), are split by singular values. A combination is not told if its singular value
is below ``SMALLEST`` of the largest, or if the noise alone would leave it uncertain by more than ``USELESS``. Every
parameter that takes part in such a combination is not estimated; the others are told as well as ever.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from ....core.estimate import Array

SMALLEST = 1e-4  # singular value over the largest one
USELESS = 0.05  # standard uncertainty of a combination of size one, above which it is not told
TAKES_PART = 0.03  # share of a parameter in a combination, below which it is told


@dataclass(frozen=True, eq=False)
class Observed:
    """What is told.

    Parameters
    ----------
    rank, count : int
        Combinations that are told, of how many.
    condition : float
        Largest over smallest singular value of those that are told.
    told : ndarray of bool, shape (p,)
        Parameters that take no part in a combination that is not.
    kept : ndarray, shape (p, rank)
        Directions that are told, in scaled parameters.
    combinations : tuple of str
        Those that are not, in words.
    """

    rank: int
    count: int
    condition: float
    told: NDArray[np.bool_]
    kept: Array
    combinations: tuple[str, ...]

    @property
    def whole(self) -> bool:
        """Whether everything is told."""
        return self.rank == self.count


def observed(scaled: Array, names: Sequence[str], scatter: float) -> Observed:
    """Return what a scaled Jacobian can tell.

    Parameters
    ----------
    scaled : ndarray, shape (n, p)
        Derivatives of the readings by scaled parameters, all in one unit.
    names : sequence of str
        Of the parameters.
    scatter : float
        Standard deviation of a reading, in that unit.
    """
    n, p = scaled.shape
    padded = scaled if n >= p else np.vstack([scaled, np.zeros((p - n, p))])
    s, rows = np.linalg.svd(padded, full_matrices=False)[1:]
    good = (s > SMALLEST * s[0]) & (scatter < USELESS * s) if s[0] > 0.0 else np.zeros(p, dtype=bool)
    lost = rows[~good].T
    told = np.sqrt(np.sum(lost**2, axis=1)) < TAKES_PART
    rank = int(np.sum(good))
    condition = float(s[good].max() / s[good].min()) if rank else np.inf
    return Observed(rank, p, condition, told, rows[good].T, _in_words(lost, names))


def _in_words(lost: Array, names: Sequence[str]) -> tuple[str, ...]:
    """Each combination with as few parameters in it as can be."""
    if not lost.shape[1]:
        return ()
    pivots = linalg.qr(lost.T, mode="r", pivoting=True)[1][: lost.shape[1]]
    simple = lost @ np.linalg.inv(lost[pivots])
    found = []
    for vector in simple.T:
        largest = vector[np.argmax(np.abs(vector))]
        terms = [(factor, names[i]) for i, factor in enumerate(vector / largest) if abs(factor) > TAKES_PART]
        found.append(" ".join(_term(factor, name, k == 0) for k, (factor, name) in enumerate(terms)))
    return tuple(found)


def _term(factor: float, name: str, first: bool) -> str:
    sign = "-" if factor < 0.0 else "" if first else "+"
    size = "" if abs(abs(factor) - 1.0) < 0.005 else f"{abs(factor):.2g} "
    return f"{sign}{size}{name}" if first else f"{sign} {size}{name}"

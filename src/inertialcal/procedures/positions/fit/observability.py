"""What positions cannot tell: combinations of parameters that no reading depends on.

The derivatives of the readings by the parameters, each scaled to the same size (1 stands for a scale factor, a bias
in gravities, a misalignment in radians), are split by singular values. A combination is not told if its singular value
is below ``SMALLEST`` of the largest, or if the noise alone would leave it uncertain by more than ``USELESS``. Every
parameter that takes part in such a combination is not estimated; the others are told as well as ever.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from ....core.estimate import Array
from ....core.key import Key

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
    parts : tuple of frozenset of Key
        Parameters that take part in each of them.
    """

    rank: int
    count: int
    condition: float
    told: NDArray[np.bool_]
    kept: Array
    combinations: tuple[str, ...]
    parts: tuple[frozenset[Key], ...]

    @property
    def whole(self) -> bool:
        """Whether everything is told."""
        return self.rank == self.count


def observed(scaled: Array, names: Sequence[Key], scatter: float) -> Observed:
    """Return what a scaled Jacobian can tell.

    Parameters
    ----------
    scaled : ndarray, shape (n, p)
        Derivatives of the readings by scaled parameters, all in one unit.
    names : sequence of Key
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
    simple = list(_simple(lost, names))
    words, parts = tuple(map(_in_words, simple)), tuple(map(_parts, simple))
    return Observed(rank, p, condition, told, rows[good].T, words, parts)


def _simple(lost: Array, names: Sequence[Key]) -> Iterator[list[tuple[float, Key]]]:
    """Yield each combination with as few parameters in it as can be, the largest with factor one."""
    if not lost.shape[1]:
        return
    pivots = linalg.qr(lost.T, mode="r", pivoting=True)[1][: lost.shape[1]]
    simple = lost @ np.linalg.inv(lost[pivots])
    for vector in simple.T:
        largest = vector[np.argmax(np.abs(vector))]
        yield [(factor, names[i]) for i, factor in enumerate(vector / largest) if abs(factor) > TAKES_PART]


def _parts(terms: Sequence[tuple[float, Key]]) -> frozenset[Key]:
    return frozenset(name for _, name in terms)


def _in_words(terms: Sequence[tuple[float, Key]]) -> str:
    return " ".join(_term(factor, name, k == 0) for k, (factor, name) in enumerate(terms))


def _term(factor: float, name: Key, first: bool) -> str:
    sign = "-" if factor < 0.0 else "" if first else "+"
    size = "" if abs(abs(factor) - 1.0) < 0.005 else f"{abs(factor):.2g} "
    return f"{sign}{size}{name}" if first else f"{sign} {size}{name}"

"""Weighted means of independent values (JCGM 100:2008, 5.1 and G.4)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..core.errors import DataError


@dataclass(frozen=True)
class Mean:
    """A mean, its standard uncertainty (same unit) and the degrees of freedom of that."""

    value: float
    u: float
    dof: float


def weighted_mean(values: ArrayLike, u: ArrayLike, dof: ArrayLike = np.inf) -> Mean:
    """Return the mean of independent values weighted by 1/u², with u and dof from theirs.

    The uncertainties are taken as given. Those with few degrees of freedom (below about 10) make the result look better
    than it is.

    Parameters
    ----------
    values, u : array_like, shape (n,)
        In one unit.
    dof : array_like, shape (n,), or float
        Degrees of freedom of each u (Welch-Satterthwaite).

    Raises
    ------
    DataError
        If a value is not finite, or an uncertainty is not a positive number.
    """
    x, sigma = np.broadcast_arrays(np.atleast_1d(np.asarray(values, float)), np.asarray(u, float))
    bad = np.flatnonzero(~(np.isfinite(x) & np.isfinite(sigma)))
    if bad.size:
        raise DataError(
            f"values: {bad.size} not finite, the first is number {bad[0] + 1}",
            do="Leave out what is missing, and count it",
            code="not_finite",
        )
    if x.size == 0 or np.any(sigma <= 0.0):
        raise DataError(
            f"{x.size} values, smallest standard uncertainty {sigma.min(initial=np.inf):g}",
            do="Need one or more, each with an uncertainty above zero",
        )
    weights = sigma**-2.0
    share = weights / weights.sum()
    spent = float(np.sum(share**2 / np.broadcast_to(np.asarray(dof, dtype=float), x.shape)))
    return Mean(float(share @ x), float(weights.sum() ** -0.5), 1.0 / spent if spent > 0.0 else np.inf)

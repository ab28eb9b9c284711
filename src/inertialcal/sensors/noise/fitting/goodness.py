"""Tests of a fit: do its terms explain the Allan variances, and do several runs agree.

Residuals are taken as cube roots of the ratio found to expected, which are nearly normal down to few degrees of freedom
[1]_, with the correlation that the fitted terms imply and less what the fit took from them; their sum of squares in
that metric is chi-square with as many degrees of freedom as averaging times are left over.

Runs agree if the slopes of the cost, run by run at the common terms, are as small as the terms imply: chi-square too.

References
----------
.. [1] E. B. Wilson and M. M. Hilferty, Proc. Natl. Acad. Sci. 17 (1931) 684.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy import special

from ....core.estimate import Array
from .likelihood import Fitted, mean_of, slopes_of
from .problem import Problem

SIGNIFICANT = 0.01  # probability below which a test says that something is wrong
SMALL = 1e-8  # of the largest eigenvalue: directions that the fit took


@dataclass(frozen=True)
class ChiSquare:
    """A chi-square test.

    Parameters
    ----------
    statistic : float
        Found.
    dof : int
        Degrees of freedom.
    p : float
        Probability of a statistic at least as large, if the model holds.
    """

    statistic: float
    dof: int
    p: float

    def __str__(self) -> str:
        """Return the test in a line."""
        return f"chi-square {self.statistic:.1f}, {self.dof} dof, p = {self.p:.2g}"


def residual_test(problem: Problem, fitted: Fitted, sigma: Array) -> ChiSquare | None:
    """Return whether the terms explain the Allan variances; None where no averaging time is left over."""
    mu = mean_of(problem, fitted)
    edf = 2.0 * mu**2 / np.diag(sigma)
    unit = mu * np.sqrt(2.0 / edf)
    found = (np.cbrt(problem.variance / mu) - (1.0 - 2.0 / (9.0 * edf))) / np.sqrt(2.0 / (9.0 * edf))
    D = slopes_of(problem, fitted)
    weights = problem.weight / mu**2
    taken = D @ np.linalg.solve((D.T * weights) @ D, D.T * weights)
    left = (np.eye(len(mu)) - taken) * unit / unit[:, None]
    correlation = left @ (sigma / np.outer(unit, unit)) @ left.T
    return _chi_square(found, correlation, len(mu) - D.shape[1])


def agreement_test(problem: Problem, fitted: Fitted, sigma: Array) -> ChiSquare | None:
    """Return whether runs agree on the terms; None for one run."""
    if len(problem.runs) < 2:
        return None
    mu = mean_of(problem, fitted)
    D = slopes_of(problem, fitted)
    weights = problem.weight / mu**2
    scale = 1.0 / np.sqrt(weights @ D**2)
    D = D * scale
    ends = np.cumsum([0, *(len(run.m) for run in problem.runs)])
    rows = [slice(a, b) for a, b in pairwise(ends)]
    H = [(D[row].T * weights[row]) @ D[row] for row in rows]
    slopes = np.vstack([_placed(D[row].T * weights[row], row, len(mu)) for row in rows])
    total = np.vstack(H) @ np.linalg.solve(np.sum(H, axis=0), D.T * weights)
    left = slopes - total
    found = left @ (problem.variance - mu)
    unknowns = D.shape[1]
    return _chi_square(found, left @ sigma @ left.T, (len(rows) - 1) * unknowns)


def _placed(block: Array, row: slice, size: int) -> Array:
    whole = np.zeros((block.shape[0], size))
    whole[:, row] = block
    return whole


def _chi_square(values: Array, covariance: Array, dof: int) -> ChiSquare | None:
    """Sum of squares in the metric of a covariance of that rank."""
    if dof < 1:
        return None
    scale = 1.0 / np.sqrt(np.maximum(np.diag(covariance), np.finfo(float).tiny))
    sizes, directions = np.linalg.eigh(covariance * np.outer(scale, scale))
    kept = np.argsort(sizes)[-dof:]
    kept = kept[sizes[kept] > SMALL * sizes[-1]]
    along = directions[:, kept].T @ (values * scale)
    statistic = float(np.sum(along**2 / sizes[kept]))
    return ChiSquare(statistic, len(kept), float(special.chdtrc(len(kept), statistic)))

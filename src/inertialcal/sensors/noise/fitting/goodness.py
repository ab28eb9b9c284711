"""Tests of a fit: do its terms explain the Allan variances, do several runs agree, and what misfit is left.

Residuals are the cube roots of the ratio found to expected, which are nearly normal down to few degrees of freedom
[1]_, with the correlation that the fitted terms imply, less what the fit took from them. Their sum of squares in that
metric is chi-square; its degrees of freedom are the averaging times less the unknowns. Runs agree if the slopes of the
cost, run by run at the common terms, are as small as the terms imply: chi-square too.

At short averaging times a long record gives the Allan variance to a thousandth, and no sensor is a sum of a few terms
to a thousandth: filters, lines and coarse codes see to that. Weighted by its scatter alone, a misfit of 5 % there would
outweigh all that long averaging times say of bias instability and random walk. So where the residual test rejects even
all candidates together, each Allan variance is taken as known no better than to a relative misfit, the same at all
averaging times and independent between them: the one that makes chi-square equal to its degrees of freedom [2]_. It
enters weights and covariance, and a remark gives it. Of several runs each is fitted alone and the chi-squares are
added, because runs that differ are no misfit of the terms. A misfit beyond `MOST` is not allowed for: then the fit does
not hold.

References
----------
.. [1] E. B. Wilson and M. M. Hilferty, Proc. Natl. Acad. Sci. 17 (1931) 684.
.. [2] R. C. Paule and J. Mandel, J. Res. Natl. Bur. Stand. 87 (1982) 377: consensus values and weighting factors.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from itertools import pairwise

import numpy as np
from scipy import linalg, optimize, special

from ....core.estimate import Array
from .._kernels_chain import fill_residuals, sum_of_squares
from .likelihood import Fitted, covariance_of_runs, estimate, mean_of, slopes_of
from .problem import PER_E, Problem, each_run, with_misfit

SIGNIFICANT = 0.01  # probability below which a test says that something is wrong
SMALL = 1e-8  # of the largest variance, or eigenvalue: values and directions that the fit took
LEAST, MOST = 1e-4, 0.5  # relative misfits of a variance that are tried
STEP, PRECISION = 1.0, 0.05  # of their logarithm: first pass, result


@dataclass(frozen=True)
class ChiSquare:
    """A chi-square test."""

    statistic: float  # Found
    dof: int  # Degrees of freedom
    p: float  # Probability of a statistic at least as large, if the model holds

    def __str__(self) -> str:
        """Return the test in a line."""
        return f"chi-square {self.statistic:.1f}, {self.dof} dof, p = {self.p:.2g}"


def residual_test(problem: Problem, fitted: Fitted, sigma: Array) -> ChiSquare | None:
    """Return whether the terms explain the Allan variances; None where no averaging time is left over."""
    count = len(problem.variance)
    found = np.empty((count, 1 + count))
    unknowns = fill_residuals(
        problem.columns, problem.table, problem.data, PER_E, fitted.powers, fitted.position, sigma, found
    )
    return chi_square(found, count - unknowns)


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
    slopes = linalg.block_diag(*[D[row].T * weights[row] for row in rows])
    total = np.vstack(H) @ np.linalg.solve(np.sum(H, axis=0), D.T * weights)
    left = slopes - total
    found = left @ (problem.variance - mu)
    return chi_square(np.column_stack([found, left @ sigma @ left.T]), (len(rows) - 1) * D.shape[1])


def chi_square(found: Array, dof: int) -> ChiSquare | None:
    """Return the sum of squares of values in the metric of their covariance of that rank, which is behind them.

    Values that the fit took whole are left out. The array is written over.
    """
    if dof < 1:
        return None
    statistic, kept = sum_of_squares(found, dof, SMALL)
    return ChiSquare(statistic, kept, float(special.chdtrc(kept, statistic)))


def chi_squares(tests: Array) -> list[ChiSquare | None]:
    """Return tests of sums of squares and their degrees of freedom, shape (n, 2); None where there are none."""
    p = special.chdtrc(tests[:, 1], tests[:, 0])
    found = zip(*tests.T.tolist(), p.tolist(), strict=True)
    return [ChiSquare(total, int(dof), chance) if dof > 0 else None for total, dof, chance in found]


def misfit_of(problem: Problem, candidates: tuple[str, ...]) -> float:
    """Return the relative misfit that all candidates together leave; zero where scatter explains the rest."""

    @cache
    def excess(log: float) -> float:
        """Logarithm of chi-square over its degrees of freedom."""
        statistic, dof = _left(with_misfit(problem, float(np.exp(log))), candidates)
        return float(np.log(statistic / dof)) if dof else 0.0

    statistic, dof = _left(problem, candidates)
    if not dof or special.chdtrc(dof, statistic) >= SIGNIFICANT:
        return 0.0
    ends = (*np.arange(np.log(LEAST), np.log(MOST), STEP), np.log(MOST))
    for lo, hi in pairwise((ends[0] - STEP, *ends)):
        if excess(hi) <= 0.0:
            return float(np.exp(optimize.brentq(excess, lo, hi, xtol=PRECISION) if excess(lo) > 0.0 else hi))
    return MOST


def _left(problem: Problem, candidates: tuple[str, ...]) -> tuple[float, int]:
    """Return chi-square of the residuals and its degrees of freedom, of all runs, each with terms of its own."""
    statistic, dof = 0.0, 0
    for run in each_run(problem):
        fitted = estimate(run, candidates, looks=1)
        found = residual_test(run, fitted, covariance_of_runs(run, fitted))
        if found is not None:
            statistic, dof = statistic + found.statistic, dof + found.dof
    return statistic, dof

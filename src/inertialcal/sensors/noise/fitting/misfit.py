"""How well terms explain an Allan deviation at all, where scatter alone does not account for what is left.

At short averaging times a long record gives the Allan variance to a thousandth, and no sensor is a sum of a few terms
to a thousandth: filters, lines and coarse codes see to that. Weighted by its scatter, a misfit there of 5 % would
outweigh everything that long averaging times say of bias instability and random walk. So where the residual test
rejects even all candidates together, each Allan variance is taken to be known no better than to a relative misfit,
alike at all averaging times and independent between them: the one at which the chi-square of the residuals is as large
as its degrees of freedom [1]_. It enters weights and covariance, and is told.

Of several runs each is fitted by itself, with terms of its own, and the chi-squares are added: that runs differ from
each other is no misfit of the terms, and has a test of its own (``goodness``). No misfit beyond `MOST` is allowed for;
where even that explains nothing, the fit does not hold.

References
----------
.. [1] R. C. Paule and J. Mandel, J. Res. Natl. Bur. Stand. 87 (1982) 377: consensus values and weighting factors.
"""

from __future__ import annotations

from functools import cache
from itertools import pairwise

import numpy as np
from scipy import optimize, special

from .goodness import SIGNIFICANT, residual_test
from .likelihood import covariance_of_runs, estimate
from .problem import Problem, each_run, with_misfit

LEAST, MOST = 1e-4, 0.5  # relative misfits of a variance that are looked at
STEP, PRECISION = 1.0, 0.05  # of the logarithm: as it is first looked through, and as it is found


def misfit_of(problem: Problem, candidates: tuple[str, ...]) -> float:
    """Return the relative misfit of Allan variances that all candidates together leave; zero where scatter explains it.

    Parameters
    ----------
    problem : Problem
        Runs.
    candidates : tuple of str
        Names of the terms.
    """

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

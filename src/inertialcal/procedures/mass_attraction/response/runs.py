"""Several runs as one: weighted mean, and its uncertainty from how the runs differ or from the noise of each.

Runs are weighed by ``1 / (u^2 + t^2)``: u of each from the lines beside its own, t^2 the variance between runs that
explains how they differ [1]_. The weights decide nothing but the efficiency. The uncertainty is that of the weighted
scatter of the runs about their mean, with one degree of freedom less than there are runs [2]_: it holds whatever the
runs differ by. The noise within the runs alone gives another one, right where nothing differs from run to run.

References
----------
.. [1] R. C. Paule and J. Mandel, J. Res. NBS 87 (1982) 377.
.. [2] J. Hartung and G. Knapp, Statistics in Medicine 20 (2001) 1771.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import optimize, special

from ....core.estimate import Array
from ....statistics.means import Mean, weighted_mean


@dataclass(frozen=True)
class Combined:
    """Mean of runs.

    Parameters
    ----------
    within : Mean
        Weighted by the noise of each run, with the uncertainty from that alone.
    between : Mean or None
        With the uncertainty from how the runs differ; None of a single run.
    p_value : float
        Probability that runs that do not differ scatter at least as much; NaN of a single run.
    """

    within: Mean
    between: Mean | None
    p_value: float


def combined(values: Array, u: Array, dof: Array) -> Combined:
    """Return the mean of runs.

    Parameters
    ----------
    values, u, dof : ndarray, shape (m,)
        Of each run, in one unit.
    """
    within = weighted_mean(values, u, dof)
    m = len(values)
    if m < 2:
        return Combined(within, None, np.nan)
    chi_square = float(np.sum(((values - within.value) / u) ** 2))
    w = 1.0 / (u**2 + between_variance(values, u))
    mean = float(w @ values / w.sum())
    variance = float(w @ (values - mean) ** 2 / ((m - 1.0) * w.sum()))
    p = float(special.fdtrc(m - 1.0, float(np.sum(dof)), chi_square / (m - 1.0)))
    return Combined(within, Mean(mean, float(np.sqrt(variance)), m - 1.0), p)


def between_variance(values: Array, u: Array) -> float:
    """Return the variance between runs that makes their scatter what it should be; 0 where noise explains it all."""

    def excess(t_2: float) -> float:
        w = 1.0 / (u**2 + t_2)
        mean = w @ values / w.sum()
        return float(w @ (values - mean) ** 2) - (len(values) - 1.0)

    if excess(0.0) <= 0.0:
        return 0.0
    most = float(len(values) * np.ptp(values) ** 2)
    return float(optimize.brentq(excess, 0.0, most, rtol=1e-6))

"""Verdicts on a requirement, with a stated rule and a stated risk (JCGM 106).

The rule is guarded on both sides: PASS if the 95 % interval of the value lies inside the limits, FAIL if it
lies wholly outside, else INCONCLUSIVE - the measurement is not good enough to decide. With one limit the
bound on its side is one-sided: PASS if the one-sided 95 % upper bound is at or below an upper limit, FAIL
if the one-sided 95 % lower bound is above it.

The risk: with one limit, a true value on the limit gets PASS in 5 % of all measurements (exactly, for a
normal value with u known or with Student's t), less often the further outside it lies; FAIL likewise for
good ones. With two limits it is at most 2.5 %, and that is approached where the limits are far apart
compared with u; limits nearer to each other than twice ``k u`` can never give PASS. `pass_probability`
gives the figure for any true value. These risks hold for a single decision: several are held together by
`holm` or by ``intervals.band_factor``.

References
----------
.. [1] JCGM 106:2012, Evaluation of measurement data - The role of measurement uncertainty in conformity
   assessment, clauses 7 and 8.
.. [2] Holm, Scandinavian J. Statistics 6 (1979) 65-70.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import special

from ..core.errors import DataError, PlanError
from ..core.results import Interval
from .intervals import coverage_factor, ends, t_interval, t_quantile

Status = Literal["PASS", "FAIL", "INCONCLUSIVE", "OPEN"]

NODES = 2000  # of the scatter's distribution, in steps of equal probability


@dataclass(frozen=True)
class Verdict:
    """A decision with all that it was made from."""

    status: Status  # {"PASS", "FAIL", "INCONCLUSIVE", "OPEN"}: OPEN where no test was made; it counts as INCONCLUSIVE
    # what was measured, in the unit of the limits; dof infinite where u is known
    value: float | None = None
    u: float | None = None
    dof: float | None = None
    # the one that was compared; with one limit both ends are one-sided bounds of the rule's probability, so that its
    # own ``p`` is 0.90 for a rule of 95 %
    interval: Interval | None = None
    # the requirement
    limit_lower: float | None = None
    limit_upper: float | None = None
    rule: str = ""  # the decision rule in words
    reason: str = ""  # what decided


def decide(
    value: float | None,
    u: float | None,
    dof: float | None,
    lower: float | None = None,
    upper: float | None = None,
    p: float = 0.95,
) -> Verdict:
    """Return the verdict on a value against one or two limits.

    Parameters
    ----------
    value, u : float or None
        Estimate and standard uncertainty, in one unit; None where not estimated. An uncertainty of
        exactly zero was not estimated either: scatter below the converter's step shows none.
    dof : float or None
        Degrees of freedom of u; None or infinite where it is known; 0 where not estimated.
    lower, upper : float or None
        Limits, in the same unit; a value on the limit conforms.
    p : float
        Probability of the interval, or of each one-sided bound.

    Raises
    ------
    PlanError
        If there is no limit, they are not numbers, the lower is above the upper, or ``p`` is not between
        0 and 1.

    Examples
    --------
    >>> decide(0.8, 0.05, 20, upper=1.0).status
    'PASS'
    >>> decide(0.95, 0.05, 20, upper=1.0).status
    'INCONCLUSIVE'
    """
    _check_limits(lower, upper)
    dof = math.inf if dof is None else float(dof)
    both = lower is not None and upper is not None
    rule = _rule(p, both)
    missing = _missing(value, u, dof)
    if missing or value is None or u is None:
        return Verdict("INCONCLUSIVE", value, u, dof, None, lower, upper, rule, missing)
    interval = t_interval(value, u, dof, p if both else round(2.0 * p - 1.0, 12))
    status, reason = _compared(interval, lower, upper)
    return Verdict(status, value, u, dof, interval, lower, upper, rule, reason)


def decide_by(
    interval: Interval | None,
    value: float | None,
    u: float | None,
    lower: float | None = None,
    upper: float | None = None,
    p: float = 0.95,
) -> Verdict:
    """Return the verdict by an interval that is no t-interval about the value, such as that of a profile.

    Parameters
    ----------
    interval : Interval or None
        Two-sided of probability ``p``; with one limit, of ``2 p - 1``, so that each end is a one-sided bound of ``p``.
        None where there is none.
    value, u : float or None
        What was measured, for the record.
    lower, upper : float or None
        Limits, in the same unit.
    p : float
        Probability of the rule.

    Raises
    ------
    PlanError
        If there is no limit, or they are not numbers in order.
    """
    _check_limits(lower, upper)
    rule = _rule(p, lower is not None and upper is not None)
    if interval is None:
        return Verdict("INCONCLUSIVE", value, u, None, None, lower, upper, rule, "no interval is estimated")
    status, reason = _compared(interval, lower, upper)
    return Verdict(status, value, u, None, interval, lower, upper, rule, reason)


def no_change(
    difference: float | None, u: float | None, dof: float | None, allowed: float | None, p: float = 0.95
) -> Verdict:
    """Return the verdict on "it did not change": the interval of the change lies within ± allowed.

    Not significantly different is not the same as unchanged: a poor measurement would always pass.

    Parameters
    ----------
    difference, u, dof : float or None
        Change, its standard uncertainty and degrees of freedom.
    allowed : float or None
        Largest change that does not matter, in the same unit; None is INCONCLUSIVE.
    p : float
        Probability of the interval.

    Raises
    ------
    PlanError
        If the allowed change is not a positive number.
    """
    if allowed is None:
        reason = "no allowed change is stated: without one, no measurement can show that nothing changed"
        return Verdict("INCONCLUSIVE", difference, u, dof, rule=_rule(p, both=True), reason=reason)
    if not (allowed > 0.0 and math.isfinite(allowed)):
        raise PlanError(f"allowed change {allowed:g}", do="Need a positive number")
    return decide(difference, u, dof, -allowed, allowed, p)


def overall(verdicts: Iterable[Verdict]) -> Status:
    """Return FAIL if any fails, else INCONCLUSIVE if any is inconclusive or open, or there is none; else PASS."""
    found = {verdict.status for verdict in verdicts}
    if "FAIL" in found:
        return "FAIL"
    return "PASS" if found == {"PASS"} else "INCONCLUSIVE"


def holm(p_values: ArrayLike, alpha: float = 0.05) -> NDArray[np.bool_]:
    """Return which hypotheses are rejected, none of the true ones in 1 - alpha of all campaigns [2]_.

    Parameters
    ----------
    p_values : array_like, shape (k,)
        Of one test each, correlated or not.
    alpha : float
        Chance of one false rejection or more.

    Returns
    -------
    ndarray of bool, shape (k,)
        True where rejected.

    Raises
    ------
    DataError
        If a p value is not between 0 and 1.
    PlanError
        If ``alpha`` is not between 0 and 1.
    """
    p = np.asarray(p_values, dtype=float)
    if p.ndim != 1 or not np.all((p >= 0.0) & (p <= 1.0)):
        raise DataError(f"p values {p.tolist()}", do="Need a list of numbers from 0 to 1")
    if not 0.0 < alpha < 1.0:
        raise PlanError(f"chance of a false rejection {alpha:g}", do="Need more than 0 and less than 1")
    order = np.argsort(p, kind="stable")
    small = p[order] <= alpha / (p.size - np.arange(p.size))
    rejected = np.zeros(p.size, dtype=bool)
    rejected[order] = np.logical_and.accumulate(small)
    return rejected


def pass_probability(
    true_value: float,
    u: float,
    dof: float,
    lower: float | None = None,
    upper: float | None = None,
    p: float = 0.95,
) -> float:
    """Return how often `decide` says PASS for a true value: outside the limits, its risk of a false PASS.

    Parameters
    ----------
    true_value : float
        In the unit of the limits.
    u : float
        True standard uncertainty of the measurement; what is found scatters about it as chi does.
    dof : float
        Degrees of freedom with which each measurement estimates u.
    lower, upper : float or None
        Limits.
    p : float
        Of the rule.

    Raises
    ------
    DataError
        If ``u`` is not positive, or there are no degrees of freedom.
    PlanError
        If there is no limit, or the lower is above the upper.
    """
    _check_limits(lower, upper)
    missing = _missing(true_value, u, dof)
    if missing:
        raise DataError(f"probability of PASS at {true_value:g}: {missing}", code="no_uncertainty")
    both = lower is not None and upper is not None
    factor = coverage_factor(dof, p) if both else t_quantile(dof, p)
    guard = factor * u * _scatter_ratios(dof)
    below = 1.0 if upper is None else special.ndtr((upper - guard - true_value) / u)
    outside = 0.0 if lower is None else special.ndtr((lower + guard - true_value) / u)
    return float(np.mean(np.maximum(below - outside, 0.0)))


def _scatter_ratios(dof: float) -> NDArray[np.float64]:
    """Found over true standard uncertainty, at the middle of steps of equal probability."""
    if math.isinf(dof):
        return np.ones(1)
    middle = (np.arange(NODES) + 0.5) / NODES
    return np.asarray(np.sqrt(special.chdtri(dof, middle) / dof), dtype=float)


def _probability_below(t: float, dof: float) -> float:
    return float(special.ndtr(t) if math.isinf(dof) else special.stdtr(dof, t))


def _check_limits(lower: float | None, upper: float | None) -> None:
    given = [limit for limit in (lower, upper) if limit is not None]
    if not given or not all(math.isfinite(limit) for limit in given) or given != sorted(given):
        raise PlanError(
            f"limits {lower} to {upper}", do="Need one limit or two, as finite numbers, the lower first", code="limits"
        )


def _missing(value: float | None, u: float | None, dof: float) -> str:
    """Why no interval can be made; empty if one can."""
    if value is None or not math.isfinite(value):
        return "the value is not estimated"
    if u is None or not math.isfinite(u) or u < 0.0:
        return "the standard uncertainty is not estimated"
    if u == 0.0:
        return "the standard uncertainty is 0, which no measurement has: its scatter did not show"
    if not dof > 0.0:
        return "no degrees of freedom: the scatter was not repeated, so it is not estimated"
    return ""


def _rule(p: float, both: bool) -> str:
    if both:
        return (
            f"JCGM 106, guarded: PASS if the {100 * p:g} % interval lies inside the limits, "
            "FAIL if wholly outside, else INCONCLUSIVE"
        )
    return (
        f"JCGM 106, guarded: PASS if the one-sided {100 * p:g} % bound lies inside the limit, "
        "FAIL if the bound on the other side lies outside, else INCONCLUSIVE"
    )


def _compared(interval: Interval, lower: float | None, upper: float | None) -> tuple[Status, str]:
    lo, hi = ends(interval)
    low = -math.inf if lower is None else lower
    high = math.inf if upper is None else upper
    if low <= lo and hi <= high:
        return "PASS", "the interval lies inside the limits"
    if hi < low or lo > high:
        return "FAIL", "the interval lies outside the limits"
    return "INCONCLUSIVE", "the interval reaches over a limit: u is too large to decide"

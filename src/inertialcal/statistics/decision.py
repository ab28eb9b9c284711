"""Verdicts on a requirement, with a stated rule and a stated risk (JCGM 106).

By default it is guarded on both sides: PASS if the 95 % interval of the value lies inside the limits, FAIL if it
lies wholly outside, else INCONCLUSIVE - the measurement is not good enough to decide. With one limit the
bound on its side is one-sided: PASS if the one-sided 95 % upper bound is at or below an upper limit, FAIL
if the one-sided 95 % lower bound is above it. ``guard_band`` has the other rules that a contract may name.

The risk: with one limit, a true value on the limit gets PASS in 5 % of all measurements (exactly, for a
normal value with u known or with Student's t), less often the further outside it lies; FAIL likewise for
good ones. With two limits it is at most 2.5 %, and that is approached where the limits are far apart
compared with u; limits nearer to each other than twice ``k u`` can never give PASS. ``guard_band.pass_probability``
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
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..core.errors import DataError, PlanError
from ..core.judging import Basis, Rule
from ..core.results import Interval, finite
from .guard_band import INTERVAL, applied, below, guard_band, uncertainty_ratio
from .intervals import coverage_factor, ends, t_interval

Status = Literal["PASS", "FAIL", "INCONCLUSIVE", "OPEN"]


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
    basis: Basis = field(default_factory=Basis)  # acceptance limits, risk


def decide(
    value: float | None,
    u: float | None,
    dof: float | None,
    lower: float | None = None,
    upper: float | None = None,
    p: float = 0.95,
    rule: Rule = INTERVAL,
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
    rule : Rule
        Decision rule; by default the interval against the limits. With its process in the unit of the limits.

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
    >>> decide(0.95, 0.05, 20, upper=1.0, rule=Rule("simple_acceptance")).status
    'PASS'
    """
    _check_limits(lower, upper)
    dof = math.inf if dof is None else float(dof)
    both = lower is not None and upper is not None
    words = _words(rule, p, both)
    missing = _missing(value, u, dof)
    if missing or value is None or u is None:
        return Verdict("INCONCLUSIVE", value, u, dof, None, lower, upper, words, missing, Basis(words))
    shown, half = _shown_level(rule, p, both), coverage_factor(dof, p) * u
    interval = t_interval(value, u, dof, shown)
    rule = applied(rule, half, lower, upper)
    bands = guard_band(rule, u, dof, lower, upper, p)
    accept = Interval.of_own(value - bands.accept, value + bands.accept, shown)
    reject = accept
    if bands.reject != bands.accept:
        reject = Interval.of_own(value - bands.reject, value + bands.reject, shown)
    low = 0.0 if lower is None else below((lower - value) / u, dof)
    high = 0.0 if upper is None else below((value - upper) / u, dof)
    ratio = uncertainty_ratio(half, lower, upper)
    return _judged(rule, value, u, dof, interval, accept, reject, lower, upper, low + high, ratio, words)


def decide_by(
    interval_at: Callable[[float], Interval | None],
    value: float | None,
    u: float | None,
    lower: float | None = None,
    upper: float | None = None,
    p: float = 0.95,
    rule: Rule = INTERVAL,
) -> Verdict:
    """Return the verdict by intervals that are not Student's about the value, such as those of a profile.

    A guard factor stretches the interval about the value, a false-accept risk takes the interval of that probability
    (half of the risk on each side where there are two limits). No specific risk is stated: it would take the whole
    distribution.

    Parameters
    ----------
    interval_at : callable
        Probability -> two-sided interval; None where there is none of that probability.
    value, u : float or None
        What was measured.
    lower, upper : float or None
        Limits, in the same unit.
    p : float
        Probability of the rule.
    rule : Rule
        Decision rule, without a process.

    Raises
    ------
    PlanError
        If there is no limit, or they are not numbers in order.
    """
    _check_limits(lower, upper)
    both = lower is not None and upper is not None
    words = _words(rule, p, both)
    nothing = Verdict("INCONCLUSIVE", value, u, None, None, lower, upper, words, basis=Basis(words))
    shown = _shown_level(rule, p, both)
    interval = interval_at(shown)
    if interval is None:
        return replace(nothing, reason="no interval is estimated")
    lo, hi = ends(interval)
    ratio = uncertainty_ratio(0.5 * (hi - lo), lower, upper)
    rule = applied(rule, 0.5 * (hi - lo), lower, upper)
    if rule.name == "interval":
        accept = interval
    elif rule.name == "false_accept_risk":
        level = round(1.0 - rule.risk * (1.0 if both else 2.0), 12)
        wide = None if rule.process is not None else interval_at(level)
        if wide is None:
            return replace(nothing, interval=interval, reason=f"no interval of {100.0 * level:g} % is estimated")
        accept = wide
    elif value is None:
        return replace(nothing, interval=interval, reason="the value is not estimated")
    else:
        factor = rule.factor if rule.name == "guard_factor" else 0.0
        accept = Interval(value - factor * (value - lo) if factor else value,
                          value + factor * (hi - value) if factor else value, interval.p)  # fmt: skip
    return _judged(rule, value, u, None, interval, accept, accept, lower, upper, None, ratio, words)


def no_change(
    difference: float | None,
    u: float | None,
    dof: float | None,
    allowed: float | None,
    p: float = 0.95,
    rule: Rule = INTERVAL,
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
    rule : Rule
        Decision rule; the limits are ± allowed.

    Raises
    ------
    PlanError
        If the allowed change is not a positive number.
    """
    if allowed is None:
        reason = "no allowed change is stated: without one, no measurement can show that nothing changed"
        return Verdict("INCONCLUSIVE", difference, u, dof, rule=_words(rule, p, both=True), reason=reason)
    if not (allowed > 0.0 and math.isfinite(allowed)):
        raise PlanError(f"allowed change {allowed:g}", do="Need a positive number")
    return decide(difference, u, dof, -allowed, allowed, p, rule)


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


def _shown_level(rule: Rule, p: float, both: bool) -> float:
    """Return the probability of the interval that is shown: both its ends are one-sided bounds where one is a limit."""
    return p if both or rule.name != "interval" else round(2.0 * p - 1.0, 12)


def _words(rule: Rule, p: float, both: bool) -> str:
    if rule is not INTERVAL and rule != INTERVAL:
        return str(rule)
    return _interval_words(p, both)


@lru_cache(maxsize=64)
def _interval_words(p: float, both: bool) -> str:
    if both:
        return (
            f"JCGM 106, guarded: PASS if the {100 * p:g} % interval lies inside the limits, "
            "FAIL if wholly outside, else INCONCLUSIVE"
        )
    return (
        f"JCGM 106, guarded: PASS if the one-sided {100 * p:g} % bound lies inside the limit, "
        "FAIL if the bound on the other side lies outside, else INCONCLUSIVE"
    )


def _judged(
    rule: Rule,
    value: float | None,
    u: float | None,
    dof: float | None,
    interval: Interval,
    accept: Interval,
    reject: Interval,
    lower: float | None,
    upper: float | None,
    outside: float | None,
    ratio: float | None,
    words: str,
) -> Verdict:
    """Return the verdict of a value with its guard bands; ``outside``: probability that it lies outside the limits."""
    lo, hi = ends(accept)
    low = -math.inf if lower is None else lower
    high = math.inf if upper is None else upper
    status: Status = "INCONCLUSIVE"
    what = "value" if lo == hi else "interval" if rule == INTERVAL else "value with its guard band"
    if low <= lo and hi <= high:
        status, reason = "PASS", f"the {what} lies inside the limits"
    elif ends(reject)[1] < low or ends(reject)[0] > high:
        status, reason = "FAIL", f"the {what} lies outside the limits"
    elif rule.binary:
        status, reason = "FAIL", f"the {what} does not lie inside the limits"
    elif hi - lo > high - low:
        reason = f"the {what} is wider than the limits: u is too large for any value to PASS"
    else:
        reason = f"the {what} reaches over a limit: u is too large to decide"
    risk = None if outside is None else {"PASS": outside, "FAIL": 1.0 - outside}.get(status)
    at = math.nan if value is None else value
    possible = hi - lo <= high - low
    basis = Basis(
        words,
        None if lower is None or not possible else finite(lower + (at - lo)),
        None if upper is None or not possible else finite(upper - (hi - at)),
        risk,
        ratio,
        reject if status == "FAIL" and not rule.binary else accept,
    )
    return Verdict(status, value, u, dof, interval, lower, upper, words, reason, basis)

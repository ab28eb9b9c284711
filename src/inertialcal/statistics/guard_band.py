"""Guard band of a decision rule: how far inside its limits a value must lie to PASS, how far outside to FAIL.

With limits T, standard uncertainty u of ``dof`` degrees of freedom and U = k u, half of the 95 % interval (the one
that holds for all places together where a requirement is about a range)::

    interval                 w = U; with one limit the one-sided 95 % bound (normal: 0.82 U, as ISO 14253-1:2017)
    simple_acceptance        w = 0
    guard_factor             w = r U                                                      (ILAC-G8, table 1)
    false_accept_risk        P(true value outside the limits | value at T - w) = risk     (JCGM 106, 8.3.2)
      with a process         P(value accepted and true value outside) = risk, w >= 0      (JCGM 106, 9.5; Z540.3, 5.3 b)
    test_uncertainty_ratio   w = 0 where (T_U - T_L) / 2 U >= N, else that of another rule

PASS from ``T_L + w`` to ``T_U - w``; FAIL beyond ``T_L - w`` or ``T_U + w``. What it assumes: the error of the
measurement is Student's t times u, and a value tells of the true one nothing but by this measurement (specific risk),
or the process is normal as stated (global risk). What breaks it, each simulated in its test:

- an uncertainty that leaves something out: the risk holds for what is stated, not for the table that nobody stated;
- a process that is wider, or has heavier tails, than stated: the global risk is that of the stated process, the
  specific risk holds for every process at its limit;
- several decisions: over a range each place has the stated risk to PASS wrongly (a requirement PASSes only where every
  place does, so that its own risk is no larger), and FAIL is Sidak's; over many requirements the risks add up.

References
----------
.. [1] JCGM 106:2012, Evaluation of measurement data - The role of measurement uncertainty in conformity assessment,
   clauses 7 to 9.
.. [2] ILAC-G8:09/2019, Guidelines on decision rules and statements of conformity, clause 4 and table 1.
.. [3] ISO 14253-1:2017, Decision rules for verifying conformity or nonconformity with specifications.
.. [4] ANSI/NCSL Z540.3-2006, Requirements for the calibration of measuring and test equipment, 5.3 b.
.. [5] Dobbert, A guard-band strategy for managing false-accept risk, NCSLI Measure 3 (2008), no. 4.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import special

from ..core.errors import DataError
from ..core.judging import LEVEL, Rule
from ..core.show.rounding import freedom
from .intervals import coverage_factor, t_quantile

NODES = 2000  # of the scatter's distribution, in steps of equal probability
INTERVAL = Rule()
SIMPLE = Rule("simple_acceptance")
GRID = np.polynomial.legendre.leggauss(120)  # of a tail of the process, in standard deviations
FAR = 8.0  # standard deviations of a process that count
SIZES = 160  # of u at which a guard band that is not in proportion to it is solved; interpolated between them


class GuardBand(NamedTuple):
    """Half widths about a value, in its unit; infinite where no value can PASS."""

    accept: float
    reject: float


def guard_band(
    rule: Rule, u: float, dof: float, lower: float | None, upper: float | None, p: float = LEVEL
) -> GuardBand:
    """Return the guard band of a value whose error is Student's t.

    Parameters
    ----------
    rule : Rule
        With its process in the unit of the limits (`Rule.within`).
    u, dof : float
        Standard uncertainty and its degrees of freedom.
    lower, upper : float or None
        Limits.
    p : float
        Probability of the 95 % interval at this place: more where several places are judged together.
    """
    both = lower is not None and upper is not None
    rule = applied(rule, coverage_factor(dof, p) * u, lower, upper)
    if rule.name == "simple_acceptance":
        return GuardBand(0.0, 0.0)
    if rule.name == "guard_factor":
        band = rule.factor * coverage_factor(dof, p) * u
        return GuardBand(band, band)
    if rule.name == "interval":
        band = (coverage_factor(dof, p) if both else t_quantile(dof, p)) * u
        return GuardBand(band, band)
    if rule.normal is not None:
        band = _global_band(rule.risk, rule.normal, u, dof, lower, upper)
        return GuardBand(band, band)
    reject = t_quantile(dof, (1.0 - rule.risk) ** (1.0 / places(p))) * u
    return GuardBand(_specific_band(rule.risk, u, dof, lower, upper), reject)


def applied(rule: Rule, half: float, lower: float | None, upper: float | None) -> Rule:
    """Return the rule that a test uncertainty ratio leads to; every other rule as it is."""
    if rule.name != "test_uncertainty_ratio":
        return rule
    ratio = uncertainty_ratio(half, lower, upper)
    return SIMPLE if ratio is not None and ratio >= rule.ratio else rule.fallback


def places(p: float) -> float:
    """Return for how many independent places an interval of this probability holds 95 % together (Sidak)."""
    return max(math.log(LEVEL) / math.log(p), 1.0)


def uncertainty_ratio(half: float, lower: float | None, upper: float | None) -> float | None:
    """Return the test uncertainty ratio: span of the limits over 2 U; None with one limit, or no U."""
    if lower is None or upper is None or not half > 0.0:
        return None
    return (upper - lower) / (2.0 * half)


def pass_probability(
    true_value: float,
    u: float,
    dof: float,
    lower: float | None = None,
    upper: float | None = None,
    p: float = LEVEL,
    rule: Rule = INTERVAL,
) -> float:
    """Return how often a rule says PASS for a true value: outside the limits, its risk of a false PASS.

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
        Probability of the 95 % interval.
    rule : Rule
        With its process in the unit of the limits.

    Raises
    ------
    DataError
        If ``u`` is not positive, or there are no degrees of freedom.
    """
    if not (math.isfinite(true_value) and 0.0 < u < math.inf and dof > 0.0):
        raise DataError(
            f"probability of PASS at {true_value:g}: u = {u:g} with {freedom(dof)}",
            do="Need a finite value, u above 0 and degrees of freedom above 0",
            code="no_uncertainty",
        )
    guard = _bands(rule, u * scatter_ratios(dof), dof, lower, upper, p)
    with np.errstate(invalid="ignore"):
        below = 1.0 if upper is None else special.ndtr((upper - guard - true_value) / u)
        outside = 0.0 if lower is None else special.ndtr((lower + guard - true_value) / u)
    return float(np.mean(np.where(np.isfinite(guard), np.maximum(below - outside, 0.0), 0.0)))


def scatter_ratios(dof: float) -> NDArray[np.float64]:
    """Found over true standard uncertainty, at the middle of steps of equal probability."""
    if math.isinf(dof):
        return np.ones(1)
    middle = (np.arange(NODES) + 0.5) / NODES
    return np.asarray(np.sqrt(special.chdtri(dof, middle) / dof), dtype=float)


def _bands(
    rule: Rule, sizes: NDArray[np.float64], dof: float, lower: float | None, upper: float | None, p: float
) -> NDArray[np.float64]:
    """Return the guard band to PASS at each standard uncertainty found."""
    if rule.name == "test_uncertainty_ratio":
        half = coverage_factor(dof, p) * sizes
        reached = np.array([uncertainty_ratio(one, lower, upper) or 0.0 for one in half]) >= rule.ratio
        return np.where(reached, 0.0, _bands(rule.fallback, sizes, dof, lower, upper, p))
    both = lower is not None and upper is not None
    if rule.normal is None and not (rule.name == "false_accept_risk" and both):  # in proportion to u
        return guard_band(rule, 1.0, dof, lower, upper, p).accept * sizes
    few = np.sort(sizes)[:: max(sizes.size // SIZES, 1)]
    return np.interp(sizes, few, [guard_band(rule, float(one), dof, lower, upper, p).accept for one in few])


def _root(excess: Callable[[float], float], low: float, high: float) -> float:
    """Return where it is zero between two ends at which its signs differ."""
    from scipy.optimize import brentq  # noqa: PLC0415 - starts slowly

    return float(brentq(excess, low, high))


def _specific_band(risk: float, u: float, dof: float, lower: float | None, upper: float | None) -> float:
    """Return the band at which the true value lies outside the limits, on either side, with that risk."""
    band = t_quantile(dof, 1.0 - risk) * u
    if lower is None or upper is None:
        return band
    half = 0.5 * (upper - lower)

    def excess(w: float) -> float:
        return below(-w / u, dof) + below(-(2.0 * half - w) / u, dof) - risk

    if excess(half) > 0.0:
        return math.inf
    return band if excess(band) <= 0.0 else _root(excess, band, half)


def _global_band(
    risk: float, normal: tuple[float, float], u: float, dof: float, lower: float | None, upper: float | None
) -> float:
    """Return the band with which of all items this part at most is accepted and does not conform; never negative."""
    mean, sd = normal
    at, weights = GRID
    outside: list[tuple[NDArray[np.float64], NDArray[np.float64]]] = []  # true values beyond a limit, and their share
    for limit, sign in ((upper, 1.0), (lower, -1.0)):
        if limit is not None:
            start = max(sign * (limit - mean) / sd, -FAR)
            if start < FAR:
                z = start + 0.5 * (FAR - start) * (at + 1.0)
                share = weights * 0.5 * (FAR - start) * np.exp(-0.5 * z**2) / math.sqrt(2.0 * math.pi)
                outside.append((mean + sign * sd * z, share))

    def excess(w: float) -> float:
        total = 0.0
        for true, share in outside:
            high = 1.0 if upper is None else _below((upper - w - true) / u, dof)
            low = 0.0 if lower is None else _below((lower + w - true) / u, dof)
            total += float(np.sum(share * np.maximum(high - low, 0.0)))
        return total - risk

    if excess(0.0) <= 0.0:
        return 0.0
    if lower is not None and upper is not None:
        half = 0.5 * (upper - lower)
        return _root(excess, 0.0, half)  # nothing is accepted at half the span
    most = t_quantile(dof, 1.0 - 0.1 * risk) * u
    while excess(most) > 0.0:
        most *= 2.0
    return _root(excess, 0.0, most)


def below(t: float, dof: float) -> float:
    """Return the probability that Student's t lies below a number."""
    return float(special.ndtr(t) if math.isinf(dof) else special.stdtr(dof, t))


def _below(t: NDArray[np.float64], dof: float) -> NDArray[np.float64]:
    return np.asarray(special.ndtr(t) if math.isinf(dof) else special.stdtr(dof, t), dtype=float)

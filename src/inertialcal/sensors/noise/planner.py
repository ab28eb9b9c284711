"""What a record of a given length shows of each noise term, and how long to record for one of them.

``forecast`` is the covariance of the fit (``likelihood``) to overlapping Allan variances at octaves, as the terms
themselves imply it: it knows that terms hide behind each other. Relative errors are standard uncertainties over values.
A term counts as *shown* where that of its size is at most a quarter: the square of the size, of which the Allan
variance is made, then lies two standard deviations from zero.

``plan_record`` gives four lengths, from coarse to fine:

- the standard's rule [1]_, eq. (C.22): an Allan deviation at tau has the relative error
  ``1 / sqrt(2 (T / tau - 1))`` in a record of T;
- the same from the exact equivalent degrees of freedom of the overlapping Allan variance, ``1 / sqrt(2 edf)``;
- what a fit of all terms together gives, if the terms are known;
- the same, but long enough for the choice of terms to name the term in 95 % of records as well (``separation``): the
  one to plan by if you do not know the terms beforehand.

A term that gives the share s of the Allan variance at tau is known from that one deviation to ``error / s``: the first
two rules are applied to the averaging time that asks for the shortest record.

References
----------
.. [1] IEEE Std 952-1997, Annex C, eq. (C.22).
.. [2] Q. H. Vuong, Econometrica 57 (1989) 307: likelihood ratios of models that are not nested.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np
from scipy import special

from ...core.errors import DataError, PlanError
from ...core.estimate import Array
from ...core.show.rounding import number
from ...core.show.tables import Block, Table, html, text
from .expected import variance_of_phase
from .fitting.allan_covariance import covariance_of_allan, model_edf
from .fitting.likelihood import mean_of, sandwich_of
from .fitting.order import NAMES, PRICE, ranked, separable, unknowns
from .fitting.problem import GAUSS_MARKOV, Run, problem_of
from .fitting.stack import Stack
from .terms import Sinusoid, Term, total_phase

LONGEST = 2.0**34  # samples of a record that is still planned
PRECISION = 1e-3  # of a record length
ROUGH = 0.02  # of one in which a term is named
LEAST = 24  # samples of a record from which terms are chosen
SHOWN = 0.25  # relative error of a size that is shown to be there
SPANS = 3  # longest averaging time of the octaves, in its lengths that a record holds
NOISE_EDF = 1.5  # degrees of freedom of an averaging time that a record holds, most of all noises (white)
STEP = 1e-4  # relative, of the derivative for a parameter that the variance is not a power of
SCALES = ("coefficient", "sigma", "amplitude")  # parameters whose square the Allan variance is proportional to
GIVEN = ("frequency",)  # parameters known before a fit
SEVERAL = ("gauss_markov", "sinusoid")  # terms that there may be several of
NAMED = 0.95  # of records
CHOSEN_FROM = (*NAMES, GAUSS_MARKOV)


@dataclass(frozen=True)
class RecordPlan:
    """How long to record for one term."""

    term: str  # Which
    relative_error: float  # That is wanted of its size
    fit: float  # Record for a fit of all terms together [s]; infinite where no practical record is long enough
    # Record in which the term is also named in 95 % of cases, among all that there are to choose from: `fit` or
    # longer [s]
    record: float
    standard: float  # Record by IEEE 952 (C.22) [s]
    standard_tau: float  # Averaging time at which that reads the term [s]
    exact: float  # Record from the exact degrees of freedom [s]
    exact_tau: float  # Averaging time at which that reads the term [s]

    def parts(self) -> tuple[Block, ...]:
        """Return what is shown: a row a rule."""
        rows = [
            ("known, and named among all terms", number(self.record, 4), number(self.record / 3600.0, 3), "-"),
            ("fit of all terms, given", number(self.fit, 4), number(self.fit / 3600.0, 3), "-"),
            ("IEEE 952 (C.22)", number(self.standard, 4), number(self.standard / 3600.0, 3),
             number(self.standard_tau, 4)),
            ("exact degrees of freedom", number(self.exact, 4), number(self.exact / 3600.0, 3),
             number(self.exact_tau, 4)),
        ]  # fmt: skip
        caption = f"record length for {self.term} to {100.0 * self.relative_error:.3g} %"
        return (Table(("rule", "record [s]", "record [h]", "read at tau [s]"), rows, caption, (1, 2, 3)),)

    def __str__(self) -> str:
        """Return a table with a row a rule."""
        return text(self.parts())

    __repr__ = __str__

    def _repr_html_(self) -> str:
        """Return the same table for a notebook."""
        return html(self.parts())


def plan_record(
    terms: tuple[Term, ...], term: str, relative_error: float, interval: float, averaging: float | None = None
) -> RecordPlan:
    """Return how long to record to know the size of one term to a relative error.

    Parameters
    ----------
    terms : tuple of Term
        All of the sensor, with values from a data sheet or a first record [SI].
    term : str
        Which of them: ``"rate_random_walk"``.
    relative_error : float
        Standard uncertainty of its coefficient, standard deviation or amplitude, over the value.
    interval : float
        Time from sample to sample [s].
    averaging : float, optional
        Averaging time of a sample [s]; the interval by default.

    Raises
    ------
    PlanError
        If the term is not among those given, or the error is not positive.
    """
    check_terms(terms)
    if not relative_error > 0.0:
        raise PlanError(f"a relative error of {relative_error:g}", do="It must be positive, such as 0.1")
    at = next((i for i, one in enumerate(terms) if one.name == term), None)
    if at is None:
        raise PlanError(f"no term {term!r}", do=f"There are: {', '.join(one.name for one in terms)}")
    column = sum(len(free_parameters(one)) for one in terms[:at])

    def fitted(record: float) -> float:
        try:
            return float(relative_errors(terms, record, interval, averaging)[column])
        except DataError:  # too short for so many unknowns
            return np.inf

    shortest = interval * SPANS * 2.0 ** (1 + sum(len(free_parameters(one)) for one in terms))
    fit = _shortest(fitted, relative_error, shortest, LONGEST * interval)
    standard, exact = _single(terms, at, relative_error, interval, averaging)
    record = _named(terms, term, fit, interval, averaging)
    return RecordPlan(term, relative_error, fit, record, *standard, *exact)


def _named(terms: tuple[Term, ...], term: str, fit: float, interval: float, averaging: float | None) -> float:
    """Return the record in which a term is named in 95 % of cases, not less than one that gives the error wanted."""
    if not np.isfinite(fit) or not can_be_chosen(terms, term):
        return fit

    def lacking(record: float) -> float:
        return -separation(terms, term, record, interval, averaging)

    return _shortest(lacking, 0.0, max(fit, LEAST * interval), LONGEST * interval, ROUGH)


def _single(
    terms: tuple[Term, ...], at: int, relative_error: float, interval: float, averaging: float | None
) -> tuple[tuple[float, float], tuple[float, float]]:
    """Shortest record, and the time it is read at, that one Allan deviation needs: by the standard, and exactly."""
    m: Array = np.exp2(np.arange(int(np.log2(LONGEST)) - 2, dtype=np.float64))
    phase = total_phase(terms, interval, averaging)
    share = variance_of_phase(total_phase((terms[at],), interval, averaging), m) / variance_of_phase(phase, m)
    tau = m * interval
    usable = (relative_error * share) ** 2 > 0.0
    rules = np.where(usable, tau * (1.0 + 0.5 / np.where(usable, relative_error * share, 1.0) ** 2), np.inf)
    best = int(np.argmin(rules))
    standard = (float(rules[best]), float(tau[best]))
    exact = (np.inf, float(tau[best]))
    for i in range(max(0, best - 2), min(len(m), best + 3)):
        if not usable[i]:
            continue
        size = m[i : i + 1]

        def error(record: float, size: Array = size, part: float = float(share[i])) -> float:
            sigma = covariance_of_allan(phase, size, np.floor(record / interval + 1e-9) - 2.0 * size + 1.0)
            return float(1.0 / np.sqrt(2.0 * model_edf(variance_of_phase(phase, size), sigma)[0]) / part)

        record = _shortest(error, relative_error, 2.0 * float(tau[i]), LONGEST * interval)
        exact = min(exact, (record, float(tau[i])))
    return standard, exact


def _shortest(
    error: Callable[[float], float], wanted: float, shortest: float, longest: float, precision: float = PRECISION
) -> float:
    """Return the shortest record with at most the error that is wanted, between two bounds; infinite beyond."""
    if error(shortest) <= wanted:
        return shortest
    low, high = shortest, 4.0 * shortest
    while not error(high) <= wanted:
        low, high = high, 4.0 * high
        if high > longest:
            return np.inf
    while high > (1.0 + precision) * low:
        middle = float(np.sqrt(low * high))
        low, high = (low, middle) if error(middle) <= wanted else (middle, high)
    return high


@dataclass(frozen=True)
class Known:
    """What a record tells of one parameter."""

    # ``"random_walk"``, ``"coefficient"``
    term: str
    parameter: str
    value: float  # That was assumed [SI]
    relative_error: float  # Standard uncertainty of a fit of all terms, over the value
    shown: bool  # Whether the term is shown to be there: relative error of its size at most a quarter


@dataclass(frozen=True)
class Forecast:
    """What a record of one length tells of all terms."""

    record: float  # Length [s]
    interval: float  # From sample to sample [s]
    known: tuple[Known, ...]  # One a parameter

    def of(self, term: str, parameter: str = "") -> Known:
        """One parameter; the first of the term where none is named.

        Raises
        ------
        PlanError
            If it is not among them.
        """
        for one in self.known:
            if one.term == term and parameter in {"", one.parameter}:
                return one
        there = ", ".join(f"{one.term} {one.parameter}" for one in self.known)
        raise PlanError(f"no parameter {term} {parameter}".rstrip(), do=f"There are: {there}")

    def parts(self) -> tuple[Block, ...]:
        """Return what is shown: a row a parameter."""
        heads = ("term", "parameter", "value [SI]", "relative error", "shown")
        rows = [
            (one.term, one.parameter, number(one.value, 4), number(one.relative_error, 2), "yes" if one.shown else "no")
            for one in self.known
        ]
        caption = f"what {number(self.record, 5)} s at {number(1.0 / self.interval, 5)} Hz tell, all terms fitted"
        return (Table(heads, rows, caption, (2, 3)),)

    def __str__(self) -> str:
        """Return a table with a row a parameter."""
        return text(self.parts())

    __repr__ = __str__

    def _repr_html_(self) -> str:
        """Return the same table for a notebook."""
        return html(self.parts())


def forecast(terms: tuple[Term, ...], record: float, interval: float, averaging: float | None = None) -> Forecast:
    """Return what a record tells of each term, if the noise is that of the terms given.

    Parameters
    ----------
    terms : tuple of Term
        All of the sensor, with values from a data sheet or a first record [SI].
    record, interval : float
        Length of the record, time from sample to sample [s].
    averaging : float, optional
        Averaging time of a sample [s]; the interval by default.

    Raises
    ------
    DataError
        ``too_short`` if the record has fewer averaging times than unknowns.
    PlanError
        If there is no term, or one twice.
    """
    check_terms(terms)
    errors = relative_errors(terms, record, interval, averaging)
    at = iter(errors)
    known = []
    for term in terms:
        names = free_parameters(term)
        each = [float(next(at)) for _ in names]
        values = [float(getattr(term, name)) for name in names]
        shown = bool(each[0] <= SHOWN)
        known += [Known(term.name, n, v, e, shown) for n, v, e in zip(names, values, each, strict=True)]
    return Forecast(record, interval, tuple(known))


def free_parameters(term: Term) -> tuple[str, ...]:
    """Return the parameters of a term that a fit finds, its size first."""
    return tuple(name for name in term.parameters if name not in GIVEN)


@lru_cache(64)
def relative_errors(terms: tuple[Term, ...], record: float, interval: float, averaging: float | None) -> Array:
    """Return the relative standard uncertainty of each free parameter of each term, in order.

    Raises
    ------
    DataError
        ``too_short`` if the record has fewer averaging times than unknowns.
    """
    n = int(record / interval + 1e-9)
    m = octaves(n)
    slopes = np.stack(
        [_slope(term, name, m, interval, averaging) for term in terms for name in free_parameters(term)], axis=1
    )
    if len(m) < slopes.shape[1]:
        what = f"a record of {record:g} s: {len(m)} averaging times for {slopes.shape[1]} unknowns"
        raise DataError(what, do="Record longer, or assume fewer terms", code="too_short")
    phase = total_phase(terms, interval, averaging)
    mean = variance_of_phase(phase, m)
    sigma = covariance_of_allan(phase, m, n - 2.0 * m + 1.0)
    edf = np.minimum(model_edf(mean, sigma), NOISE_EDF * n / m)  # the fit weighs a ramp or a line as if it were noise
    return sandwich_of(slopes, 0.5 * edf / mean**2, sigma).u


def octaves(n: int) -> Array:
    """Return averaging times 1, 2, 4, ... of a record of n samples, three of the longest fitting in [samples]."""
    return np.asarray(2.0 ** np.arange(max(1, int(np.floor(np.log2(max(n, SPANS) / SPANS))) + 1)))


def _slope(term: Term, name: str, m: Array, interval: float, averaging: float | None) -> Array:
    """Return the derivative of the Allan variance by the logarithm of a parameter."""
    if name in SCALES:
        return 2.0 * variance_of_phase(total_phase((term,), interval, averaging), m)
    changes: Any = [{name: getattr(term, name) * np.exp(sign * STEP)} for sign in (1.0, -1.0)]
    above, below = (variance_of_phase(total_phase((replace(term, **c),), interval, averaging), m) for c in changes)
    return np.asarray((above - below) / (2.0 * STEP))


def check_terms(terms: tuple[Term, ...]) -> None:
    """Refuse no terms, and a term twice that is one size only.

    Raises
    ------
    PlanError
        In both cases.
    """
    names = [term.name for term in terms]
    twice = sorted({name for name in names if names.count(name) > 1 and name not in SEVERAL})
    if not terms or twice:
        raise PlanError("no terms" if not terms else f"term {', '.join(twice)} given twice", do="Give each term once")


def can_be_chosen(terms: tuple[Term, ...], term: str) -> bool:
    """Return whether the criterion decides on a term: not on lines, nor between two terms of one name."""
    names = [one.name for one in terms]
    return term in CHOSEN_FROM and all(names.count(name) == 1 for name in names if name != Sinusoid.name)


def separation(terms: tuple[Term, ...], term: str, record: float, interval: float, averaging: float | None) -> float:
    """Return by how much the criterion is better with a term than without in all but 5 % of records.

    The Allan variances are taken as the terms expect them, and all choices without the term are fitted to them. What
    likelihood the best of these lose is expected so; in a record it scatters with the standard deviation that the
    covariance of the Allan variances gives it (to first order, as the distance of two models does [2]_). Lengths came
    out long enough, by up to twice (simulated).
    """
    n = int(record / interval + 1e-9)
    m, phase = octaves(n), total_phase(terms, interval, averaging)
    pairs = n - 2.0 * m + 1.0
    mu, sigma = variance_of_phase(phase, m), covariance_of_allan(phase, m, pairs)
    edf = np.minimum(model_edf(mu, sigma), NOISE_EDF * n / m)
    run = Run(m, mu, pairs, edf, interval, averaging or interval, np.ones(len(m)))
    problem = problem_of([run], [one.frequency for one in terms if isinstance(one, Sinusoid)])
    names = tuple(one.name for one in terms if one.name in CHOSEN_FROM)
    least, worst = float(problem.weight @ (np.log(mu) + 1.0)), np.inf
    (choices,) = ranked(Stack((problem,)), separable(problem, tuple(one for one in CHOSEN_FROM if one != term)))
    for choice in choices:
        gain = 2.0 * (choice.fitted.cost - least)
        slope = 2.0 * problem.weight * (1.0 / mean_of(problem, choice.fitted) - 1.0 / mu)
        price = PRICE * (unknowns(names) - unknowns(choice.terms))
        part = set(choice.terms) <= set(names)
        worst = min(worst, _mostly(gain, float(slope @ sigma @ slope), part) - price)
    return float(worst)


def _mostly(gain: float, variance: float, part: bool) -> float:
    """Return what a gain exceeds in all but 5 % of cases: normal, or gamma where it is never negative.

    It is not, of a choice that is a ``part`` of the terms; a rival can come out better than the truth.
    """
    if not part:
        return gain - float(special.ndtri(NAMED)) * float(np.sqrt(variance))
    if not (gain > 0.0 and variance > 0.0):
        return 0.0
    return float(special.gammaincinv(gain**2 / variance, 1.0 - NAMED)) * variance / gain

"""How long to record for a noise term to be known to a relative error.

Four answers, from coarse to fine:

- the standard's rule [1]_, eq. (C.22): an Allan deviation at tau has the relative error
  ``1 / sqrt(2 (T / tau - 1))`` in a record of T;
- the same from the exact equivalent degrees of freedom of the overlapping Allan variance, ``1 / sqrt(2 edf)``;
- what a fit of all terms together will give (``forecast``), if it is told which terms there are;
- the same, but long enough for the choice of terms to name the term in 95 % of records as well (``separation``): the
  one to plan by, for who does not know the terms beforehand.

A term that gives the share s of the Allan variance at tau is known from that one deviation to ``error / s``: the first
two rules are applied to the averaging time that asks for the shortest record.

References
----------
.. [1] IEEE Std 952-1997, Annex C, eq. (C.22).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ...core.errors import DataError, PlanError
from ...core.estimate import Array
from ...core.show.rounding import number
from ...core.show.tables import Block, Table, html, text
from ...signals.allan.deviations import KINDS
from ...signals.allan.edf import degrees_of_freedom
from .allan_of_terms import variance_of_phase
from .fitting.covariance_of_allan import covariance_of_allan, model_edf
from .fitting.separation import can_be_chosen, separation
from .forecast import SPANS, check_terms, free_parameters, relative_errors
from .terms import Term, total_phase

LONGEST = 2.0**34  # samples of a record that is still planned
PRECISION = 1e-3  # of a record length
ROUGH = 0.02  # of one in which a term is named
LEAST = 24  # samples of a record from which terms are chosen


def standard_error(record: float, tau: float) -> float:
    """Return the relative error of an Allan deviation by IEEE 952, eq. (C.22).

    Parameters
    ----------
    record, tau : float
        Length of the record, averaging time [s].

    Raises
    ------
    PlanError
        If the record is not longer than the averaging time.
    """
    if not 0.0 < tau < record:
        raise PlanError(f"a record of {record:g} s for an averaging time of {tau:g} s", do="It must be longer")
    return float(1.0 / np.sqrt(2.0 * (record / tau - 1.0)))


def standard_record(relative_error: float, tau: float) -> float:
    """Return the record length that IEEE 952, eq. (C.22), asks for [s].

    Parameters
    ----------
    relative_error : float
        Of the Allan deviation.
    tau : float
        Averaging time [s].

    Raises
    ------
    PlanError
        If the error or the time is not positive.
    """
    _check_error(relative_error)
    if not tau > 0.0:
        raise PlanError(f"an averaging time of {tau:g} s", do="It must be positive")
    return tau * (1.0 + 0.5 / relative_error**2)


def deviation_error(record: float, tau: float, interval: float, power: int = 0) -> float:
    """Return the relative error of an overlapping Allan deviation from its exact degrees of freedom.

    Parameters
    ----------
    record, tau, interval : float
        Length of the record, averaging time, time from sample to sample [s].
    power : int
        Of the noise at that time: 2 quantisation, 0 white, -1 flicker, -2 random walk of the rate.

    Raises
    ------
    PlanError
        If the record does not hold two averaging times.
    """
    n, m = int(record / interval + 1e-9), round(tau / interval)
    if m < 1 or n < 2 * m:
        raise PlanError(f"a record of {record:g} s for an averaging time of {tau:g} s, need twice as long, or longer")
    return float(1.0 / np.sqrt(2.0 * degrees_of_freedom(KINDS["overlapping"], m, n - 2 * m + 1, power)))


@dataclass(frozen=True)
class RecordPlan:
    """How long to record for one term.

    Parameters
    ----------
    term : str
        Which.
    relative_error : float
        That is wanted of its size.
    fit : float
        Record for a fit of all terms together [s]; infinite where no record that can be planned is enough.
    record : float
        Record in which the term is also named in 95 % of cases, among all that there are to choose from: `fit` or
        longer [s].
    standard, standard_tau : float
        Record by IEEE 952 (C.22), and the averaging time at which it reads the term [s].
    exact, exact_tau : float
        The same from the exact degrees of freedom [s].
    """

    term: str
    relative_error: float
    fit: float
    record: float
    standard: float
    standard_tau: float
    exact: float
    exact_tau: float

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
    _check_error(relative_error)
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
    usable = relative_error * share > 0.0
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


def _check_error(relative_error: float) -> None:
    if not relative_error > 0.0:
        raise PlanError(f"a relative error of {relative_error:g}", do="It must be positive, such as 0.1")
